"""Finds the step to which the reading that a reference compares is rounded.

A reading is the target plus the error. If readings are rounded, the error is a sawtooth function of
the target; its values need not recur, so that :func:`display_step` does not find this step.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from arctrue.base.units import ARCSEC_PER_DEG, ARCSEC_PER_TURN
from arctrue.workbench.observations.display_step import LEAST_AGAIN

Float = NDArray[np.float64]

LEAST_READINGS = 8
"""Smallest number of different readings that show a step."""
OF_A_STEP = 0.125
"""Largest deviation of a reading from a whole number of steps, in steps: the file rounds targets
and errors. Evenly spread readings agree with a given step with a probability of 1/4 each:
LEAST_READINGS of them in one of 65,000 sets."""
SAME_ARCSEC = 1e-3
"""Differences of readings below this value count as this value: a file with seven decimals of a
degree rounds to 0.4 milliarcseconds."""


def reading_step(
    target_deg: Float, error_arcsec: Float, count_arcsec: float | None = None
) -> float:
    """Return the step of the readings in arcseconds; 0 if the readings are not rounded.

    ``target_deg``, ``error_arcsec``: (rows,). ``count_arcsec``: size of a count of the encoder;
    None if the set does not state it. The step is the count if all readings are whole counts. It is
    otherwise the distance of neighbouring readings, if all distances are whole steps and each
    reading occurs LEAST_AGAIN times on average. If the targets are whole steps too, the result is
    0: the errors are then whole steps, and :func:`display_step` finds the step.
    """
    target = ARCSEC_PER_DEG * target_deg
    readings = np.sort(np.mod(target + error_arcsec, ARCSEC_PER_TURN))
    steps = [] if count_arcsec is None else [count_arcsec]
    groups = _groups(readings)
    if groups.size >= LEAST_READINGS and readings.size >= LEAST_AGAIN * groups.size:
        # The rounding of the decimals changes the distance of two groups, but hardly the slope over
        # the whole range of the readings.
        distance = np.diff(groups)
        number = np.concatenate([[0.0], np.cumsum(np.round(distance / distance.min()))])
        steps.append(float(np.polyfit(number, groups, 1)[0]))
    if groups.size < LEAST_READINGS:
        return 0.0
    return next((s for s in steps if _whole(readings, s) and not _whole(target, s)), 0.0)


def _groups(ordered: Float) -> Float:
    """Return the means of the groups of equal readings. The distances between groups and within
    groups are separated where the sorted distances have their largest ratio."""
    distance = np.maximum(np.diff(ordered), SAME_ARCSEC)
    sizes = np.sort(distance)
    if sizes.size < 2:
        return ordered
    split = int(np.argmax(sizes[1:] / sizes[:-1]))
    first = np.flatnonzero(np.append(True, distance > sizes[split]))
    return np.asarray(np.add.reduceat(ordered, first) / np.diff(np.append(first, ordered.size)))


def _whole(values: Float, step: float) -> bool:
    """Tell whether all values are whole numbers of steps from each other, within OF_A_STEP."""
    turns = np.exp(2j * np.pi * values / step)
    away = np.abs(np.angle(turns * np.conj(np.mean(turns)))) / (2.0 * np.pi)
    return bool(np.all(away <= OF_A_STEP))
