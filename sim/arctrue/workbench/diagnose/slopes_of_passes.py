"""Tests whether the passes over a short arc differ by straight lines of the angle.

The model contains the curve that all passes share. A scale or a lever that changes between two
passes, for example with the temperature, leaves a straight line of the angle in each of them.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import fdtrc

from arctrue.workbench.diagnose.jumps import angle_words
from arctrue.workbench.effects.part_conditions import Condition, recorded_conditions
from arctrue.workbench.inference.solution import Solution
from arctrue.workbench.observations import ReferenceRows

Float = NDArray[np.float64]

BLOCKS = 6
"""Number of equal parts of the arc, as for the held-out blocks of a run. The scatter of their means
about the line of a pass is the noise of its slope, with four degrees of freedom a pass."""
LEAST_OF_A_BLOCK = 2
"""Fewest rows of a pass in each block: one row may be an outlier."""
SLOPES_P = 1e-4
"""Largest p at which the slopes are stated to differ; it equals the limit of a sure lack of fit."""
RANDOM_WALK = 9.64
"""F is divided by this factor. In a random walk, the mean square of the slope is larger by this
factor than that of the block means about the line (covariance min(s, t)); in white noise the two
are equal. By simulation, the true p is then at most about twice the stated p, also in the slowest
noise (test_slopes_of_passes.py)."""
DIFFERS = 3.0
"""A condition differs between two passes if the difference of its means exceeds this number of
standard deviations within the passes."""
FOLLOWS = 0.98
"""Smallest correlation, over three or more passes, at which the slopes follow a condition; the
columns of two effects count as equal at this correlation too (EQUAL_COLUMNS in
:mod:`confounded`)."""


@dataclass(frozen=True)
class SlopesOfPasses:
    """Straight lines of the angle by which the passes differ."""

    size_arcsec: float
    """Largest difference of two passes over the arc, the later pass minus the earlier one."""
    sigma_arcsec: float
    arc_deg: float
    passes: int
    conditions: Mapping[str, str]
    """Conditions that differ between two passes, or that the slopes of several passes follow; in
    words, by name."""

    def sentence(self) -> str:
        """Return the detection with the recorded conditions that may cause it."""
        size = f"{angle_words(self.size_arcsec)} over {self.arc_deg:.4g}°"
        words = f"{size} (u {angle_words(self.sigma_arcsec)})"
        if self.passes == 2:
            said = f"The two passes over the arc differ by a straight line of the angle: {words}."
            known = f"Between them {' and '.join(self.conditions.values())} differ"
            known += "s" if len(self.conditions) == 1 else ""
            nothing = "No recorded condition apart from the time differs between them."
            more = ", and so does the time."
        else:
            said = (
                f"The {self.passes} passes over the arc differ by straight lines of the angle, "
                f"by up to {words}."
            )
            known = f"The slopes follow {' and '.join(self.conditions.values())}"
            nothing = "The slopes follow no recorded condition."
            more = "."
        return f"{said} {known + more if self.conditions else nothing}"

    def next_measurement(self) -> str:
        """Return the measurement that shows what causes the difference."""
        if not self.conditions:
            return (
                "the same pass several times more, with one condition changed at a time: the slope "
                "over the angle changes with its cause"
            )
        names = " and ".join(self.conditions)
        return (
            f"the same pass once more with {names} as in the first pass: if this condition is the "
            "cause, the first slope returns; if the time or a change of the set-up is the cause, "
            "it does not"
        )


def slopes_of_passes(solution: Solution) -> SlopesOfPasses | None:
    """Return the differences of the passes over a short arc; None if the F test of the slopes is
    not significant, or if the model has no curve that passes share.

    The F test compares the slopes with the scatter of the block means about the lines.
    """
    rows, left = solution.observations.reference, solution.reference_residual_arcsec()
    shared = any(term.effect.settings.get("arc_deg") for term in solution.terms)
    if rows is None or left is None or not shared or solution.unknown_noise:
        return None
    start, arc = float(rows.target_rad.min()), float(np.ptp(rows.target_rad))
    block = np.minimum(((rows.target_rad - start) / arc * BLOCKS).astype(np.int64), BLOCKS - 1)
    passes = [
        own
        for own in _passes(rows)
        if np.bincount(block[own], minlength=BLOCKS).min() >= LEAST_OF_A_BLOCK
    ]
    if len(passes) < 2:
        return None
    means = np.array([_block_means(block[own], left[own]) for own in passes])
    line = np.arange(BLOCKS) - 0.5 * (BLOCKS - 1)
    slopes = means @ line / float(line @ line)
    about = means - means.mean(axis=1, keepdims=True) - np.outer(slopes, line)
    freedom = len(passes) - 1, len(passes) * (BLOCKS - 2)
    noise = float(np.sum(about**2)) / freedom[1]
    between = float(np.sum((slopes - slopes.mean()) ** 2)) * float(line @ line) / freedom[0]
    if fdtrc(*freedom, between / max(noise, 1e-300) / RANDOM_WALK) > SLOPES_P:
        return None
    ends = sorted((int(np.argmin(slopes)), int(np.argmax(slopes))))
    return SlopesOfPasses(
        size_arcsec=BLOCKS * float(slopes[ends[1]] - slopes[ends[0]]),
        sigma_arcsec=BLOCKS * float(np.sqrt(2.0 * noise / float(line @ line))),
        arc_deg=float(np.degrees(arc)),
        passes=len(passes),
        conditions=_conditions(solution, rows, passes, slopes),
    )


def _passes(rows: ReferenceRows) -> list[NDArray[np.int64]]:
    """Return the rows of each pass: those of one run in one direction, one after the other."""
    changes = np.diff(rows.run) != 0
    if rows.direction is not None:
        changes |= np.diff(rows.direction) != 0
    ends = np.flatnonzero(changes) + 1
    return np.split(np.arange(rows.run.size), ends)


def _block_means(block: NDArray[np.int64], values: Float) -> Float:
    total = np.bincount(block, values, BLOCKS)
    return np.asarray(total / np.bincount(block, minlength=BLOCKS))


def _conditions(
    solution: Solution, rows: ReferenceRows, passes: list[NDArray[np.int64]], slopes: Float
) -> dict[str, str]:
    """Return the conditions that differ between two passes, or that several slopes follow."""
    found: dict[str, str] = {}
    for item in recorded_conditions(solution.observations):
        values = item.values(rows)
        if values is None or (item.part == "time" and len(passes) == 2):
            continue
        means = np.array([values[own].mean() for own in passes])
        within = float(np.sqrt(np.mean([np.var(values[own]) for own in passes])))
        if len(passes) == 2:
            known = abs(float(means[1] - means[0])) > DIFFERS * max(within, 1e-12)
            # A difference that the stated figures do not show does not count.
            known = known and _figure(item, rows, means[0]) != _figure(item, rows, means[1])
        else:
            scale = float(np.std(means) * np.std(slopes))
            product = float(np.mean((means - means.mean()) * (slopes - slopes.mean())))
            known = scale > 1e-12 and abs(product) >= FOLLOWS * scale
        if known:
            found.setdefault(
                item.without_power, f"{item.without_power}{_values(item, rows, means)}"
            )
    return found


def _figure(item: Condition, rows: ReferenceRows, mean: float) -> str:
    """Return a mean of a condition in the unit of the set's column."""
    zero = rows.reference_temperature_c if item.part == "temperature" else item.column_zero
    return f"{mean + zero:.4g}"


def _values(item: Condition, rows: ReferenceRows, means: Float) -> str:
    """Return the means of a condition in two passes, in the unit of the set's column."""
    if means.size != 2 or (item.part != "temperature" and item.column is None):
        return ""
    return f" ({_figure(item, rows, means[0])} and {_figure(item, rows, means[1])})"
