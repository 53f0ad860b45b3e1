"""What is fixed to the disc is met on every turn; a disturbance was there once."""

from __future__ import annotations

import numpy as np

from arctrue.workbench.diagnose.candidate import ACTING_SHARE, Candidate
from arctrue.workbench.inference.solution import Solution

LEAST_SHARE = 1.0 / 3.0
"""Of the gain that the other turns would give if it were as large there."""


def on_every_pass(item: Candidate, base: Solution) -> bool:
    """False for a local effect of the disc that a single turn shows and the others do not.

    Only effects that act on few rows of a turn are asked: of the others a turn says little.
    """
    rows = base.observations.capture
    if rows is None or not item.effect.local_on_disc or rows.revolution.size == 0:
        return True
    before = base.capture_residual_arcsec()
    if before is None:
        return True
    change = item.solution.capture_prediction_arcsec(False) - base.capture_prediction_arcsec(False)
    change[np.abs(change) < ACTING_SHARE * np.abs(change).max(initial=0.0)] = 0.0
    turns = int(rows.revolution.max()) + 1
    expected = np.bincount(rows.revolution, weights=change**2, minlength=turns)
    gain = np.bincount(rows.revolution, weights=change * before, minlength=turns)
    strongest = int(np.argmax(gain))
    others = expected.sum() - expected[strongest]
    if others <= 0.0 or gain[strongest] <= 0.0 or expected[strongest] <= 0.0:
        return True
    height = gain[strongest] / expected[strongest]
    return bool((gain.sum() - gain[strongest]) > LEAST_SHARE * height * others)
