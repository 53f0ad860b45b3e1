"""Finds the products of parts (condition × wave, fixed to a frame) that explain most of a model's
residual variance."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from arctrue.workbench.diagnose.condition_forms import columns_with_forms
from arctrue.workbench.diagnose.high_lines import gains_with, high_lines
from arctrue.workbench.diagnose.parts_range import only_cancels, passes_its_wave, resolved_orders
from arctrue.workbench.diagnose.turned import turned_products
from arctrue.workbench.effects.part_conditions import (
    Condition,
    column_condition,
    conditions,
    settling_condition,
)
from arctrue.workbench.effects.product_of_parts import FRAME_OF_HEAD, Frame, ProductOfParts
from arctrue.workbench.inference.channels import channel_rows
from arctrue.workbench.inference.residuals import Residuals
from arctrue.workbench.inference.scan.maximum import highest
from arctrue.workbench.numeric.harmonics import BLOCK_ROWS, harmonic_columns
from arctrue.workbench.observations import CaptureRows, Observations
from arctrue.workbench.observations.different_stations import stations_of
from arctrue.workbench.observations.polygon_faces import keep_to_faces

Float = NDArray[np.float64]

HIGHEST_ORDER = 30
"""Highest order of the angle of a product; all half and whole orders up to it are tried."""
CONDITIONS_OF_A_LINE = 3
"""Number of conditions that are scored exactly with a line of a high order, after the constant
one."""
ELECTRICAL_MULTIPLES = (1.0, 2.0)
"""Multiples of the signal period. The first is an offset of sine and cosine, the second a
difference of gain or phase."""
SHORTLIST = 8
"""Largest number of products that are returned. The noise is estimated anew for the best product
only, so that more products would only take time.
"""
LEAST_ARC_RAD = 1.5 * np.pi
"""Smallest arc of a reference run that counts as a whole turn."""
SETTLING_STEP = 1.6
"""Largest factor by which the refinement may increase or decrease the time constant τ of a
settling, exp(−t/τ)."""
SETTLING_ROUNDS = 12
"""Largest number of steps in the search of a time constant, to limit cost."""
FRAME_MARGIN = 6.0
"""ΔBIC by which a frame must be ahead to replace a frame that comes earlier in :func:`_frames`:
odds of 20 to 1."""


@dataclass(frozen=True)
class PartsCandidate:
    """A product of parts with its gain, and the number of products in the scan (``trials``)."""

    effect: ProductOfParts
    gain: float
    rank: int
    trials: float
    level_trials: float
    """Number of trials by which the product's p is corrected: see :func:`level_share`."""


def _half_orders() -> Float:
    return np.arange(1, 2 * HIGHEST_ORDER + 1) / 2.0


def level_share(order: float | None) -> float:
    """Return an order's share of a condition's false-alarm probability; None: product without
    order.

    An order's share is proportional to 1/order, so that each octave gets the same share: discs,
    bearings and belts deform in a few waves. The product without an order gets as much as order one
    half. The shares do not depend on the set, and add up to 1.
    """
    orders = _half_orders()
    total = 1.0 + float(np.sum(orders[0] / orders))
    return (1.0 if order is None else float(orders[0] / order)) / total


def condition_shares(found: Sequence[Condition], further: int = 0) -> list[float]:
    """Return the share of the false-alarm probability for each condition; the shares of the
    conditions and of ``further`` other kinds of products add up to 1.

    Each kind of condition gets the same share. The settlings exp(−t/τ) from one start (of the set
    or of each run) divide one share among their time constants, the changes between two runs among
    the pairs of runs, and the forms of a column (its square, its size) among themselves.
    """
    kinds = [_kind(item) for item in found]
    sizes = Counter(kinds)
    return [1.0 / ((len(sizes) + further) * sizes[kind]) for kind in kinds]


