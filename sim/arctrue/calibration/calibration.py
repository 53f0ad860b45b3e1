"""The whole calibration of a set: verify, estimate, choose orders, quantise, compare."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from arctrue.calibration.capture_check import CaptureRefusedError, WholeTurns, whole_turns
from arctrue.calibration.combine import LEAST_LINE_ARCSEC
from arctrue.calibration.comparison import Comparison, compare
from arctrue.calibration.estimate import Estimate
from arctrue.calibration.fourier import fourier
from arctrue.calibration.harmonics import as_function_of_reading
from arctrue.calibration.head_separation import Choice
from arctrue.calibration.least_squares import least_squares
from arctrue.calibration.selection import GAIN_LIMIT_DEFAULT, Verdict, select_orders
from arctrue.gateware.coefficients import Coefficients
from arctrue.generated.number_formats import LANES_DEFAULT
from arctrue.measurement.measurement_set import Capture, MeasurementSet
from arctrue.units import arcsec_per_count

Method = Literal["fourier", "least_squares"]
METHODS = {"fourier": fourier, "least_squares": least_squares}


@dataclass(frozen=True)
class CalibrationSettings:
    """How to calibrate; the defaults are those of the command line.

    ``most_order``: orders 1 … most_order are fitted; ``runs``: None: those at the lowest speed;
    ``separation``: None: measured, where the index is to be believed.
    """

    method: Method = "least_squares"
    runs: Sequence[int] | None = None
    most_order: int = 32
    lanes: int = LANES_DEFAULT
    gain_limit: float = GAIN_LIMIT_DEFAULT
    separation: Choice | None = None


@dataclass(frozen=True)
class Calibration:
    """The outcome; ``estimate`` is a function of the reading, as the gateware needs it."""

    estimate: Estimate
    verdicts: tuple[Verdict, ...]
    coefficients: Coefficients
    turns: tuple[WholeTurns, ...]
    comparison: Comparison | None
    warnings: tuple[str, ...]


def calibrate(
    measurement: MeasurementSet, settings: CalibrationSettings | None = None
) -> Calibration:
    """Calibrate from the capture of ``measurement``; compare where it has a reference run.

    Raises CaptureRefusedError for a capture that cannot be used, ValueError for a set without
    one, a run that is not there or an error that the gateware's formats do not hold.
    """
    settings = settings or CalibrationSettings()
    capture, table = measurement.capture, measurement.table
    if capture is None:
        raise ValueError("the set has no capture: there is nothing to calibrate from")
    if table.counts_per_rev is None or table.head_separation_deg is None:
        raise ValueError("a capture needs table.counts_per_rev and table.head_separation_deg")
    turns = whole_turns(capture, table.counts_per_rev, settings.runs, settings.most_order)
    estimate, warnings = METHODS[settings.method](
        turns,
        table.counts_per_rev,
        float(np.radians(table.head_separation_deg)),
        np.arange(1, settings.most_order + 1),
        settings.separation,
    )
    if estimate.function_of == "angle":
        # The step changes values by less than a thousandth: the covariance stays.
        estimate = replace(
            estimate,
            function_of="reading",
            values=as_function_of_reading(estimate.orders, estimate.values),
        )
    if not np.isfinite(estimate.values).all():
        raise CaptureRefusedError("nan", "the fit has no finite solution")
    verdicts = select_orders(estimate, settings.lanes, settings.gain_limit)
    coefficients = _quantised(estimate, verdicts, table.counts_per_rev, settings.lanes)
    reference = measurement.reference
    return Calibration(
        estimate=estimate,
        verdicts=verdicts,
        coefficients=coefficients,
        turns=tuple(turns),
        comparison=None if reference is None else compare(reference, coefficients),
        warnings=(*warnings, *_disagreements(estimate, capture), *_lines(estimate)),
    )


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
        f"{apart[worst]:.2f}″{at_worst}; the uncertainties include that"
    )
    if capture.temperature_c is not None:
        by_run = [float(capture.temperature_c[capture.run == r.run].mean()) for r in estimate.runs]
        if max(by_run) - min(by_run) > 1.0:
            text += (
                f". Their temperatures are {min(by_run):.1f} to {max(by_run):.1f} °C; "
                "--run picks runs that belong together"
            )
    return [text]


def _lines(estimate: Estimate) -> list[str]:
    if not estimate.residual_peaks:
        return []
    lines = ", ".join(f"{order:.2f} ({a:.2f}″)" for order, a in estimate.residual_peaks)
    return [
        f"what is left of R₂ − R₁ holds lines at order {lines}, or at one that the sampling folds "
        f"there: above order {estimate.orders[-1]} (--orders), or not fixed to the disc"
    ]
