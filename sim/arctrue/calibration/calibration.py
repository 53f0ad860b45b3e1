"""Calibrates a set in five steps: verify, estimate, choose orders, quantise, compare."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from arctrue.base.units import ARCSEC_PER_RAD, arcsec_per_count, rad_per_count
from arctrue.calibration import acceptance
from arctrue.calibration.capture_check import CaptureRefusedError, WholeTurns, whole_turns
from arctrue.calibration.combine import LEAST_LINE_ARCSEC
from arctrue.calibration.comparison import ReferenceComparison, compare
from arctrue.calibration.estimate import Estimate
from arctrue.calibration.fourier import fourier
from arctrue.calibration.harmonics import as_function_of_reading
from arctrue.calibration.head_separation import (
    U_DETECTION_DEFAULT_ARCSEC,
    U_NOMINAL_RAD,
    Choice,
    Separation,
)
from arctrue.calibration.least_squares import least_squares
from arctrue.calibration.selection import GAIN_LIMIT_DEFAULT, Verdict, select_orders
from arctrue.calibration.separation_by_harmonics import separation_by_harmonics
from arctrue.gateware.coefficients import Coefficients
from arctrue.generated.number_formats import LANES_DEFAULT
from arctrue.measurement.measurement_set import Capture, MeasurementSet

Method = Literal["fourier", "least_squares"]
APART_U = 4.0
"""Smallest difference, in standard uncertainties, at which two values of α contradict each
other."""
ROUNDS_MOST = 4
SETTLED_U = 0.05
"""Change of α by the harmonics, in standard uncertainties, below which the iteration ends."""
METHODS = {"fourier": fourier, "least_squares": least_squares}


@dataclass(frozen=True)
class CalibrationSettings:
    """Settings of the calibration; the defaults are equal to the defaults of the command line.

    Parameters
    ----------
    method : {"least_squares", "fourier"}, optional
        Method that estimates the amplitudes of the orders.
    runs : sequence of int, optional
        Runs of the capture; default: the runs at the lowest speed.
    most_order : int, optional
        Highest order; the orders from 1 to this order are fitted.
    lanes : int, optional
        Lanes of the gateware.
    gain_limit : float, optional
        Largest noise gain of an order, a ratio; orders with a larger gain are left out.
    separation : str, optional
        Source of the separation α of the heads. Default: the harmonics if their standard
        uncertainty is smaller than those of the index and of the nominal value. Otherwise the
        index, if the runs agree and its value is plausible and not less certain than the nominal
        value; else the nominal value.
    """

    method: Method = "least_squares"
    runs: Sequence[int] | None = None
    most_order: int = 32
    lanes: int = LANES_DEFAULT
    gain_limit: float = GAIN_LIMIT_DEFAULT
    separation: Choice | None = None


@dataclass(frozen=True)
class Calibration:
    """The outcome of a calibration.

    Parameters
    ----------
    estimate : Estimate
        Error as a function of the reading, as the gateware needs it.
    verdicts : tuple of Verdict
        One verdict for each order: whether the order is corrected and, if not, the reason.
    coefficients : Coefficients
        The coefficients that are loaded into the gateware.
    turns : tuple of WholeTurns
        The samples from which the calibration was calculated.
    comparison : ReferenceComparison or None
        Error of the reference run before and after the correction; None for a set without a
        reference run.
    separations : mapping
        The separation α from every available source.
    objections : tuple of str
        Reasons why these coefficients should not be written, one sentence each.
    warnings : tuple of str
        Warnings for the user, one sentence each.
    """

    estimate: Estimate
    verdicts: tuple[Verdict, ...]
    coefficients: Coefficients
    turns: tuple[WholeTurns, ...]
    comparison: ReferenceComparison | None
    separations: Mapping[Choice, Separation]
    """Value of α from every available source; ``estimate.separation_choice`` states which one was
    used."""
    objections: tuple[str, ...]
    """Reasons why these coefficients should not be written, one sentence each."""
    warnings: tuple[str, ...]


def calibrate(
    measurement: MeasurementSet, settings: CalibrationSettings | None = None
) -> Calibration:
    """Calibrate from the capture of a set; compare the result with the set's reference run, if any.

    Parameters
    ----------
    measurement : MeasurementSet
        A set with a capture of both heads.
    settings : CalibrationSettings, optional
        Settings of the calibration.

    Returns
    -------
    Calibration
        Orders with their uncertainty, coefficients, and comparison with the reference run.

    Raises
    ------
    CaptureRefusedError
        The capture cannot be used; the text says why.
    ValueError
        The set has no capture, counts per turn or head separation; the capture lacks a requested
        run; the requested method or separation cannot be used with this set; or the error exceeds
        the range of the gateware's formats.
    """
    settings = settings or CalibrationSettings()
    measurement = _without_masked_stations(measurement)
    capture, table = measurement.capture, measurement.table
    if capture is None:
        raise ValueError("the set has no capture: there is nothing to calibrate from")
    if table.counts_per_rev is None or table.head_separation_deg is None:
        raise ValueError("a capture needs table.counts_per_rev and table.head_separation_deg")
    turns = whole_turns(capture, table.counts_per_rev, settings.runs, settings.most_order)
    estimate, separations, warnings = _estimated(measurement, turns, settings)
    verdicts = select_orders(estimate, settings.lanes, settings.gain_limit)
    coefficients = _quantised(estimate, verdicts, table.counts_per_rev, settings.lanes)
    reference = measurement.reference
    comparison = None if reference is None else compare(reference, coefficients)
    return Calibration(
        estimate=estimate,
        verdicts=verdicts,
        coefficients=coefficients,
        turns=tuple(turns),
        comparison=comparison,
        separations=separations,
        objections=(
            *acceptance.of_separation(
                float(np.radians(table.head_separation_deg)), estimate.measured_separation_rad
            ),
            *acceptance.of_limits(coefficients),
            *acceptance.of_estimate(estimate, coefficients),
            *acceptance.of_comparison(comparison),
        ),
        warnings=(
            *warnings,
            *_separations_apart(estimate, separations),
            *_disagreements(estimate, capture),
            *_lines(estimate),
        ),
    )


def at_the_temperature_of(measurement: MeasurementSet, coefficients: Coefficients) -> Coefficients:
    """Return the coefficients that the firmware applies at the mean temperature of the reference
    run (without a reference run: of the capture), or at the reference temperature if these rows
    have no temperatures."""
    if coefficients.thermal is None:
        return coefficients
    rows = measurement.reference or measurement.capture
    celsius = None if rows is None else rows.temperature_c
    if celsius is None or not np.any(np.isfinite(celsius)):
        return coefficients.at(coefficients.thermal.reference_c)
    return coefficients.at(float(np.nanmean(celsius)))


def objections(measurement: MeasurementSet, coefficients: Coefficients) -> list[str]:
    """Return the reasons why coefficients from another source should not be written for this set's
    table.

    If the coefficients exceed limits of the firmware, only these reasons are returned. Otherwise
    the function checks the head separation of a capture. It also checks the error in the reference
    run or, in a set without a reference run, the estimate from the two heads. If the calibration
    refuses the capture, the estimate is not checked.
    """
    measurement = _without_masked_stations(measurement)
    table, capture, reference = measurement.table, measurement.capture, measurement.reference
    counts_per_rev = table.counts_per_rev
    found = acceptance.of_limits(coefficients)
    if found:
        return found
    coefficients = at_the_temperature_of(measurement, coefficients)
    if reference is not None:
        found += acceptance.of_comparison(compare(reference, coefficients))
    if capture is None or counts_per_rev is None or table.head_separation_deg is None:
        return found
    apart_counts = float(np.mean(capture.head2_counts - capture.head1_counts))
    found += acceptance.of_separation(
        float(np.radians(table.head_separation_deg)), apart_counts * rad_per_count(counts_per_rev)
    )
    if reference is not None:
        return found
    settings = CalibrationSettings(separation="measured")
    try:
        turns = whole_turns(capture, counts_per_rev, None, settings.most_order)
        estimate, _, _ = _estimated(measurement, turns, settings)
    except CaptureRefusedError:
        return found
    return found + acceptance.of_estimate(estimate, coefficients, made_of_estimate=False)


def _without_masked_stations(measurement: MeasurementSet) -> MeasurementSet:
    """Return the set without the masked rows of its reference."""
    reference = measurement.reference
    if reference is None or reference.mask is None:
        return measurement
    used = ~reference.mask
    return replace(measurement, reference=reference.where(used) if used.any() else None)


def _estimated(
    measurement: MeasurementSet, turns: Sequence[WholeTurns], settings: CalibrationSettings
) -> tuple[Estimate, dict[Choice, Separation], list[str]]:
    """Return the estimate as a function of the reading, the value of α from every source, and
    warnings."""
    table, reference = measurement.table, measurement.reference
    assert table.counts_per_rev is not None
    assert table.head_separation_deg is not None
    nominal_rad = float(np.radians(table.head_separation_deg))
    detection = table.index_detection_arcsec

    def estimated(choice: Choice | None, fixed: Separation | None) -> tuple[Estimate, list[str]]:
        assert table.counts_per_rev is not None
        estimate, warnings = METHODS[settings.method](
            turns,
            table.counts_per_rev,
            nominal_rad,
            np.arange(1, settings.most_order + 1),
            choice,
            index_detection_arcsec=U_DETECTION_DEFAULT_ARCSEC if detection is None else detection,
            index_repeatability_counts=table.index_repeatability_counts,
            by_harmonics=fixed,
        )
        if not np.isfinite(estimate.values).all():
            raise CaptureRefusedError("nan", "the fit has no finite solution")
        if estimate.function_of == "angle":
            # The conversion changes each value by less than a thousandth, so the covariance is not
            # converted.
            values = as_function_of_reading(estimate.orders, estimate.values)
            estimate = replace(estimate, function_of="reading", values=values)
        return estimate, warnings

    asked = settings.separation
    estimate, warnings = estimated(None if asked == "harmonics" else asked, None)
    if reference is None:
        by_harmonics = Separation(np.nan, np.inf, "the set has no reference run")
    else:
        by_harmonics = separation_by_harmonics(estimate, reference, table.counts_per_rev)
    better = by_harmonics.u_rad < min(
        U_NOMINAL_RAD, estimate.u_measured_separation_rad, estimate.u_head_separation_rad
    )
    if asked == "harmonics" or (asked is None and better):
        for _ in range(ROUNDS_MOST):
            estimate, warnings = estimated("harmonics", by_harmonics)
            assert reference is not None
            # The slope depends on α: calculate it again at the new α.
            again = separation_by_harmonics(estimate, reference, table.counts_per_rev)
            settled = abs(again.value_rad - by_harmonics.value_rad) < SETTLED_U * again.u_rad
            if settled or not np.isfinite(again.u_rad):
                break
            by_harmonics = again
    return (
        estimate,
        {
            "measured": Separation(
                estimate.measured_separation_rad, estimate.u_measured_separation_rad
            ),
            "nominal": Separation(nominal_rad, U_NOMINAL_RAD),
            "harmonics": by_harmonics,
        },
        warnings,
    )


def _separations_apart(estimate: Estimate, separations: Mapping[Choice, Separation]) -> list[str]:
    """Return a warning if the α in use and the α of the harmonics differ by more than APART_U
    standard uncertainties."""
    other = separations["harmonics"]
    if estimate.separation_choice == "harmonics" or not np.isfinite(other.u_rad):
        return []
    apart = (other.value_rad - estimate.head_separation_rad) * ARCSEC_PER_RAD
    u = float(np.hypot(other.u_rad, estimate.u_head_separation_rad)) * ARCSEC_PER_RAD
    if abs(apart) < APART_U * u:
        return []
    return [
        f"the head separation from the reference's harmonics differs by {apart:+.1f}″ from the one "
        f"in use: {abs(apart) / u:.1f} times the standard uncertainty of {u:.1f}″"
    ]


def _quantised(
    estimate: Estimate, verdicts: Sequence[Verdict], counts_per_rev: int, lanes: int
) -> Coefficients:
    applied = np.array([verdict.applied for verdict in verdicts], dtype=bool)
    return Coefficients.from_harmonics(
        estimate.orders[applied],
        estimate.amplitude_arcsec[applied] / arcsec_per_count(counts_per_rev),
        estimate.phase_rad[applied],
        counts_per_rev,
        lanes,
    )


def _disagreements(estimate: Estimate, capture: Capture) -> list[str]:
    orders = np.flatnonzero(estimate.disagreement > 1.0)
    if orders.size == 0:
        return []
    number = estimate.orders.size
    values = np.array([run.values[:number] - 1j * run.values[number:] for run in estimate.runs])
    apart = np.abs(values[:, None, orders] - values[None, :, orders]).max(axis=(0, 1))
    worst = int(np.argmax(apart))
    if apart[worst] < LEAST_LINE_ARCSEC:
        return []
    named = ", ".join(str(estimate.orders[i]) for i in orders[:6])
    if orders.size > 6:
        named += ", …"
    at_worst = f" at order {estimate.orders[orders[worst]]}" if orders.size > 1 else ""
    text = (
        f"the runs disagree at order{'s' if orders.size > 1 else ''} {named} by up to "
        f"{apart[worst]:.2f}″{at_worst}; the uncertainties include this"
    )
    if capture.temperature_c is not None:
        by_run = [float(capture.temperature_c[capture.run == r.run].mean()) for r in estimate.runs]
        if max(by_run) - min(by_run) > 1.0:
            text += (
                f". Their temperatures are {min(by_run):.1f} to {max(by_run):.1f} °C; "
                "--run selects runs of one temperature"
            )
    return [text]


def _lines(estimate: Estimate) -> list[str]:
    if not estimate.residual_peaks:
        return []
    lines = ", ".join(f"{order:.2f} ({a:.2f}″)" for order, a in estimate.residual_peaks)
    return [
        f"the residual of R₂ − R₁ contains lines at order {lines}, or at an order that the "
        f"sampling aliases to it; they are above order {estimate.orders[-1]} (--orders) or not "
        "fixed to the disc"
    ]
