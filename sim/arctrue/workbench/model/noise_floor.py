"""The noise of one row, which no model can take away: a figure of the set, not of the model.

It is the scatter of repeats: of rows at the same place. A model of what does not repeat, such as
a vibration, can leave less than that; then what the best model leaves of it is the noise.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from msgspec import structs
from numpy.typing import NDArray

from arctrue.base.runs import run_spans
from arctrue.workbench.inference.residuals import Residuals
from arctrue.workbench.model.model import Channels, HistoryStep
from arctrue.workbench.noise.repeats import capture_noise_arcsec, reference_noise_arcsec
from arctrue.workbench.observations import CaptureRows, Observations

Float = NDArray[np.float64]

_SAME_PHASE = 0.02
"""Of a signal period: within this two rows are at one phase. A subdivision error differs there by
2π·0.02 of its amplitude at most."""
_MOST_ROWS_APART = 25
"""From the place a turn on, where a row of that phase is looked for."""
_LEAST_PAIRS = 50
"""So many differences know the noise to 10 %."""


def row_noise_arcsec(residuals: Residuals, channel: str, rms_arcsec: float) -> float:
    """Standard deviation of one row of ``capture`` or ``reference``; at most what the model leaves.

    ``rms_arcsec``: of what it leaves in every row.
    """
    observations = residuals.observations
    values = residuals.capture_arcsec if channel == "capture" else residuals.reference_arcsec
    assert values is not None
    if channel == "reference":
        return min(reference_noise_arcsec(observations, values), rms_arcsec)
    # Each holds a part of an error that the other does not see, and neither less than the noise.
    at_one_phase = _at_one_phase_arcsec(observations, values)
    at_one_angle = capture_noise_arcsec(observations, values)
    return min(at_one_angle, at_one_phase or at_one_angle, rms_arcsec)


def _at_one_phase_arcsec(observations: Observations, residual: Float) -> float | None:
    """From rows of successive turns at nearly the same angle and at the same phase of the signal.

    None: too few. Rows that are a signal period apart or more have no value between them, so that
    an error within the period counts as noise wherever the later turn is interpolated.
    """
    rows = observations.capture
    assert rows is not None
    if rows.electrical1_rad is None:
        return None
    differences = [
        _turn_to_turn(rows, rows.electrical1_rad, residual, slice(first, last))
        for first, last in run_spans(rows.run)
    ]
    size = sum(item.size for item in differences)
    if size < _LEAST_PAIRS:
        return None
    square = sum(float(np.sum((item - item.mean()) ** 2)) for item in differences if item.size)
    runs = sum(item.size > 0 for item in differences)
    return float(np.sqrt(0.5 * square / (size - runs)))


def _turn_to_turn(rows: CaptureRows, electrical: Float, residual: Float, inside: slice) -> Float:
    """Later less earlier value of the rows of a run that are at one phase."""
    angle = rows.angle_rad[inside] * (1.0 if rows.direction[inside.start] > 0 else -1.0)
    phase, values = electrical[inside] / (2.0 * np.pi), residual[inside]
    ahead = angle + 2.0 * np.pi
    there = np.flatnonzero(ahead <= angle[-1])
    if not there.size or np.any(np.diff(angle) <= 0.0):
        return np.zeros(0)
    place = np.searchsorted(angle, ahead[there])
    found = np.full(there.size, -1)
    for apart in sorted(range(-_MOST_ROWS_APART, _MOST_ROWS_APART + 1), key=abs):
        later = np.clip(place + apart, 0, angle.size - 1)
        off = phase[later] - phase[there]
        same = np.abs(off - np.round(off)) <= _SAME_PHASE
        found = np.where((found < 0) & same & (later > there), later, found)
    pairs = found >= 0
    return np.asarray(values[found[pairs]] - values[there[pairs]])


def with_one_floor(history: Sequence[HistoryStep]) -> list[HistoryStep]:
    """The steps with the noise of the set that each was fitted to, the same at all of them.

    Every step has an estimate; the least is the one with the least of the error in it.
    """
    return [
        structs.replace(step, noise_arcsec=_least([o for o in history if _same_set(o, step)]))
        for step in history
    ]


def floor_of(history: Sequence[HistoryStep]) -> Channels:
    """The noise of the set of the last step, by channel."""
    return with_one_floor(history)[-1].noise_arcsec


def _same_set(one: HistoryStep, other: HistoryStep) -> bool:
    digests = {one.measurement_sha256, other.measurement_sha256} - {""}
    return one.measurement == other.measurement and len(digests) < 2


def _least(steps: Sequence[HistoryStep]) -> Channels:
    found: Channels = {}
    for step in steps:
        for channel, value in step.noise_arcsec.items():
            found[channel] = min(value, found.get(channel, value))
    return found
