"""Tests whether an effect exists on every turn, in every run and at every speed that would show it.

The tests distinguish an effect, which repeats, from a disturbance that occurred once. They also
distinguish an oscillation in time, which exists at every speed, from an order of the angle that
only one run shows.
"""

from __future__ import annotations

import numpy as np

from arctrue.workbench.diagnose.candidate import ACTING_SHARE, RUNS_ARE_THE_SAMPLE, Candidate
from arctrue.workbench.inference.solution import Solution

LEAST_SHARE = 1.0 / 3.0
"""Smallest ratio of gain to expected gain in all turns, runs or speeds except the strongest. The
expected gain is that of an effect which is as large there as in the strongest turn, run or speed.
"""
SAME_SPEED = 1.2
"""Largest ratio of two speeds that count as the same speed."""
WOULD_SHOW = 16.0
"""Smallest χ² of the strongest run, and smallest χ² expected in the other runs. With a smaller χ²,
the effect in the strongest run may be noise, or noise may hide the effect in the others. Turns are
compared without this limit."""


def on_every_pass(item: Candidate, base: Solution) -> bool:
    """Return False for an effect that one turn, or one run, shows but the others do not.

    For an effect that acts on few rows of a turn, the turns are compared; for any other effect, the
    runs. For example, an order of the disc that exists at one speed only is a line in time, or its
    alias. The solutions without and with the effect have the same noise, estimated with the effect;
    with different noise, the model's own orders would differ too.
    """
    if item.evidence is not None:
        if item.evidence.index_share >= RUNS_ARE_THE_SAMPLE:
            # The offsets of the runs show the effect. The rows of a run show only a small
            # remainder, which slow noise can exceed.
            return True
        base = item.evidence.base.solution
    rows = base.observations.capture
    if rows is None or rows.revolution.size == 0 or not _acts_on_capture(item):
        return True
    before = base.capture_residual_arcsec()
    if before is None:
        return True
    change = item.solution.capture_prediction_arcsec(False) - base.capture_prediction_arcsec(False)
    # The offset of a run absorbs an error that is constant in the run, so that no row of the run
    # can show it.
    rows_of_run = np.maximum(np.bincount(rows.run, minlength=rows.runs), 1)
    change -= (np.bincount(rows.run, weights=change, minlength=rows.runs) / rows_of_run)[rows.run]
    local = item.effect.local_on_disc
    if local:
        change[np.abs(change) < ACTING_SHARE * np.abs(change).max(initial=0.0)] = 0.0
    group = rows.revolution if local else rows.run
    count = int(group.max()) + 1
    expected = np.bincount(group, weights=change**2, minlength=count)
    gain = np.bincount(group, weights=change * before, minlength=count)
    strongest = int(np.argmax(gain))
    others = expected.sum() - expected[strongest]
    if others <= 0.0 or gain[strongest] <= 0.0 or expected[strongest] <= 0.0:
        return True
    height = gain[strongest] / expected[strongest]
    noise = base.capture_sigma_arcsec or 1.0
    least = min(float(others), float(expected[strongest]))
    if not local and height**2 * least < WOULD_SHOW * noise**2:
        return True
    return bool((gain.sum() - gain[strongest]) > LEAST_SHARE * height * others)


def _acts_on_capture(item: Candidate) -> bool:
    """Tell whether the effect has columns in the capture.

    An effect that has columns in the reference alone also changes the capture's prediction, through
    the orders of the graduation. That change is equal in every run, so that a comparison of runs
    does not test the effect.
    """
    columns = item.solution.observations.capture
    assert columns is not None
    probe = columns.part(slice(0, 2)).of_head(2)
    return item.effect.capture_columns(probe, item.nonlinear, item.solution.context) is not None


def at_other_speeds(item: Candidate) -> bool:
    """Return False for an effect with its own coefficients in each run that appears at only one of
    several speeds.

    An effect with a size and phase of its own in every run can fit any order that one single run
    contains, for instance an order that warmth causes in the warm run. A line at a fixed frequency
    would be seen at the other speeds too.
    """
    rows = item.solution.observations.capture
    if rows is None:
        return True
    own = [run is not None for run in item.effect.column_runs(item.solution.observations)]
    if rows.runs < 2 or not any(own):
        return True
    part = item.solution.part(len(item.solution.terms) - 1)
    coefficients = item.solution.coefficients[part][own].reshape(rows.runs, -1)
    counts = np.bincount(rows.run, minlength=rows.runs).astype(np.float64)
    first = np.searchsorted(rows.run, np.arange(rows.runs))
    speed = np.abs(rows.speed_rad_s[first])
    gain = counts * np.sum(coefficients**2, axis=1)
    strongest = speed[int(np.argmax(gain))]
    other = (speed > strongest * SAME_SPEED) | (speed < strongest / SAME_SPEED)
    if not other.any() or gain.sum() <= 0.0:
        return True
    expected = float(counts[other].sum() / counts.sum())
    return float(gain[other].sum() / gain.sum()) > LEAST_SHARE * expected