def share_of_forms(observations: Observations) -> float:
    """Return the share of the false-alarm probability of the forms of recorded conditions."""
    further = bool(turned_products(observations)) + bool(columns_with_forms(observations))
    kinds = condition_shares(conditions(observations), further)
    channels = (observations.capture is not None) + (observations.reference is not None)
    return (1.0 - sum(kinds)) / max(further * channels, 1)


def _kind(condition: Condition) -> tuple[str, str]:
    if condition.time_constant_s is not None:
        return "settling", str(condition.each_run)
    if condition.form:
        return "form", condition.column or ""
    return ("run", "") if condition.from_run is not None else (condition.words, "")


def _waves(residuals: Residuals, factors: Sequence[Float], *, capture: bool) -> tuple[Float, Float]:
    """Return the approximate gain of each condition with each order, and without a wave.

    Shapes (conditions, orders), with all half and whole orders, and (conditions,).
    """
    observations, noise = residuals.observations, residuals.solution.noise
    rows = observations.capture if capture else observations.reference
    precise = residuals.capture_precise if capture else residuals.reference_precise
    of_rows = noise.capture if capture else noise.reference
    assert rows is not None
    assert precise is not None
    assert of_rows is not None
    orders = _half_orders()
    channels = rows.channels if isinstance(rows, CaptureRows) else 1
    sums = np.zeros((channels, len(factors), 2 * orders.size))
    constant = np.zeros((channels, len(factors)))
    for start in range(0, precise.size, BLOCK_ROWS):
        block = slice(start, start + BLOCK_ROWS)
        weighted = np.stack([factor[block] * precise[block] for factor in factors])
        halves = range(1, orders.size + 1)
        waves = harmonic_columns(0.5 * rows.angle_rad[block], halves)
        for channel, inside in enumerate(channel_rows(rows, block)):
            sums[channel] += weighted[:, inside] @ waves[inside]
            constant[channel] += weighted[:, inside].sum(axis=1)
    information = np.full((len(factors), orders.size), 1e-30)
    information_of_constant = np.full(len(factors), 1e-30)
    for part, spectrum in zip(of_rows.stretches, of_rows.spectra, strict=True):
        if part.stop - part.start < 2:
            continue
        step_s = of_rows.step(part)
        way = float(np.median(np.abs(np.diff(rows.angle_rad[part])))) / (2.0 * np.pi)
        density = spectrum.density(orders * (way / max(step_s, 1e-300)), step_s)
        level = of_rows.mean_square_scale(part)
        squares = np.array([float(np.sum(factor[part] ** 2)) for factor in factors])
        information += squares[:, np.newaxis] / (density * level)
        information_of_constant += squares / (
            float(spectrum.density(np.zeros(1), step_s)[0]) * level
        )
    # Each channel has its share of the information, and the gains of the channels add up.
    power = channels * np.sum(sums[..., ::2] ** 2 + sums[..., 1::2] ** 2, axis=0)
    return 2.0 * power / information, channels * np.sum(
        constant**2, axis=0
    ) / information_of_constant


def _capture_waves(residuals: Residuals, factors: Sequence[Float]) -> tuple[Float, Float]:
    return _waves(residuals, factors, capture=True)


def _reference_waves(residuals: Residuals, factors: Sequence[Float]) -> tuple[Float, Float]:
    rows = residuals.observations.reference
    assert rows is not None
    orders = _half_orders()
    power, constants = _waves(residuals, factors, capture=False)
    target_deg = np.degrees(rows.target_rad)
    stations = rows.faces or stations_of(target_deg)
    if stations <= 2 * HIGHEST_ORDER and keep_to_faces(stations, rows.run, target_deg):
        # An order n and its alias faces − n look the same at the faces (or at stations in equal
        # steps), so that only the lower order is scored. The order of the faces is a constant.
        power[:, orders > stations / 2.0] = 0.0
    arc = float(np.ptp(rows.target_rad))
    if arc < LEAST_ARC_RAD:
        # On an arc, an order that does not complete a period is only a slow curve.
        power[:, orders * arc < 2.0 * np.pi] = 0.0
    return power, constants


