"""Tells an effect, which repeats on every turn and run, from a disturbance that was there once."""

from __future__ import annotations

import numpy as np

from arctrue.workbench.diagnose.candidate import ACTING_SHARE, Candidate
from arctrue.workbench.inference.solution import Solution

LEAST_SHARE = 1.0 / 3.0
"""Of the gain that the other turns or runs would give if it were as large there."""
WOULD_SHOW = 16.0
"""χ² that the strongest gives, and that the others would: below it, the strongest may be noise, or
noise may hide it in the others."""


def on_every_pass(item: Candidate, base: Solution) -> bool:
    """False for an effect that one turn, or one run, shows and the others do not.

    Of an effect that acts on few rows of a turn the turns are asked, of others the runs: an order
    of the disc that is there at one speed only is a line in time, or its alias. Both solutions are
    with the noise that the effect was weighed with: another one moves the model's own orders too.
    """
    if item.evidence is not None:
        base = item.evidence.base.solution
    rows = base.observations.capture
    if rows is None or rows.revolution.size == 0 or not _acts_on_capture(item):
        return True
    before = base.capture_residual_arcsec()
    if before is None:
        return True
    change = item.solution.capture_prediction_arcsec(False) - base.capture_prediction_arcsec(False)
    # The offset of a run takes what is constant in it: of that no row of the run can tell.
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
    """It has columns in the capture: what only the reference shows moves the capture's prediction
    by what it returns to the graduation, which is in every run as far as noise lets it."""
    columns = item.solution.observations.capture
    assert columns is not None
    probe = columns.part(slice(0, 2))
    return item.effect.capture_columns(probe, item.nonlinear, item.solution.context) is not None
