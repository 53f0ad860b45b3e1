"""The rules that turn a survey into a verdict, one small function each, in their order."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Literal

import numpy as np

from arctrue.workbench.diagnose.candidate import Candidate
from arctrue.workbench.diagnose.classes import (
    Similar,
    adds,
    alike,
    lead,
    stands_in,
    without_unspecific,
)
from arctrue.workbench.diagnose.excluded import look_alikes
from arctrue.workbench.diagnose.free_in_runs import at_other_speeds
from arctrue.workbench.diagnose.next_measurement import (
    AT_ONE_SPEED,
    NextMeasurement,
    measurement_for_parts,
    measurement_for_variety,
    next_measurement,
)
from arctrue.workbench.diagnose.survey import SIGNIFICANCE, Survey
from arctrue.workbench.effects.base import Effect
from arctrue.workbench.effects.product_of_parts import ProductOfParts
from arctrue.workbench.inference.canonical_correlation import canonical_correlations

Verdict = Literal["adequate", "named", "ambiguous", "unknown", "cannot_tell", "bad_data"]

PARTS_ADVANTAGE = 10.0
"""BIC by which a product of parts must beat the whole catalogue: odds of about 150 to 1, "very
strong" on the scale of Kass and Raftery, J. Am. Stat. Assoc. 90 (1995) 773."""
NEAR_TIE = 6.0
"""BIC by which an effect must be ahead of a product of parts that could stand in for it: odds of
20 to 1, "strong" on the same scale."""
SAME_GAIN = 0.01
"""Two gains nearer than this are of the same columns, but for the last digits of a search."""
LACK_OF_FIT = 1e-4
LEAST_EXCESS = 0.25
"""A model with a lack of fit this sure, and an excess over the repeats larger than this share of
their noise, is not adequate even where nothing describes what is left."""
REFUSED_P = LACK_OF_FIT
"""As sure as a lack of fit: an effect that is refused tells one."""
OF_THE_SAME_KIND = 0.1
"""Share of the first effect's gain: what is left beside it and is larger, a third of its size, may
be its own shape, that the catalogue does not have. Smaller, it is a matter of its own."""
AGAIN = 3
"""Events of one set that are a habit: two may be chance."""
DEEPEST = 3
"""So many effects are looked at one after the other, each beside those before it."""


@dataclass(frozen=True)
class Decision:
    """A verdict and what it rests on."""

    verdict: Verdict
    first: Candidate | None = None
    """The effect that is named, or that stands first in the class."""
    effect_class: list[str] = field(default_factory=list)
    class_correlation: dict[str, float] = field(default_factory=dict)
    described: Candidate | None = None
    """The product of parts that explains what no known effect does."""
    unconfirmed: str | None = None
    """Why an effect that fits, and has no rival, is not named."""
    look_alikes: dict[str, list[str]] = field(default_factory=dict)
    resembles: Candidate | None = None
    """The effect of the catalogue that an unknown one looks like."""
    unlike: str | None = None
    """Why it is not that one."""
    undescribed_arcsec: dict[str, float] = field(default_factory=dict)
    """RMS beyond the noise, by channel, where neither an effect nor a product of parts takes it."""
    next: NextMeasurement | None = None
    beside: Decision | None = None
    """What would be said with the first in the model; None where that was not asked."""


