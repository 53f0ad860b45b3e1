"""Holds a survey and the quantities that the rules need; each quantity is calculated once, on first
use."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property

from arctrue.workbench.diagnose.adding import Adding
from arctrue.workbench.diagnose.aliases import above_half_the_samples
from arctrue.workbench.diagnose.candidate import (
    ONCE,
    Candidate,
    explained_arcsec,
    happens_once,
    is_line,
)
from arctrue.workbench.diagnose.classes import (
    LEAST_SHARE,
    OF_THE_SAME_KIND,
    Similar,
    lead,
    similar_to,
    stands_in,
    without_unspecific,
)
from arctrue.workbench.diagnose.condition_forms import follows_a_record
from arctrue.workbench.diagnose.confounded import confounded_with
from arctrue.workbench.diagnose.decision import Decision
from arctrue.workbench.diagnose.every_pass import at_other_speeds, on_every_pass
from arctrue.workbench.diagnose.excluded import look_alikes
from arctrue.workbench.diagnose.rivals import (
    NEAR_TIE,
    compete,
    contains,
    is_smaller,
    is_sure,
    large_enough,
    same_by_definition,
)
from arctrue.workbench.diagnose.survey import Survey
from arctrue.workbench.effects.base import Effect
from arctrue.workbench.inference.forward.noise_of_record import NOT_WHITE
from arctrue.workbench.inference.forward.of_solution import has_records
from arctrue.workbench.inference.forward.oscillation import (
    Oscillation,
    line_in_each_run,
    oscillation_in_capture,
    oscillation_in_reference,
)
from arctrue.workbench.inference.forward.tests_of_a_line import FAMILY_WISE
from arctrue.workbench.inference.left import Left
from arctrue.workbench.inference.significance import SIGNIFICANCE
from arctrue.workbench.observations.display_step import display_step

LEAST_COLOUR = 0.02
"""Smallest sum of the squares of 20 autocorrelations that counts as not white. With many rows, a
smaller sum is significant as well: a noise model that is wrong by a fiftieth of the variance causes
such a sum. Such an error of the noise model changes no σ by more than 1 %."""
AGAIN = 3
"""Smallest number of events in one set that count as recurring; two events may occur by chance."""
DEEPEST = 3
"""Largest number of effects that are tested one after another, each with the effects before it in
the model."""


@dataclass(frozen=True, eq=False)
class Case:
    """A survey and the quantities that the rules need; each quantity is calculated once."""

    survey: Survey
    effects: Mapping[str, type[Effect]]
    with_first: Callable[[Survey, Candidate], Survey]
    """Function that makes the survey with one more effect in the model."""
    decided: Callable[[Case], Decision]
    """Function that applies the rules of the verdict to a case."""
    depth: int = 1
    set_aside: frozenset[str] = frozenset()
    """Effects that the rules refused and that may not be stated again."""
    adding: Adding | None = None
    """Object that adds effects to the model in the same way as ``arctrue add``; None: effects are
    added to the model of the survey."""

    @cached_property
    def decision(self) -> Decision:
        """The decision of the rules on this case."""
        return self.decided(self)

    @cached_property
    def seen(self) -> list[Candidate]:
        """Candidates that are significant and large enough, and that held-out rows and every pass
        show."""
        return [item for item in self.survey.significant() if self.survey.confirmed(item)]

    @cached_property
    def at_every_speed(self) -> list[Candidate]:
        """Candidates in ``seen`` that every speed shows, and that are not an alias of a better
        candidate.

        An order of the disc above half the samples per turn is left out if another cause gains
        more, because the order may be the alias of that cause in some of the runs.
        """
        return [item for item in self.seen if at_other_speeds(item) and not self._behind(item)]

    def _behind(self, item: Candidate) -> bool:
        if item.effect.search_kind != "disc_order":
            return False
        causes = [other for other in self.seen if not other.effect.unspecific]
        ahead = any(other.delta_bic > item.delta_bic for other in causes)
        return ahead and above_half_the_samples(item, self.survey.residuals)

    @cached_property
    def real(self) -> list[Candidate]:
        """Candidates in ``at_every_speed``; an effect that only describes the observation, such as
        a line, is omitted if a cause in ``seen`` explains the same error."""
        causes = {item.name for item in without_unspecific(self.seen)}
        causes -= self.set_aside
        return [item for item in self.at_every_speed if item.name in causes]

    @cached_property
    def refused(self) -> Candidate | None:
        """The first effect that fits and matters, but that held-out rows, passes or speeds
        contradict. The set then contains another error, which resembles this effect.
        """
        real = {item.name for item in self.at_every_speed}
        return next(
            (
                item
                for item in self.survey.significant()
                if item.name not in real and is_sure(item) and self.survey.matters(item)
            ),
            None,
        )

    @cached_property
    def best(self) -> Candidate | None:
        """The first of ``real``, or a larger effect that contains it and gains more than chance
        would.

        A regular cause that explains more error takes the place of this effect, and an effect that
        explains more error takes the place of a line. A regular cause also takes the place of
        drifts and events, which happen once and therefore cannot be tested by a prediction from
        other blocks.
        """
        found, regular = large_enough(self.real), self.regular
        if found is None:
            return regular
        if regular is not None and found is not regular and is_smaller(found, regular):
            rivals = not happens_once(found) and compete(self.survey, found, regular)
            found = found if rivals else regular
        return (self._larger_than(found) or found) if is_line(found) else found

    def _larger_than(self, line: Candidate) -> Candidate | None:
        """Return the repeating effect that explains the most error, if it explains at least as much
        as the line; otherwise None."""
        found = [
            item
            for item in self.real
            if not is_line(item)
            and not is_smaller(item, line)
            and not compete(self.survey, item, line)
        ]
        return max(found, key=explained_arcsec, default=None)

    def shown_by_parts(self, item: Candidate) -> bool:
        """Tell whether other parts of the record predict the candidate: other blocks predict a
        regular cause, other passes a reversal error. An error that remains with such a candidate in
        the model does not contradict the candidate."""
        return item.regular is not None or self.survey.is_the_reversal(item)

    @cached_property
    def regular(self) -> Candidate | None:
        """The regular cause that explains most of the error."""
        found = [item for item in self.real if item.regular is not None]
        return max(found, key=explained_arcsec, default=None)

    @cached_property
    def product(self) -> Candidate | None:
        """The product of parts that passes the same tests as an effect, except that its ΔBIC may be
        below 0. Its p is already corrected for all products that were tried; ΔBIC would correct for
        them a second time."""
        found = next(iter(self.survey.parts), None)
        if found is None or found.p_corrected >= SIGNIFICANCE or not self.survey.confirmed(found):
            return None
        places = self.survey.detections.places
        if places is not None and places.is_most and ONCE & set(found.effect.parts):
            # Every pass shows most of the error at the same place, so the error is not a function
            # of the time.
            return None
        if self.best is not None and contains(self.best, found):
            # The best effect contains the product, as polygon faces contain one of their orders.
            return None
        best = self.best
        if best is None or not self.shown_by_parts(best) or not is_smaller(found, best):
            return found
        rivals = best.regular is None and compete(self.survey, best, found)
        # A line in time has a free phase and a free period, so that it explains a little more than
        # a recorded condition that causes it.
        same = follows_a_record(found.effect) and stands_in(best, found)
        return found if rivals or same else None

    @property
    def ahead(self) -> float:
        """ΔBIC of the product minus ΔBIC of the best effect."""
        if self.product is None or self.best is None:
            return float("inf")
        return self.product.delta_bic - self.best.delta_bic

    @cached_property
    def others(self) -> dict[str, Candidate]:
        """Every candidate except the best, by its name."""
        return {item.name: item for item in self.survey.candidates if item is not self.best}

    @cached_property
    def oscillation(self) -> Oscillation | None:
        """The damped oscillation with the largest gain in the noise, if it is larger than the
        negligible size.

        Single rows of a channel are searched if its whitened residuals are not white, or if an
        effect was found or refused. Stations are not searched if every pass shows an error at the
        same places: over time, such an error has many lines. A line in time counts as an
        oscillation if each run has a phase of its own.
        """
        residuals = self.survey.residuals
        found = [self.survey.detections.oscillation]
        suspect = self.best is not None or self.refused is not None
        for tests, search in (
            (residuals.capture_whiteness, oscillation_in_capture),
            (residuals.reference_whiteness, oscillation_in_reference),
        ):
            if search is oscillation_in_reference and self._repeats_at_stations:
                continue
            if suspect or (tests is not None and tests.autocorrelation_p < NOT_WHITE):
                found.append(search(residuals.solution))
        hz = 0.0 if self.best is None else self.best.nonlinear.get("frequency", 0.0)
        if hz > 0.0 and not any(item is not None and item.is_line for item in found):
            found.append(line_in_each_run(residuals.solution, hz))
        large = [
            item
            for item in found
            if item is not None and item.rms_arcsec >= self._shown_arcsec(item.channel)
        ]
        return max(large, key=lambda item: item.gain, default=None)

    @property
    def _repeats_at_stations(self) -> bool:
        """True if every pass of a reference at stations shows an error at the same places."""
        return self.survey.detections.places is not None and not has_records(self.survey.base)

    def _shown_arcsec(self, channel: str) -> float:
        """Return the smallest RMS of an error without a name that the rows of a channel can show:
        the negligible size or, in a reference, half a step of its display.

        The rounding error of a display stays within half a step. Where the noise is smaller than
        the step, the rounding changes as regularly as the error, so that it is not white and may
        look like a resonance.
        """
        rows = self.survey.base.observations.reference
        step = 0.0
        if channel == "reference" and rows is not None:
            step = display_step(rows.error_arcsec)
        return max(self.survey.matters_arcsec, 0.5 * step)

    @property
    def not_noise(self) -> bool:
        """True if a detection in the reference is not noise. As in :attr:`not_white`, whiteness
        does not count if the rows cannot show the residual: the rounding of coarse counts or of a
        coarse display is not white."""
        detections, fit = self.survey.detections, self.survey.channels.get("reference")
        if fit is not None and fit.residual_rms_arcsec < self._shown_arcsec("reference"):
            return replace(detections, whiteness_p=None).not_noise
        return detections.not_noise

    @property
    def not_white(self) -> list[str]:
        """Channels whose whitened residuals are not white, with the noise that was fitted.

        In a reference with closely spaced rows, the test of the forward search replaces this test.
        A channel does not count if its rows cannot show its whole residual
        (:meth:`_shown_arcsec`). This is usual where the counts are coarser than the noise: their
        rounding, at most 0.41 counts RMS between two heads, repeats with the angle and is not
        white.
        """
        residuals, detections = self.survey.residuals, self.survey.detections
        found = []
        for channel, tests, least in (
            ("capture", residuals.capture_whiteness, NOT_WHITE),
            ("reference", residuals.reference_whiteness, FAMILY_WISE / 3.0),
        ):
            if tests is None or (channel == "reference" and detections.bands):
                continue
            fit = self.survey.channels.get(channel)
            if fit is not None and fit.residual_rms_arcsec < self._shown_arcsec(channel):
                continue
            if tests.autocorrelation_p < least and tests.colour > LEAST_COLOUR:
                found.append(channel)
        return found

    @cached_property
    def similar(self) -> Similar:
        """Candidates that this data cannot distinguish from the best effect.

        An order of the disc above half the samples per turn may be the alias of a line of any
        order.
        """
        best = self.best
        assert best is not None
        aliased = above_half_the_samples(best, self.survey.residuals)
        found = similar_to(best, list(self.others.values()), unspecific=aliased)
        if best.effect.search_kind == "frequency" and best.lacking_variety:
            # At one speed a frequency is an order. An oscillation has a free phase and a free size
            # in every run. An effect that explains most of the oscillation with one phase is an
            # error of the disc or of the signal; only the size of this error changes.
            further = [
                item.name
                for item in self.others.values()
                if not item.effect.unspecific
                and item.name not in found.all_names
                and item.p_corrected < SIGNIFICANCE
                and item.gain >= LEAST_SHARE * best.gain
                and compete(self.survey, item, best)
            ]
            return Similar((*found.equals, *further), found.larger)
        return found

    @cached_property
    def rivals(self) -> list[Candidate]:
        """Candidates in ``similar`` with no more coefficients than the best effect, or as likely as
        it."""
        best, similar = self.best, self.similar
        assert best is not None
        larger = [self.others[name] for name in similar.larger]
        near = [item for item in larger if lead(best, item) < NEAR_TIE]
        return [*(self.others[name] for name in similar.equals), *near]

    @cached_property
    def look_alikes(self) -> dict[str, list[str]]:
        """Effects that this set cannot test and whose columns look like the best effect's, each
        with the data that the set lacks."""
        best, survey = self.best, self.survey
        if best is None or best.effect.unspecific:
            return {}
        return look_alikes(best, survey.residuals, survey.untestable, self.effects, NEAR_TIE)

    @cached_property
    def confounded(self) -> Candidate | None:
        """The best effect with another condition in place of its own, if these rows cannot
        distinguish the two conditions; otherwise None."""
        return None if self.best is None else confounded_with(self.best, NEAR_TIE)

    @cached_property
    def confounded_effect(self) -> Candidate | None:
        """The effect of the catalogue that has the parts of :attr:`confounded`; None without such
        an effect."""
        if self.confounded is None:
            return None
        parts = set(self.confounded.effect.parts)
        found = (item for item in self.others.values() if set(item.effect.in_parts) == parts)
        return next(found, None)

    @cached_property
    def stand_in(self) -> Candidate | None:
        """A product of parts that explains the same error as the best effect and is not in the
        class of that effect."""
        best, product = self.best, self.product
        assert best is not None
        if product is None or not stands_in(best, product):
            return None
        members = [best, *(self.others[name] for name in self.similar.all_names)]
        return None if any(same_by_definition(item, product) for item in members) else product

    def with_it(self, item: Candidate | None) -> Case | None:
        """Return the case whose model also has this effect; None without an effect or at depth
        DEEPEST."""
        if item is None or self.depth >= DEEPEST:
            return None
        if self.best is item:
            return self.with_best
        return replace(
            self, survey=self.with_first(self.survey, item), depth=self.depth + 1, adding=None
        )

    @cached_property
    def with_best(self) -> Case | None:
        """The case with the best effect in the model; None without a best effect or at depth
        DEEPEST."""
        if self.best is None or self.depth >= DEEPEST:
            return None
        return replace(
            self, survey=self.with_first(self.survey, self.best), depth=self.depth + 1, adding=None
        )

    @cached_property
    def further(self) -> Decision | None:
        """The decision with the best effect in the model."""
        return None if self.with_best is None else self.with_best.decision

    @cached_property
    def _added(self) -> Adding:
        return self.adding or Adding(self.survey.residuals, self.effects)

    @property
    def before(self) -> Left:
        """Residual of the model without the best effect."""
        return self._added.before

    @cached_property
    def instead(self) -> Candidate | None:
        """The effect of another shape that the rules name if the refused effect is set aside; None
        if they name no effect."""
        best = self.best
        if (
            best is None
            or self.decision.verdict != "unknown"
            or self.decision.resembles is not best
        ):
            return None
        found = replace(self, set_aside=self.set_aside | {best.name}).decision
        item = found.first if found.verdict == "named" else None
        return None if item is None or compete(self.survey, item, best) else item

    @cached_property
    def before_and_after(self) -> tuple[Left, Left] | None:
        """Residuals of the model without and with the best effect; None if the effect cannot be
        added."""
        after = None if self.best is None else self._added.after(self.best.name)
        return None if after is None else (self.before, after)

    def once_more(self, event: Candidate) -> Candidate | None:
        """Return an event of the same kind and about the same size at another instant, if there is
        one.

        In slow noise, the neighbours of a held-out row predict it even after a step, so that
        held-out rows do not show the step. The step counts nevertheless if it is as significant as
        a sure lack of fit.
        """
        return next(
            (
                item
                for item in self.survey.significant()
                if item.name == event.name
                and item.gain > OF_THE_SAME_KIND * event.gain
                and self.survey.matters(item)
                and (self.survey.confirmed(item) or is_sure(item))
            ),
            None,
        )

    @cached_property
    def negligible(self) -> list[Candidate]:
        """Effects that are significant and that every pass shows, but that are too small to
        matter."""
        survey = self.survey
        return without_unspecific(
            [
                item
                for item in survey.significant()
                if not survey.matters(item) and on_every_pass(item, survey.base)
            ]
        )

    @cached_property
    def excluded(self) -> frozenset[str]:
        """Effects that fit, but that held-out rows, passes or speeds contradict."""
        survey = self.survey
        kept = {item.name for item in self.at_every_speed}
        if self.decision.resembles is not None:
            kept.discard(self.decision.resembles.name)
        return frozenset(
            item.name
            for item in survey.significant()
            if item.name not in kept
            and (survey.matters(item) or not on_every_pass(item, survey.base))
        )

    @cached_property
    def ranked(self) -> list[Candidate]:
        """All candidates; the candidate that the decision states comes first."""
        first = self.decision.spoken_of
        others = [item for item in self.survey.candidates if item is not first]
        return others if first is None else [first, *others]
