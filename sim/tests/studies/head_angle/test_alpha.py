"""Tests of the choice of the head separation α against an exhaustive search, simulated noise and a
perturbed transfer function."""

from __future__ import annotations

import json
import math
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from arctrue.calibration.transfer_function import transfer_function
from arctrue.cli import main
from arctrue.gateware.harmonic_lane import harmonic_lane
from arctrue.report.alpha_page import alpha_page, plot_alpha
from arctrue.studies.head_angle.lanes_and_bits import (
    residual_of_bits,
    residual_of_lanes,
)
from arctrue.studies.head_angle.maps import (
    Disc,
    best_choices,
    blind_orders,
    candidates_deg,
    detuned,
    gain_map,
    judged,
    least_worst_gain,
    sensitivity_map,
)

ROOT = Path(__file__).resolve().parents[4]
FOUND = json.loads((ROOT / "docs" / "data" / "alpha.json").read_text(encoding="utf-8"))
DISC = Disc.of_paper()


@pytest.mark.parametrize("most", [3, 10, 24, 40])
def test_no_alpha_beats_the_bound_and_the_candidates_reach_it(most: int) -> None:
    """No α in an exhaustive search over half a turn, in steps of 0.01°, has a smaller worst gain
    than the candidates. The candidates for 3 and 24 orders lie on this grid, those for 10 and 40
    orders between its points."""
    orders = np.arange(1, most + 1)
    worst = gain_map(np.arange(0.01, 180.0, 0.01), orders).max(axis=1)
    assert worst.min() >= least_worst_gain(most) * (1.0 - 1e-9)
    reached = gain_map(candidates_deg(most), orders).max(axis=1)
    np.testing.assert_allclose(reached, least_worst_gain(most), rtol=1e-9)


def test_blind_orders_are_those_that_close_a_turn() -> None:
    for alpha in (33, 36, 45, 120):
        expected = [n for n in range(1, 400) if n * alpha % 360 == 0]
        assert blind_orders(float(alpha), 399) == expected


def test_noise_is_that_of_drawn_differences() -> None:
    """The noise equals that of 300 simulated turns of white noise, to which the test applies the
    DFT and the transfer function; the bound is 4 standard deviations of the mean square."""
    samples, most, draws = 256, 10, 300
    random = np.random.default_rng(4)
    difference = random.normal(0.0, 0.1 * math.sqrt(2.0), (draws, samples))
    lines = np.fft.rfft(difference)[:, 1 : most + 1] / samples
    epsilon = lines * transfer_function(np.arange(1, most + 1), math.radians(33.0))
    square = 2.0 * np.sum(np.abs(epsilon) ** 2, axis=1)
    found = judged(33.0, most, DISC, samples=samples).noise_arcsec
    assert found**2 == pytest.approx(square.mean(), abs=4.0 * square.std() / math.sqrt(draws))


def test_mounting_is_that_of_a_transfer_function_at_another_alpha() -> None:
    """The stated error by a wrong mounting equals the finite difference between the transfer
    functions at two values of α."""
    alpha, off = math.radians(33.0), 1e-6
    change = transfer_function(DISC.orders, alpha + off) / transfer_function(DISC.orders, alpha)
    left = np.abs(change - 1.0) * DISC.amplitude_arcsec
    expected = math.sqrt(0.5 * float(np.sum(left**2))) / off
    found = judged(33.0, 40, DISC, u_alpha_rad=1.0).by_mounting_arcsec
    assert found == pytest.approx(expected, rel=1e-4)


def test_sensitivity_is_1_76_at_order_1_and_210_at_order_11() -> None:
    """The sensitivity at 33° equals the known values, 1.76 for order 1 and 210 for order 11."""
    found = sensitivity_map(np.array([33.0]), np.array([1, 11]))[0]
    assert found == pytest.approx([1.76, 210.0], rel=2e-3)


def test_best_choices_keep_the_heads_apart_and_are_sorted() -> None:
    found = best_choices(40, DISC)
    assert all(one.alpha_deg >= 20.0 for one in found)
    assert [one.total_arcsec for one in found] == sorted(one.total_arcsec for one in found)
    # No candidate has a smaller total if it is evaluated alone.
    assert found[0].total_arcsec == min(
        judged(alpha, 40, DISC).total_arcsec for alpha in candidates_deg(40) if alpha >= 20.0
    )


def test_the_tolerance_of_mounting_makes_the_best_gain_a_little_worse() -> None:
    """A mounting tolerance of 50″ changes the phase of order n by n·50″: by at most 40 · 50″, a
    small share of the 360°/41 between candidates."""
    best = candidates_deg(40)[10]
    share = 40 * 50 / 3600 / (360 / 41)
    assert 1.0 < detuned(best, 40) / least_worst_gain(40) < 1.0 / (1.0 - share)


def test_lanes_go_to_the_largest_orders() -> None:
    assert residual_of_lanes(DISC, 1) == pytest.approx(
        math.sqrt(0.5 * (6.0**2 + 1.2**2 + 0.7**2 + 0.5**2 + 0.35**2 + 0.2**2))
    )
    assert residual_of_lanes(DISC, 7) == 0.0


def test_bits_are_what_the_bit_true_lanes_leave() -> None:
    """The stated rounding error equals that of the bit-true model of the gateware's harmonics at
    random phases; the tolerance is 4 % of the RMS of 20,000 draws."""
    random = np.random.default_rng(9)
    amplitude = np.round(DISC.amplitude_arcsec / 0.07724762 * 2048.0)
    phase = random.integers(0, 1 << 24, (20_000, amplitude.size), dtype=np.int32)
    value = harmonic_lane(phase, amplitude.astype(np.int64), 14, 12).sum(axis=1) * 2.0 ** -(14 + 9)
    exact = (amplitude / 2048.0 * np.cos(phase * (2.0 * np.pi / (1 << 24)))).sum(axis=1)
    rms = float(np.sqrt(np.mean((value - exact) ** 2))) * 0.07724762
    assert residual_of_bits(DISC, 14, 12) == pytest.approx(rms, rel=0.04)


def test_page_and_json_agree() -> None:
    page = (ROOT / "docs" / "head-angle.md").read_text(encoding="utf-8")
    assert page == alpha_page(FOUND), "arctrue alpha --page docs/head-angle.md --json ..."


def test_command_gives_the_figures_that_are_committed(tmp_path: Path) -> None:
    answer = CliRunner().invoke(main, ["alpha", "--json", str(tmp_path / "alpha.json")])
    assert answer.exit_code == 0, answer.output
    found = json.loads((tmp_path / "alpha.json").read_text(encoding="utf-8"))
    for ours, theirs in zip(found["choices"], FOUND["choices"], strict=True):
        assert ours["given"]["worst_gain"] == pytest.approx(theirs["given"]["worst_gain"])
        assert ours["best"][0]["alpha_deg"] == pytest.approx(theirs["best"][0]["alpha_deg"])


def test_the_maps_are_drawn(tmp_path: Path) -> None:
    assert plot_alpha(FOUND, tmp_path).stat().st_size > 10_000
