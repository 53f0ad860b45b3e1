"""Finds the measurement that would distinguish two effects which this data cannot separate.

Each plan is tested by calculation: one effect, with the size that was found, is assumed to be the
truth. The other effect is fitted to the error that the first causes in the measured and planned
rows. The remaining χ² with the noise of this set measures how well the plan distinguishes the two
effects.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from arctrue.measurement.asked import MORE_TURNS, WARMER_K
from arctrue.workbench.diagnose.candidate import Candidate
from arctrue.workbench.diagnose.planned import PLANS, PlannedMeasurement
from arctrue.workbench.diagnose.swept_columns import swept_range
from arctrue.workbench.effects.base import Nonlinear
from arctrue.workbench.effects.part_conditions import TRAVEL
from arctrue.workbench.effects.product_of_parts import ProductOfParts
from arctrue.workbench.inference.design_matrix import Term, channel_sums, term_widths
from arctrue.workbench.inference.residuals import Residuals
from arctrue.workbench.inference.search import places_of
from arctrue.workbench.inference.solution import Solution, solve
from arctrue.workbench.observations import Observations

SPLITS_CHI_SQUARE = 50.0
"""χ² that the wrong effect must leave: 7 standard deviations, so that a diagnosis finds the right
effect in spite of its corrections for many tests."""
MOST_ROWS = 300_000
"""If a set has more rows than this, no plan is tried, and the measurement that the effect itself
declares is stated."""
OF_PARTS = {
    "temperature": (
        "warm",
        "one more run with the table 4 K warmer, at the same speed and in the same direction: "
        "the error grows with the temperature",
    ),
    "speed": (
        "speed",
        "one more run at another speed, in the same direction: the error grows with the speed",
    ),
    "speed^2": (
        "speed",
        "one more run at another speed, in the same direction: at twice the speed the error is "
        "four times as large",
    ),
    "direction": ("direction", "the same run in the other direction: the error changes its sign"),
    "time": (
        "again",
        "the same run an hour later, at the same temperature: the change has continued",
    ),
    "settling": (
        "again",
        "the same run once more, after the table has stood still for ten minutes: a change that "
        "settles after each start begins anew",
    ),
}
"""Kind and description of the measurement that tests each condition of a product of parts."""
OTHER_VALUES = {
    "temperature": (
        "the same reference run at another temperature, outside the present range: the error grows "
        "with the temperature"
    ),
    "speed": (
        "the same reference run at further speeds, outside the present range: the error grows with "
        "the speed"
    ),
    "speed^2": (
        "the same reference run at further speeds, outside the present range: at twice the speed "
        "the error is four times as large"
    ),
    "direction": (
        "the same reference run with every station approached from one side, or at another speed "
        "or load: an error that changes its sign with the direction comes from the approach, not "
        "from the reference"
    ),
}
"""Measurements of a product of parts in the reference, if the set already varies its condition: a
polygon or other stations would not change such an error."""
ANOTHER_SPEED = 1.5
"""Two speeds count as different if their ratio exceeds this value; a set with two such speeds
already shows which errors grow with the speed."""
REINDEX = (
    "the same reference run with the polygon put on again some whole faces further, as a set of "
    "its own: if the fitted model then fails (compare --no-fit), the error has moved with the "
    "polygon"
)


@dataclass(frozen=True)
class NextMeasurement:
    """A measurement to make: words for people, and its kind for programs."""

    words: str
    kind: str | None
    chi_square: float | None = None
    """χ² that the wrong effect of the pair would leave in this measurement."""


@dataclass(frozen=True, eq=False)
class Question:
    """Effects that the next measurement has to distinguish.

    Without ``rivals``, the set lacks data to name ``best``.
    """

    best: Candidate
    rivals: Sequence[Candidate]


RECORD_AGAIN = NextMeasurement("record the faulty runs again", None)
WHOLE_TURNS_OF_THE_HEADS = (
    "a capture with runs of a whole turn or more; if the table cannot turn so far, a reference "
    "over its arc, up and down several times, in a set without capture"
)
"""Next measurement if the runs of a capture are arcs."""
MORE_READINGS_THAN_COEFFICIENTS = NextMeasurement(
    "the same stations once more: this set has no more readings than coefficients, so that the "
    "noise is not known (or state standard_uncertainty_arcsec)",
    None,
)
TURN_THE_REFERENCE = NextMeasurement(
    "the same places once more, with the reference turned by a few places: an error of the table "
    "stays at its place, an error of the reference moves with the reference",
    None,
)
ANOTHER_REFERENCE = NextMeasurement(
    "the same angles with another reference, or over whole turns at the same places: an error of "
    "the table repeats in each turn, and an error of the reference's scale goes on growing",
    None,
)
TURN_THE_PART_FURTHER = NextMeasurement(
    "the same stations with the part turned by further whole stations: the error moves with the "
    "part, so that it belongs to the part and not to the table",
    None,
)
TURN_THE_POLYGON = NextMeasurement(REINDEX, "polygon_reindexed")
AT_ONE_SPEED = NextMeasurement(
    "one run with five times as many samples a turn: the line appears at one speed only and may "
    "be an alias of another line",
    "samples",
)

ONE_MORE_DIGIT = NextMeasurement(
    "the same reference run, with one more digit of the instrument recorded, or with the mean of "
    "readings at several angles near each station",
    None,
)
LOOK_AT_THE_STAND = NextMeasurement(
    "the same measurement once more, with the stand, the mounts and the counter checked: a single "
    "knock does not repeat",
    "again",
)
LOOK_AT_THE_BRACKETS = NextMeasurement(
    "the same runs with the brackets and cables of the heads fixed: a head that sticks and slips "
    "then stands still",
    "again",
)
LOOK_AT_THE_DRIVE = NextMeasurement(
    "the same log with the balance, the clamps and the cables changed: a drive or a mount that "
    "sticks and slips then does so at other times, or no longer",
    None,
)
CLAMPED_AGAIN = NextMeasurement(
    "the same runs without touching heads, reference and their mounts in between: zero and order 1 "
    "then stay the same from run to run",
    "again",
)

WITH_THE_INDEX = NextMeasurement(
    "a capture across several index passes, with the index counts recorded: the faulty head counts "
    "more or fewer than counts_per_rev in a turn; then check cable, supply and input filter of "
    "this head",
    None,
)
SLOWER_WITH_THE_INDEX = NextMeasurement(
    "the fast runs once more, at speeds between the slow and the fast runs, with the index counts "
    "recorded: above a certain speed, the faulty head counts more or fewer than counts_per_rev in "
    "a turn; then check the bandwidth and the input filter of this head",
    None,
)
AT_ANOTHER_SPEED = NextMeasurement(
    "one more run at twice the speed, in the same direction: an error that grows with the angle "
    "keeps its size per turn, an error that grows with the time has half its size per turn",
    "speed",
)
LONGER_AND_BACK = NextMeasurement(
    f"one run of {MORE_TURNS} turns, and one back: the number of lost counts continues to grow, "
    "but a cable that winds up pulls less when it unwinds",
    "turns",
)


def measurement_for(
    question: Question | None, described: Candidate | None
) -> NextMeasurement | None:
    """Return the measurement that separates a decision's effects or tests its product of parts."""
    if question is not None:
        found = next_measurement(question.best, question.rivals)
        lacks = question.best.lacking_variety
        return measurement_for_variety(question.best) if found.kind is None and lacks else found
    if described is None:
        return None
    assert isinstance(described.effect, ProductOfParts)
    return measurement_for_parts(described.effect, described.solution.observations)


