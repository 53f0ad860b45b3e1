"""Tests whether an effect that is about to be named has another cause: a pattern of several orders,
a shape with corners, or a nonlinear scale of the reference."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from arctrue.workbench.diagnose.candidate import Candidate, delta_bic, sizes_arcsec
from arctrue.workbench.diagnose.detections import RegularCause
from arctrue.workbench.effects.axis_motion import SEPARATING_HEADS
from arctrue.workbench.effects.base import Columns, Effect, FitContext, Nonlinear
from arctrue.workbench.inference.residuals import Residuals
from arctrue.workbench.inference.significance import SIGNIFICANCE, corrected_p_value
from arctrue.workbench.numeric.harmonics import disc_difference, harmonic_columns
from arctrue.workbench.observations import CaptureRows, ReferenceRows
from arctrue.workbench.observations.different_stations import stations_of

SEVERAL = 3
"""Smallest number of orders of a pattern; it equals the number of effects that a diagnosis tests
one after another."""
LEAST_COMMON, LEAST_OF_TWO = 3, 5
"""Three orders count as a pattern if their common divisor is at least LEAST_COMMON; two orders with
a local defect count as a pattern if it is at least LEAST_OF_TWO. Three random orders have a common
divisor of 3 or more with a probability of at most Σ_{d≥3} d⁻³ = 0.08. Two random orders have a
common divisor of 5 or more with a probability of at most Σ_{d≥5} d⁻² = 0.22. The test is made only
where all three orders, or both orders and the defect, have passed every other test.
"""


HIGHEST_MOTION = 30
"""Highest order at which a further motion of the axis is tested; it equals the highest order of the
products of parts."""
SURE_P = 1e-4
"""Largest p of a result that counts as sure; it equals the limit for a lack of fit, and the p is
not corrected for the number of effects."""


def one_pattern(orders: Sequence[float], places: int = 0) -> str | None:
    """Explain in words why several orders of the disc are one shape that repeats; None if they may
    be separate orders.

    ``places``: number of local defects of the disc that were named after these orders; the
    remaining harmonics look like a defect.
    """
    whole = sorted({round(order) for order in orders})
    if len(whole) < 2 or len(whole) + places < SEVERAL:
        return None
    common = int(np.gcd.reduce(whole))
    if common < (LEAST_COMMON if len(whole) >= SEVERAL else LEAST_OF_TWO):
        return None
    listed = ", ".join(f"{order}" for order in whole)
    return (
        f"orders {listed} occur together, all multiples of {common}: they are harmonics of a "
        "pattern with corners that repeats each turn, not single orders"
    )


def shape_with_corners(causes: Sequence[RegularCause]) -> str | None:
    """Explain in words why the lines of a log are one shape that repeats; None if they may be
    separate lines.

    The amplitudes of the harmonics n of a jump decrease as 1/n, those of a bend as 1/n². If the
    shape repeats at an order of the model, that order itself is not a line of the search. The lines
    are then whole orders above the model's orders, at equal distances of that order. Stator slots
    or a gear, in contrast, also show a line at their base order.
    """
    lines = [line for cause in causes if not cause.in_time for line in cause.lines]
    orders = np.array([round(line.rate) for line in lines], dtype=np.int64)
    spans = np.array([line.periods / line.rate for line in lines])
    away = np.array([abs(line.rate - round(line.rate)) for line in lines]) * spans
    if np.unique(orders).size < LEAST_HARMONICS or np.any(away > OF_A_WHOLE_ORDER):
        return None
    step = int(np.gcd.reduce(np.diff(np.sort(orders))))
    places = (int(orders.max()) - int(orders.min())) // step + 1
    count = np.unique(orders).size
    by_chance = float(step) ** (1 - count) > CHANCE and count < LEAST_FILLED * places
    if int(orders.min()) <= step or by_chance:
        return None
    size = np.log([line.amplitude_arcsec for line in lines])
    slope, size_at_one = np.polyfit(np.log(orders), size, 1)
    scatter = float(np.std(size - size_at_one - slope * np.log(orders)))
    if not STEEPEST < slope < FLATTEST or scatter > MOST_SCATTER:
        return None
    listed = ", ".join(f"{order}" for order in sorted(orders.tolist()))
    return (
        f"orders {listed} occur together and decrease evenly: they are harmonics of a shape with "
        "corners that repeats each turn, not single lines"
    )


LEAST_HARMONICS = 4
"""Smallest number of lines of a shape. It is one more than SEVERAL, because the step between the
orders is not known before."""
CHANCE = 0.01
"""Largest probability step^(1 − n) that n whole orders are equal modulo a step by chance."""
LEAST_FILLED = 2.0 / 3.0
"""Smallest share of the possible orders, from the lowest line to the highest, that must be lines if
the probability of chance exceeds CHANCE. Four random whole orders with a step of 2 and a span of
twenty reach this share with a probability of 0.02."""
OF_A_WHOLE_ORDER = 0.25
"""Largest distance of a line from an integer order, in units of 1/span."""
STEEPEST, FLATTEST = -3.0, -0.25
"""Limits of the exponent of the power law that the amplitudes follow: −1 for a jump, −2 for a bend,
with a margin for noise. The search finds lines near its limit only if noise makes them larger, so
that the amplitudes seem to decrease less steeply with the order."""
MOST_SCATTER = 0.35
"""Largest standard deviation of the logarithms of the amplitudes around this power law. A line at
the limit of the search has a signal of five standard uncertainties, 0.2 in the logarithm."""


class BentScale(Effect):
    """Square and cube of the error that the reference reads; a nonlinear scale causes them."""

    name = "bent_scale"
    depends_on_model = True

    def column_names(self, observations: object) -> list[str]:
        """Return the names of the two columns, the square and the cube."""
        return ["square", "cube"]

    def reference_columns(
        self, rows: ReferenceRows, nonlinear: Nonlinear, context: FitContext
    ) -> Columns:
        """Return square and cube of the error that the reference reads, relative to its largest
        value."""
        error: NDArray[np.float64] = context.error_arcsec(rows.angle_rad)
        share = error / max(float(np.max(np.abs(error))), 1e-12)
        return np.stack([share**2, share**3], axis=1)


class OneWave(Effect):
    """A wave of an order of the disc, or of the reading of one head."""

    name = "one_wave"

    def __init__(self, order: int, head: int | None = None) -> None:
        """Make the wave of a head, counted from 1, or of the disc."""
        super().__init__()
        self.order, self.head = order, head

    def column_names(self, observations: object) -> list[str]:
        """Return the names of cosine and sine."""
        return ["cos", "sin"]

    def capture_columns(
        self, rows: CaptureRows, nonlinear: Nonlinear, context: FitContext
    ) -> Columns:
        """Return the wave in the difference of a head and head 1."""
        if self.head is None:
            return disc_difference(rows.line1_rad, rows.line2_rad, [self.order])
        share = -1.0 if self.head == 1 else float(self.head == rows.head)
        return np.asarray(share * harmonic_columns(rows.angle_rad, [self.order]))

    def reference_columns(
        self, rows: ReferenceRows, nonlinear: Nonlinear, context: FitContext
    ) -> Columns | None:
        """Return the wave in the reading of head 1."""
        if self.head is None:
            return harmonic_columns(rows.line_rad, [self.order])
        return harmonic_columns(rows.angle_rad, [self.order]) if self.head == 1 else None


def further_motion(best: Candidate, left: Residuals, matters_arcsec: float) -> str | None:
    """Explain in words why an axis motion of some orders is a part of a motion of further orders;
    None if it may be the whole motion.

    ``left``: residuals with the effect in the model. Three heads distinguish an order of the axis
    from an order of the disc. A further order must be significant, larger than the negligible size,
    and explain more than a wave of the disc or of a single head. With two heads and a reference,
    :func:`_harmonics_of_two_heads` finds the further orders.
    """
    observations, effect = left.observations, best.effect
    capture = observations.capture
    if not effect.moves_axis or capture is None:
        return None
    own, usual = effect.settings.get("orders"), effect.defaults.get("orders")
    if not isinstance(own, Sequence) or not isinstance(usual, Sequence):
        return None
    if observations.heads < SEPARATING_HEADS:
        return _as_further(own, _harmonics_of_two_heads(best, max(usual), left, matters_arcsec))
    orders = range(max(usual) + 1, HIGHEST_MOTION + 1)
    motions = [type(effect)(orders=[order]) for order in orders]
    scores = left.scores([(motion, {}) for motion in motions])
    rows, found = capture.run.size, []
    for order, motion, score in zip(orders, motions, scores, strict=True):
        if corrected_p_value(score.gain, score.rank, float(len(orders)), 1) >= SURE_P:
            continue
        moved = sizes_arcsec(left.solution, left.solution_with(motion, {}, score))
        if max(moved.values(), default=0.0) < matters_arcsec:
            continue
        waves = [OneWave(order, head) for head in (None, *range(1, observations.heads + 1))]
        gains = [
            delta_bic(item.gain, item.rank, 1.0, rows)
            for item in (score, *left.scores([(wave, {}) for wave in waves]))
        ]
        if gains[0] > max(gains[1:]):
            found.append(order)
    return _as_further(own, found)


def _as_further(own: Sequence[int], found: Sequence[int]) -> str | None:
    """Return the further orders of a motion in words; None without further orders."""
    if not found:
        return None
    further, every = (", ".join(map(str, items)) for items in (found, sorted({*own, *found})))
    return (
        f"the axis also moves at order {further}: a translation of the axis that repeats at "
        f"orders {every}"
    )


def _harmonics_of_two_heads(
    best: Candidate, highest: int, left: Residuals, matters_arcsec: float
) -> list[int]:
    """Return the orders above ``highest`` that a motion has as harmonics of its lowest order; empty
    if it may have none.

    Capture and reference separate the motion from the disc at the orders that both determine: the
    orders of the model up to half the stations. A motion that repeats at its lowest order k has
    only multiples of k. The multiples must be significant and larger than the negligible size
    together, while the orders that no multiple causes at the stations are not significant; face
    errors of a polygon change all orders.
    """
    own = best.effect.integers("orders")
    rows, lowest = left.observations.reference, min(own)
    if rows is None or lowest < 2 or any(order % lowest for order in own):
        return []
    stations = rows.faces or stations_of(np.degrees(rows.target_rad))
    disc = {
        round(order)
        for term in left.solution.terms
        for order in term.effect.disc_orders(term.nonlinear)
        if 2 <= order <= stations / 2.0
    }
    multiples = range(lowest, HIGHEST_MOTION + 1, lowest)
    seen = {abs((order + stations // 2) % stations - stations // 2) for order in multiples}
    tested = sorted(order for order in disc if order > highest and order % lowest == 0)
    others = sorted(disc - set(own) - seen)
    if not tested:
        return []
    kind = type(best.effect)
    further, every = kind(orders=tested), kind(orders=sorted([*tested, *others]))
    score, of_every = left.scores([(further, {}), (every, {})])
    moved = sizes_arcsec(left.solution, left.solution_with(further, {}, score))
    if (
        corrected_p_value(score.gain, score.rank, 1.0, 1) >= SURE_P
        or max(moved.values(), default=0.0) < matters_arcsec
    ):
        return []
    more, rank = of_every.gain - score.gain, of_every.rank - score.rank
    if rank > 0 and corrected_p_value(more, rank, 1.0, 1) < SIGNIFICANCE:
        return []
    alone = left.scores([(kind(orders=[order]), {}) for order in tested])
    return [
        order
        for order, item in zip(tested, alone, strict=True)
        if corrected_p_value(item.gain, item.rank, float(len(tested)), 1) < SIGNIFICANCE
    ]


def follows_the_reading(residuals: Residuals, best: Candidate, near_tie: float) -> bool:
    """Tell whether a nonlinear scale of the reference explains the rows as well as the best effect.

    The scale must be significant. The scale and the effect are scored with the same noise. ΔBIC of
    the nonlinear scale may be up to ``near_tie`` behind; if the best effect is itself proportional
    to the reading, the nonlinear scale must be ``near_tie`` ahead.
    """
    rows = residuals.observations.reference
    if rows is None or residuals.observations.capture is None or best.regular is not None:
        # Without a capture the true size of the error is not known.
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