@dataclass
class Case:
    """A survey with what the rules ask of it, each worked out once."""

    survey: Survey
    effects: Mapping[str, type[Effect]]
    with_first: Callable[[Candidate], Survey]
    """The survey beside the model with one effect more."""
    depth: int = 1

    @cached_property
    def seen(self) -> list[Candidate]:
        """Significant, large enough, in held-out rows and on every pass."""
        return [item for item in self.survey.significant() if self.survey.confirmed(item)]

    @cached_property
    def at_every_speed(self) -> list[Candidate]:
        """Of those, what shows at every speed at which it would."""
        return [item for item in self.seen if at_other_speeds(item)]

    @cached_property
    def real(self) -> list[Candidate]:
        """Of those, a cause rather than the line that it is."""
        causes = {item.name for item in without_unspecific(self.seen)}
        return [item for item in self.at_every_speed if item.name in causes]

    @cached_property
    def refused(self) -> Candidate | None:
        """The first that fits and matters, and that held-out rows, passes or speeds speak against.

        Something like it is there, and it is not this.
        """
        real = {item.name for item in self.at_every_speed}
        return next(
            (
                item
                for item in self.survey.significant()
                if item.name not in real and _is_sure(item) and self.survey.matters(item)
            ),
            None,
        )

    @cached_property
    def best(self) -> Candidate | None:
        """The first, or a larger one around it that adds what is more than chance."""
        return _large_enough(self.real)

    @cached_property
    def product(self) -> Candidate | None:
        """The product of parts that is as real as an effect is asked to be.

        Its p has paid for all places: no ΔBIC above 0 is asked for as well, which would charge
        for them twice.
        """
        found = next(iter(self.survey.parts), None)
        if found is None or found.p_corrected >= SIGNIFICANCE or not self.survey.confirmed(found):
            return None
        if self.best is not None and _contains(self.best, found):
            # More than the product, and all of it: a polygon's faces beside one of their orders.
            return None
        return found

    @property
    def ahead(self) -> float:
        """ΔBIC of the product over the best effect."""
        if self.product is None or self.best is None:
            return float("inf")
        return self.product.delta_bic - self.best.delta_bic

    @cached_property
    def others(self) -> dict[str, Candidate]:
        """Every other effect by its name."""
        return {item.name: item for item in self.survey.candidates if item is not self.best}

    @cached_property
    def similar(self) -> Similar:
        """What this data cannot tell from the best."""
        assert self.best is not None
        return alike(self.best, list(self.others.values()))

    @cached_property
    def rivals(self) -> list[Candidate]:
        """Of those, all of equal freedom, and the larger ones that are as likely."""
        best, similar = self.best, self.similar
        assert best is not None
        larger = [self.others[name] for name in similar.larger]
        near = [item for item in larger if lead(best, item) < NEAR_TIE]
        return [*(self.others[name] for name in similar.equals), *near]

    @cached_property
    def look_alikes(self) -> dict[str, list[str]]:
        """Effects that this set cannot test and that would look like the best, with what it
        lacks."""
        best, survey = self.best, self.survey
        if best is None or best.effect.unspecific:
            return {}
        return look_alikes(best, survey.residuals, survey.untestable, self.effects)

    @cached_property
    def stand_in(self) -> Candidate | None:
        """A product of parts that explains what the best explains, and is none of its class."""
        best, product = self.best, self.product
        assert best is not None
        if product is None or not stands_in(best, product):
            return None
        members = [best, *(self.others[name] for name in self.similar.all_names)]
        return None if any(_same(item, product) for item in members) else product

    def with_it(self, item: Candidate | None) -> Case | None:
        """The case with one effect more in the model; None where that is not asked."""
        if item is None or self.depth >= DEEPEST:
            return None
        if self.best is item:
            return self.with_best
        return Case(self.with_first(item), self.effects, self.with_first, self.depth + 1)

    @cached_property
    def with_best(self) -> Case | None:
        """The case with the best in the model."""
        if self.best is None or self.depth >= DEEPEST:
            return None
        return Case(self.with_first(self.best), self.effects, self.with_first, self.depth + 1)

    @cached_property
    def beside(self) -> Decision | None:
        """What is said with the best in the model."""
        return None if self.with_best is None else decide(self.with_best)

    def once_more(self, event: Candidate) -> Candidate | None:
        """The event once more, at another instant, and about as large.

        Slow noise of its neighbours may tell of a row left out after a step, so that such rows do
        not show it; where it is as sure as a lack of fit, it counts all the same.
        """
        return next(
            (
                item
                for item in self.survey.significant()
                if item.name == event.name
                and item.gain > OF_THE_SAME_KIND * event.gain
                and self.survey.matters(item)
                and (self.survey.confirmed(item) or _is_sure(item))
            ),
            None,
        )


def described_by_parts(case: Case) -> Decision | None:
    """A product of parts is far ahead of the whole catalogue."""
    if case.product is None or case.ahead <= PARTS_ADVANTAGE:
        return None
    return Decision("unknown", described=case.product, next=_for_parts(case.product))


def shown_at_one_speed(case: Case) -> Decision | None:
    """The only effect that is seen would show at all speeds, and shows at one."""
    if case.best is not None or not case.seen:
        return None
    first, refused = without_unspecific(case.seen)[0], case.refused
    if refused is not None and refused.delta_bic > first.delta_bic + PARTS_ADVANTAGE:
        return None
    return Decision(
        "ambiguous",
        first=first,
        effect_class=[first.name],
        unconfirmed="it shows at one of several speeds only, and would show at all",
        next=AT_ONE_SPEED,
    )