def next_measurement(best: Candidate, rivals: Sequence[Candidate]) -> NextMeasurement:
    """Return the first plan that distinguishes the best effect from all rivals.

    If there is no such plan, return the first of these that exists: (1) the re-indexed polygon, if
    the best effect is fixed to the polygon and a rival is not, or the reverse; (2) the first plan
    that distinguishes the best effect from one rival; (3) the measurement that the best effect
    declares.
    """
    own = NextMeasurement(best.effect.next_measurement, None)
    observations = best.solution.observations
    if not rivals or observations.rows > MOST_ROWS:
        return own
    partly: tuple[PlannedMeasurement, float, Candidate] | None = None
    for plan in PLANS:
        there = plan.with_it(observations)
        if there is None:
            continue
        splits = [_split(best, rival, there) for rival in rivals]
        if min(splits) > SPLITS_CHI_SQUARE:
            names = ", ".join(_called(rival) for rival in rivals)
            return NextMeasurement(
                f"{plan.words}: it separates {best.name} from {names}", plan.kind, min(splits)
            )
        if partly is None and max(splits) > SPLITS_CHI_SQUARE:
            partly = plan, max(splits), rivals[int(np.argmax(splits))]
    fixed = best.effect.fixed_to_polygon
    if any(fixed != rival.effect.fixed_to_polygon for rival in rivals):
        return NextMeasurement(REINDEX, "polygon_reindexed")
    if partly is not None:
        plan, chi_square, rival = partly
        return NextMeasurement(
            f"{plan.words}: it separates {best.name} from {_called(rival)}", plan.kind, chi_square
        )
    return own


