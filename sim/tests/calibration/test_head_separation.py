"""Tests which source determines the head separation α, how uncertain α is, and how this uncertainty
affects every order."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from arctrue.calibration import CalibrationSettings, acceptance, calibrate
from arctrue.calibration.head_separation import doubts
from arctrue.measurement import Capture, MeasurementSet

from .synthetic import ARCSEC, COUNTS, Disc, capture_of, polygon_of, set_of, turn_angles

MOVED_COUNTS = 492
"""Shift of the index in counts: 38.0″ at 2²⁴ counts per turn, about 10 µm at the disc's radius."""
DISC = Disc({1: (95.0, -1.9), 2: (0.8, 2.0), 8: (0.3, 1.0), 11: (0.6, 0.7)})
STRONG = Disc({1: (95.0, -1.9), 11: (12.0, 0.7)})
"""A disc with 12″ of order 11, large enough for the harmonics to determine α."""


def measured(disc: Disc, *, stated_arcsec: float | None = None, moved: int = 0) -> MeasurementSet:
    random = np.random.default_rng(5)
    heads = disc.heads(turn_angles(6000, 2), 0.05, random)
    heads[1] += moved
    made = set_of(disc, capture_of([heads]), polygon_of(disc, 0.05, random))
    assert made.reference is not None
    return replace(
        made,
        table=replace(made.table, index_detection_arcsec=stated_arcsec),
        reference=replace(made.reference, standard_uncertainty_arcsec=0.15),
    )


def complex_orders(values: np.ndarray) -> np.ndarray:
    cosine, sine = np.split(values, 2)
    return cosine - 1j * sine


@pytest.mark.parametrize("method", ["least_squares", "fourier"])
@pytest.mark.parametrize("stated_arcsec", [None, 19.0])
def test_a_shifted_index_is_within_the_uncertainty(method, stated_arcsec) -> None:
    """The uncertainty of an order contains the change |E_n(α + 38″) − E_n(α)| of the order that
    results if the index is detected 38″ away from its place.

    The expected change is computed independently, from E_n = D_n/(e^{jnα} − 1) at both α.
    """
    settings = CalibrationSettings(method=method, most_order=12)
    plain = calibrate(measured(DISC, stated_arcsec=stated_arcsec), settings).estimate
    shifted = calibrate(
        measured(DISC, stated_arcsec=stated_arcsec, moved=MOVED_COUNTS), settings
    ).estimate
    apart = np.abs(complex_orders(shifted.values) - complex_orders(plain.values))
    order = np.arange(1, 13)
    alpha, off = np.radians(33.0), MOVED_COUNTS * 2.0 * np.pi / COUNTS
    truth = np.abs(complex_orders(plain.values))
    expected = truth * np.abs(
        (np.exp(1j * order * alpha) - 1.0) / (np.exp(1j * order * (alpha + off)) - 1.0) - 1.0
    )
    strong = np.array([0, 1, 7])
    assert apart[strong] == pytest.approx(expected[strong], rel=0.05)
    assert apart[0] > 0.02
    # The standard uncertainty of a component is the standard uncertainty of its order divided by
    # √2.
    u_alpha = stated_arcsec or 50.0 / np.sqrt(3.0)
    assert plain.u_head_separation_rad / ARCSEC == pytest.approx(u_alpha, rel=1e-4)
    by_alpha = expected * u_alpha / (off / ARCSEC) / np.sqrt(2.0)
    assert plain.u_component_arcsec[0] == pytest.approx(by_alpha[0], rel=0.02)
    assert (plain.u_component_arcsec > by_alpha).all()


def test_two_heads_repeat_as_two_rectangles() -> None:
    """If both heads detect the index at the same place, α has the remaining uncertainty of ± 1
    count per head: √2/√3 counts."""
    estimate = calibrate(measured(DISC, stated_arcsec=0.0)).estimate
    two = np.sqrt(2.0 / 3.0) * 2.0 * np.pi / COUNTS
    assert estimate.u_head_separation_rad == pytest.approx(two, rel=1e-9)
    assert estimate.u_measured_separation_rad == pytest.approx(two, rel=0.05)


def test_the_harmonics_determine_alpha_where_they_are_strong() -> None:
    """For a disc with 12″ of order 11, the harmonics determine α with u(α) = 0.15″·|e^{j11α} −
    1|/(11·12″) = 12″; the index determines α with 29″."""
    shifted = measured(STRONG, moved=MOVED_COUNTS)
    found = calibrate(shifted)
    assert found.estimate.separation_choice == "harmonics"
    source = found.separations["harmonics"]
    of_order_11 = 0.15 * abs(np.exp(11j * np.radians(33.0)) - 1.0) / (11 * 12.0) / ARCSEC
    assert 0.9 * of_order_11 < source.u_rad / ARCSEC < 1.05 * of_order_11
    assert found.estimate.head_separation_rad == source.value_rad
    # The reference has noise of 0.05″ in 240 rows, which adds only a tenth of this uncertainty.
    assert abs(source.value_rad - np.radians(33.0)) < 0.3 * source.u_rad
    assert found.comparison is not None
    by_index = calibrate(shifted, CalibrationSettings(separation="measured"))
    assert by_index.estimate.separation_choice == "measured"
    assert by_index.comparison is not None
    # The index is shifted by 38″ = 1.85·10⁻⁴ rad, which changes order 11 by the share 210·1.85·10⁻⁴
    # = 3.9 % of its 12″.
    rms = [np.sqrt(np.mean(c.comparison.after_arcsec**2)) for c in (found, by_index)]
    assert rms[0] < 0.07
    assert rms[1] == pytest.approx(np.hypot(0.039 * 12.0 / np.sqrt(2.0), 0.055), rel=0.1)


