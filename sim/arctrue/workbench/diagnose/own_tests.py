"""Tests of a name by what it says itself: one order, a constant, an error of the angle."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from arctrue.workbench.diagnose.candidate import Candidate, delta_bic
from arctrue.workbench.effects.base import Columns, Effect, FitContext, Nonlinear
from arctrue.workbench.inference.residuals import Residuals
from arctrue.workbench.inference.significance import corrected_p_value
from arctrue.workbench.observations import ReferenceRows

SEVERAL = 3
"""Orders, each beside those before it: as many as a diagnosis looks at."""
LEAST_COMMON, LEAST_OF_TWO = 3, 5
"""Least common divisor of the orders of a pattern, and of two with a local defect: three orders by
chance have one of 3 or more with the probability Σ_{d≥3} d⁻³ = 0.08, two of 5 or more with 0.22,
and that is asked only where all of them, or both and the defect, have passed every test."""


SURE_P = 1e-4
"""As sure as a lack of fit: no candidate of the catalogue has paid for it."""


def one_pattern(orders: Sequence[float], places: int = 0) -> str | None:
    """Why several orders of the disc are one shape that repeats, in words; None where they may be
    orders by themselves.

    ``places``: local defects of the disc that were named after them; the rest of the harmonics
    looks like one.
    """
    whole = sorted({round(order) for order in orders})
    if len(whole) < 2 or len(whole) + places < SEVERAL:
        return None
    common = int(np.gcd.reduce(whole))
    if common < (LEAST_COMMON if len(whole) >= SEVERAL else LEAST_OF_TWO):
        return None
    listed = ", ".join(f"{order}" for order in whole)
    return (
        f"orders {listed} are there together, all multiples of {common}: a pattern that repeats "
        "each turn with corners (many harmonics), and no order by itself"
    )


class BentScale(Effect):
    """Square and cube of the reading of the reference: its scale is bent."""

    name = "bent_scale"
    depends_on_model = True

    def column_names(self, observations: object) -> list[str]:
        """Square and cube."""
        return ["square", "cube"]

    def reference_columns(
        self, rows: ReferenceRows, nonlinear: Nonlinear, context: FitContext
    ) -> Columns:
        """Of the error that the reference reads, over its largest."""
        error: NDArray[np.float64] = context.error_arcsec(rows.angle_rad)
        share = error / max(float(np.max(np.abs(error))), 1e-12)
        return np.stack([share**2, share**3], axis=1)


def follows_the_reading(residuals: Residuals, best: Candidate, near_tie: float) -> bool:
    """A bent scale of the reference explains the rows as well as the best, and is sure by itself.

    Both beside the same noise, within ``near_tie`` of ΔBIC; of an effect that is in proportion to
    the reading, as far ahead.
    """
    rows = residuals.observations.reference
    if rows is None or residuals.observations.capture is None or best.regular is not None:
        # Without a capture nothing tells the true size of the error.
        return False
    bent = residuals.score(BentScale(), {})
    own = residuals.score(best.effect, best.nonlinear)
    if bent.rank == 0 or corrected_p_value(bent.gain, bent.rank, 1.0, 1) >= SURE_P:
        return False
    count = rows.run.size
    margin = near_tie if best.effect.depends_on_model else -near_tie
    return delta_bic(bent.gain, bent.rank, 1.0, count) > margin + delta_bic(
        own.gain, own.rank, best.trials, count
    )