def _called(item: Candidate) -> str:
    """Return the name of an effect, or the parts of a product of parts."""
    if isinstance(item.effect, ProductOfParts):
        return f"{' × '.join(item.effect.parts)}"
    return item.name


def measurement_for_variety(best: Candidate) -> NextMeasurement:
    """Return the first plan whose rows supply all data that the set lacks to name this effect;
    without such a plan, return the lacking data in words."""
    observations = best.solution.observations
    lacking = "; ".join(best.effect.variety(observations))
    for plan in PLANS:
        there = plan.with_it(observations)
        if there is not None and not best.effect.variety(there):
            return NextMeasurement(f"{plan.words}: {best.name} needs {lacking}", plan.kind)
    return NextMeasurement(lacking, None)


def has_already(part: str, observations: Observations) -> bool:
    """Tell whether the set already contains the measurement that :data:`OF_PARTS` lists for a
    part."""
    channels = [rows for rows in (observations.capture, observations.reference) if rows is not None]
    if part == "direction":
        return any(
            rows.direction is not None and np.unique(np.sign(rows.direction)).size > 1
            for rows in channels
        )
    if part in ("speed", "speed^2"):
        speeds = [np.abs(rows.speed_rad_s) for rows in channels if rows.speed_rad_s is not None]
        return any(float(item.max()) > ANOTHER_SPEED * float(item.min()) for item in speeds)
    if part == "temperature":
        warm = [rows.temperature_c for rows in channels if rows.temperature_c is not None]
        return any(float(np.ptp(item)) >= WARMER_K for item in warm)
    return False


def measurement_for_parts(product: ProductOfParts, observations: Observations) -> NextMeasurement:
    """Return the measurement that tests a description by parts. If the product has a condition that
    the set does not yet vary, the measurement changes this condition."""
    temperature_known = observations.has_temperature
    for part in product.parts:
        if part in OF_PARTS and not has_already(part, observations):
            kind, words = OF_PARTS[part]
            if part in ("time", "settling") and not temperature_known:
                words += ". Record the temperature too: warming up, which this set cannot show"
                words += ", looks the same"
            return NextMeasurement(words, kind)
    if product.turned_by:
        return TURN_THE_PART_FURTHER
    if product.condition is TRAVEL:
        return ANOTHER_REFERENCE
    if product.condition.from_run is not None:
        return LOOK_AT_THE_STAND
    if product.condition.column is not None:
        swept = swept_range(product.condition.column, observations)
        if swept is not None:
            return NextMeasurement(
                f"the same measurement with {product.condition.column_words} outside {swept}: "
                "within this range the set shows already that the error follows it",
                None,
            )
        return NextMeasurement(
            f"the same measurement with another {product.condition.column_words}, all else equal: "
            "the error changes with it",
            None,
        )
    if any(order != round(order) for order in product.orders):
        return NextMeasurement(
            "one run of 30 turns or more: a half order changes its sign from turn to turn; the "
            "phase of an order near it drifts",
            "turns",
        )
    if product.electrical_head is not None:
        return NextMeasurement(
            "one run with five times as many samples a turn: many samples in each signal period",
            "samples",
        )
    if product.frame == "reference":
        varied = next((part for part in product.parts if part in OTHER_VALUES), None)
        if varied is not None:
            return NextMeasurement(OTHER_VALUES[varied], None)
    if product.frame == "reference" and observations.faces is None:
        return NextMeasurement(
            "the same reference run at other stations, half a step further: an error that depends "
            "on the angle is smooth between the stations",
            None,
        )
    if product.frame == "reference":
        return NextMeasurement(REINDEX, "polygon_reindexed")
    if product.frame == "disc":
        return NextMeasurement(
            "the disc put on its hub again, turned by some degrees: an error fixed to the disc "
            "turns with it",
            None,
        )
    return NextMeasurement(
        "the bracket of one head moved by some degrees: an error of that head moves with it", None
    )


