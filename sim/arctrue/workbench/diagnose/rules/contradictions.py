"""Rules that refuse the best effect because its values or other properties of the rows contradict
it."""

from __future__ import annotations

from dataclasses import replace

from arctrue.workbench.diagnose.case import Case
from arctrue.workbench.diagnose.classes import OF_THE_SAME_KIND, stands_in
from arctrue.workbench.diagnose.decision import Decision
from arctrue.workbench.diagnose.next_measurement import ONE_MORE_DIGIT
from arctrue.workbench.diagnose.of_the_runs import (
    head_1_reverses,
    offsets_are_large,
    runs_differ_with,
)
from arctrue.workbench.diagnose.own_tests import (
    follows_the_reading,
    further_motion,
    one_pattern,
    shape_with_corners,
)
from arctrue.workbench.diagnose.rivals import NEAR_TIE
from arctrue.workbench.diagnose.rounding import rounded_at_the_stations
from arctrue.workbench.diagnose.rules.best_effect import (
    channels_moved,
    is_of_the_runs,
    only_resembles,
)
from arctrue.workbench.diagnose.speed_ladder import not_in_proportion
from arctrue.workbench.inference.residuals import Residuals


def rounded_by_the_display(case: Case) -> Decision | None:
    """The rounding of the reference's display explains the best effect."""
    best = case.best
    assert best is not None
    reference = case.survey.channels.get("reference")
    if reference is None or channels_moved(best, case.survey) != ["reference"]:
        return None
    step = rounded_at_the_stations(best, reference.noise_arcsec)
    if step == 0.0:
        return None
    same = "changes with the error" if best.regular else "is the same at every visit of a station"
    why = (
        f"the readings of the reference are rounded to {step:.3g}″, and this rounding {same}: it "
        f"explains the error that resembles {best.name}"
    )
    return Decision("cannot_tell", cannot_tell=why, next=ONE_MORE_DIGIT)


def contradicts_itself(case: Case) -> Decision | None:
    """The best effect has values that its own physics excludes, and no other effect of a stated
    order that the rules would name gains more."""
    best = case.best
    assert best is not None
    solution = best.solution
    part = solution.part(len(solution.terms) - 1)
    why = best.effect.contradiction(
        solution.coefficients[part],
        solution.covariance[part, part],
        best.at_maximum.terms[-1].nonlinear,
        solution.observations,
    )
    if why is None and best.effect.search:
        found = best.at_maximum.parameters()[-1]
        why = best.effect.search_contradiction(found, solution.observations)
    reversal = best.effect.reversal_of_the_table
    if why is None and reversal is not None:
        found = best.at_maximum.parameters()[-1]
        why = head_1_reverses(Residuals(best.at_maximum), found[reversal])
    if why is None:
        return None
    # A cause with orders that the set states, and that explains more, is no accident of a search.
    # Other causes, such as a motion of the axis, fit a nonlinear scale as the best effect does.
    other = replace(case, set_aside=case.set_aside | {best.name}).decision
    if (
        other.verdict == "named"
        and other.first is not None
        and other.first.effect.order_is_stated
        and other.first.delta_bic > best.delta_bic
    ):
        return other
    # A product that explains the same error as the best effect describes this error without naming
    # a cause.
    product = case.product if case.product is not None and stands_in(best, case.product) else None
    return only_resembles(case, why, described=product)


def moves_at_further_orders(case: Case) -> Decision | None:
    """With the best effect in the model, the axis still moves at orders that this effect lacks.

    A cam or tooth moves the axis at the multiples of its order.
    """
    if case.best is None or case.with_best is None:
        return None
    left = case.with_best.survey
    why = further_motion(case.best, left.residuals, left.matters_arcsec)
    return None if why is None else only_resembles(case, why)


def fails_its_own_test(case: Case) -> Decision | None:
    """The best effect is one order of a shape with corners, a constant although the runs differ, a
    delay whose offsets are not proportional to the speed, or a function of the reference's reading.

    A pattern with corners is not one order, an error that differs with the speed of the runs is not
    a constant, and an error that is a function of the reference's reading is not an error of the
    table.
    """
    best = case.best
    assert best is not None
    why = one_pattern(*_disc_one_after_the_other(case))
    if why is None and best.effect.search_kind == "line":
        why = shape_with_corners(case.survey.detections.causes)
    if why is None and follows_the_reading(case.survey.residuals, best, NEAR_TIE):
        why = "it is a function of the reference's reading: the reference's scale is nonlinear"
    if why is None:
        why = not_in_proportion(case.survey.base, best, case.survey.matters_arcsec)
    further = case.further
    explained = further is not None and further.verdict in ("named", "ambiguous")
    if why is None and is_of_the_runs(case) and case.with_best is not None and not explained:
        left = case.with_best.survey.residuals
        condition = runs_differ_with(left)
        if condition is not None and offsets_are_large(
            left, case.survey.residuals, OF_THE_SAME_KIND
        ):
            why = f"the runs still differ with the {condition}, by more than the index's scatter"
    return None if why is None else only_resembles(case, why)


def _disc_one_after_the_other(case: Case) -> tuple[list[float], int]:
    """Return the orders of the disc and the number of local defects, each found with the earlier
    ones in the model."""
    orders: list[float] = []
    places = 0
    left: Case | None = case
    while left is not None and left.best is not None:
        kind = left.best.effect.search_kind
        if kind == "disc_order":
            orders.append(left.best.nonlinear["order"])
        elif kind == "disc_place":
            places += 1
        else:
            break
        left = left.with_best
    return orders, places
