"""Tests the figures of docs/errata.md and docs/calibration.md by calculation from their
equations."""

from __future__ import annotations

import json
import math
from pathlib import Path

import numpy as np
import pytest
from scipy import stats

ROOT = Path(__file__).resolve().parents[3]
ARCSEC = 180 * 3600 / math.pi
ITERATIONS = 16
BITS = 18


def page() -> str:
    return (ROOT / "docs" / "errata.md").read_text(encoding="utf-8")


def rounding_bound(unit: float) -> float:
    """Return the bound of equation (A.5) for one rounding error of ``unit``."""
    products = (
        math.prod(math.sqrt(1 + 4.0**-i) for i in range(j, ITERATIONS))
        for j in range(1, ITERATIONS)
    )
    return unit * (1 + sum(products))


def test_resolution() -> None:
    assert pytest.approx(0.0772, abs=5e-5) == 1_296_000 / (16384 * 1024)


def test_scale_of_the_rotation() -> None:
    gain = math.prod(math.sqrt(1 + 4.0**-i) for i in range(ITERATIONS))
    assert 1 / gain == pytest.approx(0.60725, abs=5e-6)


def test_sign_of_equation_10() -> None:
    # With the sign that the paper prints, the pair (x, y) is not rotated, and the cosine is wrong.
    for sign, right in ((1, True), (-1, False)):
        x, y, z = 0.6072529, 0.0, 1.0
        for i in range(ITERATIONS):
            d = -1 if z < 0 else 1
            x, y, z = x - y * d * 2.0**-i, y + sign * x * d * 2.0**-i, z - d * math.atan(2.0**-i)
        assert (abs(x - math.cos(1.0)) < 1e-4) is right


def test_bounds_of_the_appendix() -> None:
    approximation = math.atan(2.0 ** -(ITERATIONS - 1))
    printed = approximation + rounding_bound(2.0 ** (0.5 - BITS))
    mended = approximation + rounding_bound(math.hypot(1, 1) * 2.0 ** -(BITS - 1))
    assert printed == pytest.approx(1.18e-4, abs=5e-7)
    assert mended == pytest.approx(2.06e-4, abs=5e-7)


def test_remainder_of_equation_8() -> None:
    amplitude = 150 / ARCSEC
    theta = np.arange(4096) * (2 * math.pi / 4096)
    reading = theta + amplitude * np.cos(theta)
    remainder = (reading - amplitude * np.cos(reading) - theta) * ARCSEC
    second = 2 * abs(np.fft.rfft(remainder)[2]) / len(theta)
    assert second == pytest.approx(0.055, abs=5e-4)


def test_head_separation_from_the_mean_over_readings() -> None:
    # The test uses the exact geometry and no series. The disc's centre circles the axis at a
    # distance of ``eccentricity`` radii; each head reads the direction from this centre to the
    # head.
    alpha = math.radians(33)
    eccentricity = 0.030 / (107.95 / 2)
    theta = np.arange(65536) * (2 * math.pi / 65536)
    error1 = -np.angle(1 - eccentricity * np.exp(1j * theta))
    error2 = -np.angle(1 - eccentricity * np.exp(1j * (theta + alpha)))
    difference = error2 - error1
    weight = 1 + np.gradient(error1, theta)  # The samples are uniform in the reading.
    offset = np.average(difference, weights=weight) - np.average(difference)
    assert abs(offset) * ARCSEC == pytest.approx(0.017, abs=5e-4)


def test_an_eccentric_polygon_is_no_eccentric_encoder() -> None:
    flatness, width = 0.03e-6, 10e-3
    by_equation_14 = 8 * 1e-6 * flatness / width**2 * ARCSEC
    assert by_equation_14 == pytest.approx(0.0005, abs=5e-6)
    assert 0.3 * by_equation_14 == pytest.approx(0.00015, abs=2e-6)
    assert pytest.approx(2.06, abs=5e-3) == 0.3e-6 / 30e-3 * ARCSEC
    assert 8.0 * math.sin(math.radians(1.0)) == pytest.approx(0.14, abs=5e-4)


def test_uncertainty_with_the_deviation_of_the_mean() -> None:
    u3 = 0.2 / math.sqrt(10)
    assert round(u3, 3) == 0.063
    expanded = 2 * math.sqrt(0.1**2 + 0.05**2 + u3**2 + 0.0005**2 + 0.0001**2)
    assert round(expanded, 2) == 0.26