def _split(first: Candidate, second: Candidate, there: Observations) -> float:
    """Return the smaller of two values of χ²: the χ² that the second effect leaves if the first is
    the truth, and the χ² of the reverse case."""
    return min(_left_over(first, second, there), _left_over(second, first, there))


def _left_over(truth: Candidate, other: Candidate, there: Observations) -> float:
    shown = _showing(truth, there)
    noise = truth.solution.noise.on(shown)
    base_terms = truth.solution.terms[:-1]

    def solved(terms: Sequence[Term]) -> Solution:
        context = truth.solution.context
        return solve(
            terms,
            shown,
            context,
            noise,
            capture=channel_sums(terms, shown, context, noise, capture=True),
            reference=channel_sums(terms, shown, context, noise, capture=False),
        )

    places: list[Nonlinear] = [other.nonlinear]
    if other.effect.search:
        # The wrong effect may fit best with other search parameters than those that were found, so
        # its search is repeated.
        places += [
            place.nonlinear for place in places_of(other.effect, Residuals(solved(base_terms)))[:1]
        ]
    return min(_chi_square(solved([*base_terms, Term(other.effect, place)])) for place in places)


def _showing(truth: Candidate, there: Observations) -> Observations:
    """Return the planned set with the prediction of the model with ``truth`` as its measured
    values."""
    solution = truth.solution
    coefficients = []
    for index, term in enumerate(solution.terms):
        fitted = solution.coefficients[solution.part(index)]
        known = dict(zip(term.effect.column_names(solution.observations), fitted, strict=True))
        # A coefficient that is free in each run keeps, in the new run, its value of the first run.
        runs = term.effect.column_runs(solution.observations)
        of_first = [value for value, run in zip(fitted, runs, strict=True) if run == 0]
        again = of_first or list(known.values())
        names = term.effect.column_names(there)
        coefficients += [
            known.get(name, again[position % len(again)]) for position, name in enumerate(names)
        ]
    predicted = replace(
        solution,
        observations=there,
        widths=tuple(term_widths(solution.terms, there)),
        coefficients=np.array(coefficients),
        run_offsets_arcsec=np.zeros(there.runs),
        reference_offset_arcsec=0.0,
    )
    capture, reference = there.capture, there.reference
    if capture is not None:
        values = predicted.capture_prediction_arcsec()
        capture = replace(capture, difference_arcsec=values)
    if reference is not None:
        values = predicted.reference_prediction_arcsec()
        reference = replace(reference, error_arcsec=values - values.mean())
    return replace(there, capture=capture, reference=reference)


def _chi_square(solution: Solution) -> float:
    residuals = Residuals(solution)
    total = float(np.sum(solution.run_offsets_arcsec**2)) / solution.noise.index_variance
    for values in (residuals.capture_whitened, residuals.reference_whitened):
        if values is not None:
            total += float(values @ values)
    return total