def _frames(order: float | None, observations: Observations, in_reference: bool) -> list[Frame]:
    """Return the frames to test, the most natural frame first; the first frame is chosen if the
    data cannot decide."""
    frames: list[Frame] = []
    if observations.capture is not None and not in_reference:
        further = [FRAME_OF_HEAD[head] for head in range(3, observations.heads + 1)]
        heads: list[Frame] = ["head2", "head1", *further]
        if order is None:
            frames = heads
        elif order == round(order):
            frames = ["disc", "stator", *heads]
        else:
            # The disc closes after a turn: a half order cannot be fixed to it.
            frames = ["stator", *heads, "disc"]
    if observations.reference is not None and in_reference:
        frames.append("reference")
    if observations.capture is None and not frames:
        frames = ["reference"]
    return frames


def _scored(
    residuals: Residuals, effect: ProductOfParts, tried: float, share: float
) -> PartsCandidate:
    """Score a product. ``share`` is the share of its condition in the false-alarm probability of
    its channel."""
    score = residuals.score(effect, {})
    share *= level_share(effect.orders[0] if effect.orders else None)
    return PartsCandidate(effect, score.gain, score.rank, tried, 1.0 / share)


def _natural(frames: Sequence[PartsCandidate], rows: int) -> PartsCandidate:
    """Return the first of ``frames`` whose evidence is at most FRAME_MARGIN below that of the best
    frame. A later, less natural frame is returned only if the data support it.
    """
    evidences = [item.gain - item.rank * np.log(rows) for item in frames]
    return next(
        item
        for item, value in zip(frames, evidences, strict=True)
        if value > max(evidences) - FRAME_MARGIN
    )


def best_parts(residuals: Residuals, *, look_alikes: bool = False) -> list[PartsCandidate]:
    """Return the products of parts with the largest gains, best first.

    ``look_alikes``: also return products that a simpler condition describes about as well.
    """
    observations = residuals.observations
    found = conditions(observations)
    channels = (observations.capture is not None) + (observations.reference is not None)
    turned = turned_products(observations)
    further = bool(turned) + bool(columns_with_forms(observations))
    kinds = condition_shares(found, further)
    shares = [share / max(channels, 1) for share in kinds]
    places: list[tuple[float, Condition, float | None, bool]] = []
    certain: list[tuple[float, Condition, float | None, bool]] = []
    tried = 0.0
    for in_reference, rows, waves in (
        (False, observations.capture, _capture_waves),
        (True, observations.reference, _reference_waves),
    ):
        if rows is None:
            continue
        usable: list[Condition] = []
        factors: list[Float] = []
        for condition in found:
            values = condition.values(rows)
            if values is not None and float(np.abs(values).max(initial=0.0)) > 0.0:
                usable.append(condition)
                factors.append(values)
        orders, constants = waves(residuals, factors)
        if in_reference and observations.reference is not None:
            for index, factor in enumerate(factors):
                resolved = resolved_orders(observations.reference, factor, _half_orders())
                orders[index, ~resolved] = 0.0
        tried += orders.size + constants.size
        for index, condition in enumerate(usable):
            best = np.argsort(orders[index])[::-1][:3]
            places += [
                (float(orders[index, k]), condition, float(_half_orders()[k]), in_reference)
                for k in best
                if orders[index, k] > 0.0
            ]
            # The residuals do not show a constant of each run, because the offsets of the runs were
            # subtracted: such a product is always scored exactly.
            if condition.from_run is None:
                # A change of the zero between two runs is a step, which has a search of its own.
                certain.append((float(constants[index]), condition, None, in_reference))
    places.sort(key=lambda place: -place[0])
    scored: list[PartsCandidate] = []
    chosen = [
        [
            ProductOfParts.of(condition, () if order is None else (order,), frame)
            for frame in _frames(order, observations, in_reference)
            if order is not None or frame != "stator"
        ]
        for _, condition, order, in_reference in [*places[: 2 * SHORTLIST], *certain]
    ]
    residuals.scores([(effect, {}) for effects in chosen for effect in effects])
    for effects in chosen:
        tried_frames = [
            _scored(residuals, effect, tried, shares[found.index(effect.condition)])
            for effect in effects
        ]
        if tried_frames:
            scored.append(_natural(tried_frames, observations.rows))
    electrical = [
        ProductOfParts.of(condition, ELECTRICAL_MULTIPLES, FRAME_OF_HEAD[head], head)
        for condition in found
        for head in range(1, observations.heads + 1)
        if observations.capture is not None
        and observations.capture.electrical1_rad is not None
        and condition.part not in ("", "settling", "run")
    ]
    residuals.scores([(effect, {}) for effect in electrical])
    scored += [
        _scored(residuals, effect, tried, shares[found.index(effect.condition)])
        for effect in electrical
    ]
    scored += _turned(residuals, turned, tried, (1.0 - sum(kinds)) / max(further * channels, 1))
    scored = [
        item
        for item in scored
        if not only_cancels(residuals, item.effect, residuals.score(item.effect, {}))
    ]
    if look_alikes:
        return _best_of_each(scored)[:SHORTLIST]
    simple = _without_idle_conditions(scored, found, observations.rows)
    short = sorted(simple, key=lambda item: -(item.gain - 2.0 * item.rank))[:SHORTLIST]
    refined = [_refined_settling(residuals, item) for item in short[:2]] + short[2:]
    return sorted(refined, key=lambda item: -(item.gain - 2.0 * item.rank))


