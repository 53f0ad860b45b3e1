"""Finds a head that loses the same number of counts again and again.

The search for a slip finds one step. One step does not explain a run with several steps: rows that
were left out of the fit contradict it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from arctrue.base.runs import run_spans
from arctrue.workbench.inference.design_matrix import block_columns
from arctrue.workbench.inference.solution import Solution
from arctrue.workbench.observations import CaptureRows
from arctrue.workbench.observations.outliers.far_rows import NORMAL_MAD

Float = NDArray[np.float64]
Integer = NDArray[np.int64]

LEAST_STEPS = 3
"""Smallest number of steps that recur; two events may occur by chance."""
MOST_STEPS = 64
"""Largest number of steps that are fitted, to limit cost."""
SIDE = 16
"""Number of rows before and after an instant whose means are compared."""
FAR = 6.0
"""Smallest difference of these means, in robust standard deviations of all such differences: white
normal noise of known scatter exceeds it once in 5·10⁸ rows. In short runs the scatter is less
certain, because differences within 2·SIDE rows share readings; EQUAL_SIGMA and BY_CHANCE then
decide."""
ROUNDS = 4
"""Largest number of rounds of search and fit: a step hides another step that is less than
SIDE rows away."""
EQUAL_SIGMA = 3.0
"""Largest deviation of a step from a whole number of the common step, in standard uncertainties."""
MOST_AT_ONCE = 3
"""Largest number of slips at one instant: slips within SIDE rows are one step."""
BY_CHANCE = 1e-4
"""Largest probability that steps of random sizes are equal; it equals the limit of a sure lack of
fit."""


@dataclass(frozen=True)
class EqualSlips:
    """Steps of R₂ − R₁ with one sign and one whole number of counts."""

    counts: int
    """Counts of one slip, with its sign."""
    size_arcsec: float
    of_run: dict[int, int]
    """Number of slips in each run that has any."""
    speeds_deg_s: dict[int, float]
    """Speed of every run."""

    @property
    def only_when_fast(self) -> bool:
        """True if every run with slips is faster than every run without."""
        slow = [speed for run, speed in self.speeds_deg_s.items() if run not in self.of_run]
        return bool(slow) and max(slow) < min(self.speeds_deg_s[run] for run in self.of_run)

    def words(self) -> str:
        """Return the detection in words."""
        way = "falls" if self.counts < 0 else "rises"
        runs = ", ".join(f"{number} times in run {run}" for run, number in self.of_run.items())
        said = (
            f"R₂ − R₁ {way} by {abs(self.counts)} counts ({self.size_arcsec:.3g}″) again and "
            f"again, {runs}: a head loses counts, and its reading is wrong until its next index"
        )
        if not self.only_when_fast:
            return said
        fast = min(self.speeds_deg_s[run] for run in self.of_run)
        slow = max(speed for run, speed in self.speeds_deg_s.items() if run not in self.of_run)
        return (
            f"{said}; only the runs at {fast:.3g}°/s or more have such slips, not those up to "
            f"{slow:.3g}°/s"
        )


def equal_slips(solution: Solution) -> EqualSlips | None:
    """Return steps of the capture of two heads that have one sign and one whole number of counts;
    None if there are fewer than LEAST_STEPS, or if random sizes may be as equal by chance."""
    observations = solution.observations
    rows, count = observations.capture, observations.count_arcsec
    if rows is None or count is None or rows.channel is not None or observations.stored is not None:
        return None
    found = _steps(solution, rows)
    if found is None:
        return None
    places, sizes, sigmas = found
    one = float(np.median(sizes))
    for _ in range(2):
        times = np.clip(np.round(sizes / one), 1.0, MOST_AT_ONCE)
        one = float(np.sum(sizes * times) / np.sum(times**2))
    counts = round(one / count)
    if counts == 0:
        return None
    one = counts * count
    times = np.clip(np.round(sizes / one), 1.0, MOST_AT_ONCE)
    if np.any(np.abs(sizes - times * one) > EQUAL_SIGMA * sigmas):
        return None
    # The first step gives the size; the probability that another step is equal by chance is the
    # share of the sizes that its uncertainty allows.
    chance = np.minimum(2.0 * EQUAL_SIGMA * sigmas / abs(one), 1.0)
    if float(np.prod(np.sort(chance)[:-1])) > BY_CHANCE:
        return None
    of_run = {
        int(run): int(times[rows.run[places] == run].sum()) for run in np.unique(rows.run[places])
    }
    speeds = {
        int(rows.run[start]): float(np.degrees(np.median(np.abs(rows.speed_rad_s[start:end]))))
        for start, end in run_spans(rows.run)
    }
    return EqualSlips(counts, abs(one), of_run, speeds)


def _steps(solution: Solution, rows: CaptureRows) -> tuple[Integer, Float, Float] | None:
    """Return rows, sizes and standard uncertainties of the steps of R₂ − R₁; None with fewer than
    LEAST_STEPS or more than MOST_STEPS."""
    spans = run_spans(rows.run)
    offsets = np.zeros((rows.run.size, len(spans)))
    for number, (start, end) in enumerate(spans):
        offsets[start:end, number] = 1.0
    columns = block_columns(solution.terms, solution.widths, rows, solution.context)
    used = np.flatnonzero(np.any(columns != 0.0, axis=0))
    model = np.hstack([columns[:, used], offsets])
    left = solution.capture_residual_arcsec()
    assert left is not None
    places: list[int] = []
    sizes, sigmas = np.zeros(0), np.zeros(0)
    for _ in range(ROUNDS):
        differences = _differences(left, spans)
        scatter = _scatter(differences)
        if scatter == 0.0:
            return None
        new = _largest(np.nan_to_num(differences), FAR * scatter, places)
        if not new:
            break
        if len(places) + len(new) > MOST_STEPS:
            return None
        places = sorted([*places, *new])
        sizes, sigmas, left = _fitted(model, places, rows, spans)
    sure = np.abs(sizes) > FAR * sigmas
    if np.count_nonzero(sure) < LEAST_STEPS:
        return None
    if not sure.all():
        # Where a step is found some rows too early, the rows between are a second, small step.
        places = np.array(places)[sure].tolist()
        sizes, sigmas, _ = _fitted(model, places, rows, spans)
    return np.array(places), sizes, sigmas


def _fitted(
    model: Float, places: list[int], rows: CaptureRows, spans: list[tuple[int, int]]
) -> tuple[Float, Float, Float]:
    """Return sizes and standard uncertainties of the steps at ``places``, fitted together with the
    model, and the residual of every row."""
    steps = np.stack([_after(place, spans, rows.run.size) for place in places], axis=1)
    matrix = np.hstack([model, steps])
    inverse = np.linalg.pinv(matrix.T @ matrix, hermitian=True)
    fitted = inverse @ (matrix.T @ rows.difference_arcsec)
    left = rows.difference_arcsec - matrix @ fitted
    # The scatter of the differences of two means of SIDE rows gives that of a row, also if the
    # noise is correlated over these rows.
    noise = _scatter(_differences(left, spans)) * np.sqrt(SIDE / 2)
    own = slice(model.shape[1], None)
    return fitted[own], noise * np.sqrt(np.diag(inverse)[own]), left


def _differences(values: Float, spans: list[tuple[int, int]]) -> Float:
    """Return the mean of the SIDE rows from each row on, minus the mean of the SIDE rows before it;
    NaN within SIDE rows of the ends of a run."""
    found = np.full(values.size, np.nan)
    for start, end in spans:
        if end - start >= 2 * SIDE:
            total = np.concatenate([[0.0], np.cumsum(values[start:end])])
            means = (total[SIDE:] - total[:-SIDE]) / SIDE
            found[start + SIDE : end - SIDE + 1] = means[SIDE:] - means[:-SIDE]
    return found


def _scatter(differences: Float) -> float:
    """Return the robust standard deviation of the differences that exist; 0 if none exists."""
    exist = np.abs(differences[np.isfinite(differences)])
    return NORMAL_MAD * float(np.median(exist)) if exist.size else 0.0


def _largest(differences: Float, least: float, known: list[int]) -> list[int]:
    """Return the rows with the largest differences above ``least``, each SIDE rows or more from the
    others; a difference at most two rows from a known step belongs to that step."""
    size = np.abs(differences)
    for place in known:
        size[max(place - 2, 0) : place + 3] = 0.0
    found: list[int] = []
    while len(found) <= MOST_STEPS:
        place = int(np.argmax(size))
        if size[place] <= least or size[place] == 0.0:
            break
        found.append(place)
        size[max(place - SIDE, 0) : place + SIDE + 1] = 0.0
    return found


def _after(place: int, spans: list[tuple[int, int]], rows: int) -> Float:
    """Return 1 from a row to the end of its run, 0 elsewhere; (rows,)."""
    end = next(end for start, end in spans if start <= place < end)
    column = np.zeros(rows)
    column[place:end] = 1.0
    return column