def test_the_index_is_used_where_the_harmonics_tell_less() -> None:
    found = calibrate(measured(DISC))
    assert found.estimate.separation_choice == "measured"
    assert 28.87 < found.separations["harmonics"].u_rad / ARCSEC < 200.0
    # If the detection is less certain than the mounting, the nominal value is better.
    assert calibrate(measured(DISC, stated_arcsec=60.0)).estimate.separation_choice == "nominal"


def test_a_first_order_of_the_reference_alone_does_not_pass_for_alpha() -> None:
    """If only the reference has an error of 0.3″ of order 1, the harmonics would give an α that is
    wrong by 370″; the calibration therefore takes α from the index."""
    made = measured(DISC)
    assert made.reference is not None
    only = 0.3 * np.cos(np.radians(made.reference.target_deg) + 1.0)
    found = calibrate(
        replace(
            made, reference=replace(made.reference, error_arcsec=made.reference.error_arcsec + only)
        )
    )
    assert found.estimate.separation_choice == "measured"
    assert not [text for text in found.warnings if "harmonics" in text]


def test_harmonics_that_are_asked_for_and_not_there() -> None:
    made = measured(DISC)
    settings = CalibrationSettings(separation="harmonics")
    with pytest.raises(ValueError, match="the set has no reference run"):
        calibrate(replace(made, reference=None), settings)
    assert made.reference is not None
    unstated = replace(made, reference=replace(made.reference, standard_uncertainty_arcsec=None))
    with pytest.raises(ValueError, match="standard_uncertainty_arcsec is not given"):
        calibrate(unstated, settings)
    few = made.reference
    one_face = few.target_deg % 360.0 < 40.0
    part = replace(
        few,
        target_deg=few.target_deg[one_face],
        error_arcsec=few.error_arcsec[one_face],
        direction=None,
        head1_counts=None,
    )
    with pytest.raises(ValueError, match="all round the turn"):
        calibrate(replace(made, reference=part), settings)


def exchanged(capture: Capture) -> Capture:
    return replace(capture, head1_counts=capture.head2_counts, head2_counts=capture.head1_counts)


def test_what_the_reference_or_the_firmware_would_refuse() -> None:
    made = measured(DISC)
    assert made.capture is not None
    assert calibrate(made).objections == ()
    swapped = calibrate(replace(made, capture=exchanged(made.capture)))
    assert any("swapped" in text for text in swapped.objections)
    assert any("rises from 67" in text for text in swapped.objections)
    minus = calibrate(replace(made, table=replace(made.table, head_separation_deg=-33.0)))
    assert len(minus.objections) == 2
    # The reference belongs to another table. The firmware cannot detect this, because it has no
    # reference.
    assert made.reference is not None
    turned = replace(made.reference, error_arcsec=-made.reference.error_arcsec)
    other = calibrate(replace(made, reference=turned))
    assert len(other.objections) == 1
    assert "rises" in other.objections[0]


def test_the_gate_is_that_of_the_firmware() -> None:
    """The check refuses coefficients with the wrong sign, which double the error: the mean square
    is 4 A² instead of A²."""
    found = calibrate(measured(DISC))
    held = found.coefficients
    wrong = replace(held, amplitudes=-held.amplitudes)
    assert acceptance.of_estimate(found.estimate, held) == []
    said = acceptance.of_estimate(found.estimate, wrong)
    # The RMS error is √((95² + 0.8² + 0.3² + 0.6²)/2) = 67.18″; with the wrong coefficients it
    # doubles.
    with_them, without = (float(word[:-1]) for word in said[0].split() if word.endswith("″"))
    assert without == pytest.approx(67.18, abs=0.02)
    assert with_them == pytest.approx(2 * 67.18, abs=0.04)


@pytest.mark.parametrize(("nominal_deg", "measured_deg"), [(33.0, 33.01), (300.0, -60.01)])
def test_a_whole_turn_is_no_difference_of_the_separation(
    nominal_deg: float, measured_deg: float
) -> None:
    assert doubts(np.radians(nominal_deg), np.radians(measured_deg)) is None
    assert doubts(np.radians(nominal_deg), np.radians(measured_deg + 360.0)) is None


@pytest.mark.parametrize("measured_deg", [60.0, 420.0, -300.0])
def test_exchanged_heads_are_named_in_every_turn(measured_deg: float) -> None:
    said = doubts(np.radians(300.0), np.radians(measured_deg))
    assert said is not None
    assert "swapped" in said