def _turned(
    residuals: Residuals, effects: Sequence[ProductOfParts], tried: float, share: float
) -> list[PartsCandidate]:
    """Score the products that turn with a column; they divide ``share`` among the columns, both
    signs, and one or all orders. Of the products with the same column and sign, only that with the
    best BIC is returned, because all orders together always leave the least error."""
    names = Counter(effect.turned_by for effect in effects)
    tried += len(effects)
    share /= 2.0 * max(len(names), 1)
    log_rows = np.log(max(residuals.observations.rows, 2))
    best: dict[str, PartsCandidate] = {}
    for item in (_scored(residuals, effect, tried, share) for effect in effects):
        before = best.get(item.effect.turned_by)
        gained = item.gain - item.rank * log_rows
        if before is None or gained > before.gain - before.rank * log_rows:
            best[item.effect.turned_by] = item
    return list(best.values())


def parts_above(residuals: Residuals) -> list[PartsCandidate]:
    """Return the products of the sure lines of the capture above HIGHEST_ORDER, best first.

    They only describe an error that no effect of the catalogue explains: high orders of the disc
    and lines of one head are effects of the catalogue.
    """
    rows = residuals.observations.capture
    lines, orders = high_lines(residuals, float(HIGHEST_ORDER))
    if rows is None or not lines:
        return []
    found = conditions(residuals.observations)
    channels = 1 + (residuals.observations.reference is not None)
    shares = [share / channels for share in condition_shares(found)]
    named = _with_columns_from_zero([*zip(found, shares, strict=True)])
    usable: list[tuple[Condition, float]] = []
    factors: list[Float] = []
    for condition, share in named:
        values = condition.values(rows)
        if values is not None and float(np.abs(values).max(initial=0.0)) > 0.0:
            usable.append((condition, share))
            factors.append(values)
    tried = float(orders * len(usable))
    scored = []
    for order in lines:
        gains = gains_with(residuals, factors, order)
        best = np.argsort(-gains[1:])[:CONDITIONS_OF_A_LINE] + 1
        # The constant condition comes first in the list: a simpler product may explain as much.
        for index in (0, *best.tolist()):
            condition, share = usable[index]
            frames = [
                _scored(residuals, ProductOfParts.of(condition, (order,), frame), tried, share)
                for frame in _frames(order, residuals.observations, False)
            ]
            scored.append(_natural(frames, residuals.observations.rows))
    kept = [
        item
        for item in scored
        if not only_cancels(residuals, item.effect, residuals.score(item.effect, {}))
    ]
    order_of = [condition for condition, _ in named]
    simple = _without_idle_conditions(kept, order_of, residuals.observations.rows)
    return sorted(simple, key=lambda item: -(item.gain - 2.0 * item.rank))