def refused_is_ahead(case: Case) -> Decision | None:
    """What fits best by far is not what it seems to be, and the best of the others adds nothing."""
    refused, best = case.refused, case.best
    if refused is None or refused.delta_bic <= PARTS_ADVANTAGE:
        return None
    if best is not None and (
        refused.delta_bic - best.delta_bic <= PARTS_ADVANTAGE or adds(best, refused)
    ):
        return None
    why = "rows that were left out of the fit, or other passes and speeds, do not show it"
    return Decision("unknown", resembles=refused, unlike=why)


def left_undescribed(case: Case) -> Decision | None:
    """Nothing describes what the model leaves, and that is sure and large."""
    survey = case.survey
    if case.best is not None:
        return None
    left = {
        channel: excess
        for channel, p_value in survey.lack_of_fit.items()
        if p_value < LACK_OF_FIT
        and (excess := _excess_arcsec(survey, channel))
        > max(survey.matters_arcsec, LEAST_EXCESS * survey.noise_arcsec[channel])
    }
    return Decision("unknown", undescribed_arcsec=left) if left else None


def nothing_found(case: Case) -> Decision | None:
    """No effect and no product of parts is real."""
    return Decision("adequate") if case.best is None else None


def contradicts_itself(case: Case) -> Decision | None:
    """The best has values that its own physics does not allow."""
    best = case.best
    assert best is not None
    solution = best.solution
    part = solution.part(len(solution.terms) - 1)
    why = best.effect.contradiction(
        solution.coefficients[part],
        solution.covariance[part, part],
        best.nonlinear,
        solution.observations,
    )
    if why is None and best.effect.search:
        found = best.at_maximum.parameters()[-1]
        why = best.effect.search_contradiction(found, solution.observations)
    if why is None:
        return None
    # The product that explains what the best does says what it is without saying why.
    product = case.product if case.product is not None and stands_in(best, case.product) else None
    return _only_resembles(case, why, described=product)


def leaves_its_own_kind(case: Case) -> Decision | None:
    """With the best in the model, what is left is unknown, and about as large as the best.

    A shape that the catalogue does not have is taken in part by an effect that is a little like
    it: a flat track by the faces of a polygon, the knocks of a loose head by a slip.
    """
    assert case.best is not None
    left = case.beside
    if left is None or not _unknown_within(left, case):
        return None
    return _only_resembles(
        case, "beside it as much again is left, which no effect of the catalogue explains", left
    )


def comes_again_and_again(case: Case) -> Decision | None:
    """An event at an instant, and beside it the same event at two more, about as large.

    One slip is an accident; a head that steps again and again is loose, sticks, or is disturbed.
    """
    best = case.best
    assert best is not None
    if best.effect.step_at is None:
        return None
    left: Case | None = case
    event: Candidate | None = best
    for _ in range(AGAIN - 1):
        left = left.with_it(event) if left is not None else None
        event = None if left is None else left.once_more(best)
        if event is None:
            return None
    return _only_resembles(case, f"it is there {AGAIN} times or more, at instants without a rule")


def cannot_be_split(case: Case) -> Decision | None:
    """Others explain the same on these rows, or the set lacks what a name needs."""
    best, similar = case.best, case.similar
    assert best is not None
    stranger = case.stand_in
    near_tie = stranger is not None and case.ahead > -NEAR_TIE
    rivals = list(case.rivals)
    if not (best.lacking_variety or rivals or near_tie):
        return None
    if stranger is not None and (near_tie or not rivals):
        rivals.append(stranger)
    found = next_measurement(best, rivals or [case.others[name] for name in similar.larger])
    if found.kind is None and best.lacking_variety:
        found = measurement_for_variety(best)
    why = f"it needs {'; '.join(best.lacking_variety)}" if best.lacking_variety else None
    return _of_class(
        case,
        "ambiguous",
        described=stranger,
        unconfirmed=why,
        look_alikes=case.look_alikes if best.lacking_variety else None,
        measurement=found,
    )


def looks_like_untestable(case: Case) -> Decision | None:
    """An effect that this set cannot test would look the same."""
    found = case.look_alikes
    if not found:
        return None
    lacking = "; ".join(sorted({what for items in found.values() for what in items}))
    return _of_class(
        case,
        "ambiguous",
        look_alikes=found,
        unconfirmed=(
            f"{', '.join(found)} would look the same on the rows there are, and cannot be tested: "
            f"the set lacks {lacking}"
        ),
        measurement=NextMeasurement(f"a set that has {lacking}", None),
    )