def test_share_of_the_uncertainty() -> None:
    combined = 2 * math.sqrt(0.1**2 + 0.05**2 + 0.2**2 + 0.0005**2 + 0.0001**2)
    assert combined == pytest.approx(0.46, abs=5e-3)
    assert pytest.approx(0.29, abs=5e-3) == 0.46 / 1.6


@pytest.mark.parametrize(("order", "amplitude", "u"), [(1, 95.0, 185.0), (11, 12.0, 12.0)])
def test_head_separation_by_one_order(order: int, amplitude: float, u: float) -> None:
    """The u(α) in docs/calibration.md follows from a reference with an uncertainty of 0.15″."""
    factor = abs(np.exp(1j * order * math.radians(33)) - 1)
    assert 0.15 * factor / (order * amplitude) * ARCSEC == pytest.approx(u, rel=0.03)


def test_what_an_unknown_head_separation_does_to_order_1() -> None:
    """Limits of ±50″ give u(α) = 28.9″. An error of this size changes the amplitude of order 1
    (95″) by 0.022″, as docs/calibration.md states."""
    u_alpha = 50 / math.sqrt(3)
    assert u_alpha == pytest.approx(28.9, abs=0.05)
    # The component of dE/dα along E follows from −j e^{jα}/(e^{jα} − 1) = −(1/2)(cot(α/2) + j).
    assert 95.0 * 0.5 / math.tan(math.radians(16.5)) * u_alpha / ARCSEC == pytest.approx(
        0.022, abs=5e-4
    )


def test_phase_of_equation_9_in_all_quadrants() -> None:
    theta = np.arange(360) * (2 * math.pi / 360)
    for phase in (0.5, 2.5, -2.5, -0.5):
        spectrum = np.fft.rfft(np.cos(3 * theta + phase))[3] / theta.size
        size = 2 * abs(spectrum)
        printed = math.atan(spectrum.imag / spectrum.real)
        right = math.atan2(spectrum.imag, spectrum.real)
        error = np.cos(3 * theta + phase)
        assert abs(error - size * np.cos(3 * theta + right)).max() < 1e-12
        left = abs(error - size * np.cos(3 * theta + printed)).max()
        assert left == pytest.approx(0 if spectrum.real > 0 else 2, abs=1e-3)


def test_largest_of_the_faces_and_their_mean_variance() -> None:
    faces, cycles = 24, 10
    # Median of the largest of 24 values: a single value is below this median with the probability
    # 0.5^(1/24).
    chi_square = stats.chi2.ppf(0.5 ** (1 / faces), cycles - 1)
    ratio = math.sqrt(chi_square / (cycles - 1))
    assert ratio == pytest.approx(1.44, abs=5e-3)
    assert 0.2 / ratio == pytest.approx(0.14, abs=5e-3)


def test_limits_as_standard_uncertainties() -> None:
    arcsec = 206265
    eccentricity = 8 * 1e-6 * 0.03e-6 / 0.01**2 * arcsec
    tilt = math.radians(8 / 3600)
    tower = math.sin(math.radians(15)) * math.sin(tilt) ** 2 / math.cos(tilt) * arcsec
    assert (round(eccentricity, 4), round(tower, 4)) == (0.0005, 0.0001)
    assert round(eccentricity / math.sqrt(3), 4) == 0.0003

    def expanded(u4: float, u5: float) -> float:
        return 2 * math.sqrt(0.1**2 + 0.05**2 + 0.2**2 + u4**2 + u5**2)

    change = expanded(eccentricity, tower) - expanded(*(np.array([eccentricity, tower]) / 3**0.5))
    assert 0 < change < 1e-5


def test_a_smaller_separation_worsens_order_1() -> None:
    """A smaller head separation increases the uncertainty of order 1: the gain of equation (6) and
    the covariance of a fit agree."""
    angles = np.radians(np.arange(1, 181))
    gain = 1 / abs(np.exp(1j * angles) - 1)
    assert np.all(np.diff(gain) < 0)
    for degrees, said in ((33, 1.8), (10, 5.7), (2, 29)):
        assert 1 / (2 * math.sin(math.radians(degrees) / 2)) == pytest.approx(said, rel=0.03)
        assert gain[degrees - 1] == pytest.approx(said, rel=0.03)
    # The covariance of a fit to R₂ − R₁ with white noise gives the same result without equation
    # (6).
    theta = np.arange(360) * (2 * math.pi / 360)
    scatter = {}
    for degrees in (10, 33):
        there = theta + math.radians(degrees)
        columns = np.stack([np.cos(there) - np.cos(theta), np.sin(there) - np.sin(theta)], axis=1)
        scatter[degrees] = math.sqrt(np.trace(np.linalg.inv(columns.T @ columns)))
    assert scatter[10] / scatter[33] == pytest.approx(gain[9] / gain[32], rel=1e-9)