def _with_columns_from_zero(
    named: Sequence[tuple[Condition, float]],
) -> list[tuple[Condition, float]]:
    """Return the conditions and, after them, each column without subtraction of its zero: a torque
    or a current of zero causes no error, and the model has no high order that could explain the
    subtracted part."""
    return [
        *named,
        *(
            (column_condition(item.column, 0.0), share)
            for item, share in named
            if item.column is not None and item.column_zero != 0.0 and not item.by_direction
        ),
    ]


def _best_of_each(scored: Sequence[PartsCandidate]) -> list[PartsCandidate]:
    """Return the best frame and time constant for every condition and wave, best first."""
    best: dict[tuple[str, ...], PartsCandidate] = {}
    for item in sorted(scored, key=lambda item: -(item.gain - 2.0 * item.rank)):
        best.setdefault(tuple(item.effect.parts[:-1]), item)
    return list(best.values())


def _refined_settling(residuals: Residuals, item: PartsCandidate) -> PartsCandidate:
    """If the product's condition is a settling exp(−t/τ), return the product with the time constant
    of the largest gain; otherwise return the product unchanged. The time constant is also unchanged
    if the rows cannot show a settling with the new time constant.
    """
    constant = item.effect.condition.time_constant_s
    if constant is None:
        return item

    def at(log_constant: float) -> PartsCandidate:
        condition = settling_condition(float(np.exp(log_constant)), item.effect.condition.each_run)
        effect = ProductOfParts.of(
            condition, item.effect.orders, item.effect.frame, item.effect.electrical_head
        )
        return replace(_scored(residuals, effect, item.trials, 1.0), level_trials=item.level_trials)

    low, high = (np.log(constant) + side * np.log(SETTLING_STEP) for side in (-1.0, 1.0))
    place, _ = highest(lambda log_constant: at(log_constant).gain, low, high, SETTLING_ROUNDS)
    moved = at(place)
    allowed = passes_its_wave(residuals, moved.effect) and not only_cancels(
        residuals, moved.effect, residuals.score(moved.effect, {})
    )
    return max([item, moved] if allowed else [item], key=lambda found: found.gain)


def _without_idle_conditions(
    scored: Sequence[PartsCandidate], order: Sequence[Condition], rows: int
) -> list[PartsCandidate]:
    """Omit products that a simpler condition describes about as well, with the same wave. For
    example, within a run of a minute, exp(−t/τ) with τ = 1 h is nearly constant. Of several changes
    between two runs, none is simpler: only that with the largest gain is kept."""
    changes: dict[tuple[float, ...], float] = {}
    for item in scored:
        if item.effect.condition.from_run is not None:
            changes[item.effect.orders] = max(item.gain, changes.get(item.effect.orders, 0.0))
    scored = [
        item
        for item in scored
        if item.effect.condition.from_run is None or item.gain == changes[item.effect.orders]
    ]

    def evidence_of(item: PartsCandidate) -> float:
        return float(item.gain - item.rank * np.log(rows))

    kept: list[PartsCandidate] = []
    for item in sorted(scored, key=lambda item: order.index(item.effect.condition)):
        simpler = [evidence_of(other) for other in kept if _wave(item) == _wave(other)]
        if evidence_of(item) > max(simpler, default=-np.inf) + FRAME_MARGIN:
            kept.append(item)
    return kept


def _wave(item: PartsCandidate) -> tuple[object, ...]:
    effect = item.effect
    return effect.orders, effect.electrical_head, effect.turned_by