def known_by_name(case: Case) -> Decision | None:
    """One effect is missing, and nothing speaks against its name."""
    assert case.best is not None
    larger = [case.others[name] for name in case.similar.larger]
    found = next_measurement(case.best, larger) if larger else None
    return _of_class(case, "named", measurement=found)


Rule = Callable[[Case], Decision | None]
RULES: tuple[Rule, ...] = (
    described_by_parts,
    shown_at_one_speed,
    refused_is_ahead,
    left_undescribed,
    nothing_found,
    contradicts_itself,
    leaves_its_own_kind,
    comes_again_and_again,
    cannot_be_split,
    looks_like_untestable,
    known_by_name,
)
"""The first that decides is the verdict; the last always does."""


def decide(case: Case) -> Decision:
    """The verdict of the first rule that gives one."""
    return next(found for rule in RULES if (found := rule(case)) is not None)


def _only_resembles(
    case: Case, why: str, left: Decision | None = None, described: Candidate | None = None
) -> Decision:
    deepest = left
    while deepest is not None and deepest.verdict != "unknown":
        deepest = deepest.beside
    if deepest is not None:
        described = deepest.described
    return Decision(
        "unknown",
        described=described,
        resembles=case.best,
        unlike=why,
        next=None if described is None else _for_parts(described),
        beside=left,
    )


def _of_class(
    case: Case,
    verdict: Verdict,
    *,
    measurement: NextMeasurement | None,
    described: Candidate | None = None,
    unconfirmed: str | None = None,
    look_alikes: dict[str, list[str]] | None = None,
) -> Decision:
    best, names = case.best, case.similar.all_names
    assert best is not None
    unseen = look_alikes or {}
    return Decision(
        verdict,
        first=best,
        effect_class=[best.name, *names, *unseen],
        class_correlation={name: _correlation(case, best, case.others[name]) for name in names},
        described=described,
        unconfirmed=unconfirmed,
        look_alikes=unseen,
        next=measurement,
        beside=case.beside,
    )


def _correlation(case: Case, best: Candidate, other: Candidate) -> float:
    found = canonical_correlations(case.survey.residuals, best.term, other.term)
    return float(np.max(found, initial=0.0))


def _for_parts(described: Candidate) -> NextMeasurement:
    product: ProductOfParts = described.effect  # type: ignore[assignment]
    known = described.solution.observations.has_temperature
    return measurement_for_parts(product, temperature_known=known)


def _excess_arcsec(survey: Survey, channel: str) -> float:
    """RMS of the residual beyond the noise of the repeats."""
    noise, left = survey.noise_arcsec[channel], survey.residual_rms_arcsec[channel]
    return float(np.sqrt(max(left**2 - noise**2, 0.0)))


def _unknown_within(left: Decision, case: Case) -> bool:
    """What is left, or what is left of that, is unknown and of the size of the first."""
    first = case.best
    assert first is not None
    if left.verdict != "unknown":
        return left.beside is not None and _unknown_within(left.beside, case)
    found = left.described or left.resembles
    if found is not None:
        return found.gain > OF_THE_SAME_KIND * first.gain
    return not left.undescribed_arcsec or any(
        after**2 > OF_THE_SAME_KIND * (_excess_arcsec(case.survey, channel) ** 2 - after**2)
        for channel, after in left.undescribed_arcsec.items()
    )


def _is_sure(item: Candidate) -> bool:
    """With the noise free on both sides, as sure as a lack of fit has to be."""
    return item.evidence is not None and item.p_corrected < REFUSED_P


def _same(best: Candidate, product: Candidate) -> bool:
    """The product is the effect itself in other words, and not only on this poor set."""
    if best.effect.unspecific and product.effect.parts[0].startswith("order:"):
        return True
    if best.effect.in_parts and set(product.effect.parts) == set(best.effect.in_parts):
        return True
    alike_here = product.rank == best.rank and abs(product.gain / best.gain - 1.0) < SAME_GAIN
    return alike_here and not best.lacking_variety


def _contains(best: Candidate, product: Candidate) -> bool:
    return stands_in(product, best) and adds(best, product)


def _large_enough(real: list[Candidate]) -> Candidate | None:
    """The first of ``real``, or a larger one around it that adds what is more than chance."""
    if not real:
        return None
    best, rest = real[0], list(real[1:])
    while rest:
        larger = [item for item in rest if item.rank > best.rank and stands_in(best, item)]
        found = next(
            (item for item in larger if adds(item, best) or lead(item, best) > NEAR_TIE), None
        )
        if found is None:
            break
        best = found
        rest.remove(found)
    return best
