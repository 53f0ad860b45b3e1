"""Tells whether an oscillation of averaged rows is the alias of a faster one in the single rows.

Averaged rows show the spectrum of the single rows folded about their own sampling rate. Averaging
over a time s leaves the share sinc²(f·s) of the power at the frequency f, so that an oscillation
with a large peak may still be found at its alias.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from arctrue.workbench.inference.forward.fast_lines import MOST_CELLS
from arctrue.workbench.inference.forward.of_solution import longest_stretch
from arctrue.workbench.inference.forward.oscillation import Oscillation
from arctrue.workbench.inference.solution import Solution

Float = NDArray[np.float64]


def is_alias(solution: Solution, found: Oscillation, step_s: float) -> bool:
    """Return whether ``found``, from rows of the reference that are averaged over ``step_s``, is an
    alias.

    It is an alias if averaging leaves more power at one of the faster frequencies that have this
    alias than at the frequency of ``found``.
    """
    stretch = longest_stretch(solution)
    if stretch is None:
        return False
    time_s, left, _ = stretch
    row_s = float(np.median(np.diff(time_s)))
    fastest = 0.5 / row_s
    rates = np.arange(1, int(fastest * step_s) + 2) / step_s
    places = np.concatenate([[found.hz], rates - found.hz, rates + found.hz])
    places = places[places < fastest]
    if places.size < 2:
        return False
    cells = np.rint((time_s - time_s[0]) / row_s).astype(np.int64)
    cells = cells[cells < MOST_CELLS]
    even = np.zeros(int(cells[-1]) + 1)
    even[cells] = left[: cells.size] - np.mean(left[: cells.size])
    power = np.abs(np.fft.rfft(even)) ** 2
    length_s = even.size * row_s
    reach = 0.5 * found.hz / found.quality * length_s
    means = np.array([_mean_power(power, hz * length_s, reach) for hz in places.tolist()])
    return int(np.argmax(means * np.sinc(places * step_s) ** 2)) > 0


def _mean_power(power: Float, place: float, reach: float) -> float:
    """Return the mean power of the ordinates within ``reach`` of a place; at least of the
    nearest."""
    first = min(max(round(place - reach), 1), power.size - 1)
    return float(np.mean(power[first : max(round(place + reach), first) + 1]))