@pytest.mark.parametrize(("order", "gain"), [(1, 1.8), (11, 19), (109, 19)])
def test_noise_gain(order: int, gain: float) -> None:
    factor = abs(np.exp(1j * order * math.radians(33)) - 1)
    assert 1 / factor == pytest.approx(gain, rel=0.03)


def test_unseen_order() -> None:
    assert abs(np.exp(1j * 120 * math.radians(33)) - 1) < 1e-12


def test_pitch_and_diameter_of_the_disc() -> None:
    """The printed pitch and the printed diameter of the disc contradict each other by 3.5 %; the
    page states which values follow from each of them. The test uses the arc between two of the
    16,384 lines, which differs from the chord by a relative 6e-9."""
    lines, printed_mm, printed_pitch_um = 16384, 107.95, 20.0
    pitch_um = math.pi * printed_mm * 1e3 / lines
    of_lines_mm = printed_pitch_um * lines / math.pi / 1e3
    assert f"**{pitch_um:.2f} µm**" in page()
    assert f"**{of_lines_mm:.2f} mm**" in page()
    assert printed_mm / 25.4 == pytest.approx(4.25, abs=1e-12)
    columns = []
    for diameter_mm in (printed_mm, of_lines_mm):
        radius_um = diameter_mm * 500
        # An eccentricity e changes the reading with the amplitude a = e/r (equation 2), and the
        # mean of R₂ − R₁ over the readings by (a²/2) sin α.
        mean = (30 / radius_um) ** 2 / 2 * math.sin(math.radians(33)) * ARCSEC
        columns.append((ARCSEC / radius_um, 144 / ARCSEC * radius_um, mean))
    for printed, other, form in zip(*columns, ("{:.2f}″", "{:.1f} µm", "{:.3f}″"), strict=True):
        assert f"| {form.format(printed)} | {form.format(other)} |" in page()
    assert f"{100 * (columns[1][0] / columns[0][0] - 1):.1f} % larger" in page()
    assert f"{100 * (1 - columns[1][1] / columns[0][1]):.1f} % smaller" in page()


def test_accuracy_of_iso_230_is_more_than_the_range_of_means() -> None:
    experiment = json.loads((ROOT / "docs" / "data" / "paper.json").read_text("utf-8"))
    (full,) = (
        run
        for run in experiment["experiments"]
        if run["settings"]["revolution"]["interpolation"] == 1024
    )
    mean = np.array(full["after"]["mean_arcsec"])
    deviation = np.array(full["after"]["deviation_arcsec"])
    accuracy = (mean + 2 * deviation).max() - (mean - 2 * deviation).min()
    assert f"the means span {np.ptp(mean):.2f}″, and A↑ is **{accuracy:.2f}″**" in page()
    published = 1.6 + 1.3
    assert f"between {published:.1f}″ and **{published + 4 * 0.2:.1f}″**" in page()


@pytest.mark.parametrize(("heads", "unknown"), [(3, 1), (4, 0), (5, 0)])
def test_heads_that_separate_the_motion_of_the_axis(heads: int, unknown: int) -> None:
    """Four heads can separate the motion of the axis from the disc at every order except 1. At each
    order there are four complex unknowns: the true angle, the disc, and the axis' motion in two
    directions."""
    places = np.radians([0.0, 33.0, 162.5, 300.5, 71.5][:heads])
    for order in range(1, 129):
        disc = np.exp(1j * order * places)
        columns = [np.ones_like(disc), disc, np.sin(places), np.cos(places)]
        rank = np.linalg.matrix_rank(np.stack(columns, axis=1), tol=1e-6)
        # At order 1 the disc's column is a linear combination of the two columns of the motion.
        assert 4 - rank == (1 if order == 1 else unknown)
    assert "**four** are enough" in page()
