"""Collects the results of a diagnosis's stages for one set; the rules of the verdict need them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from arctrue.workbench.diagnose.calibrated import confidence
from arctrue.workbench.diagnose.case import Case
from arctrue.workbench.diagnose.coverage import (
    Blindness,
    Coverage,
    blindness,
    effect_or_noise,
)
from arctrue.workbench.diagnose.decision import Decision
from arctrue.workbench.diagnose.distance import LEAST_P, distance, ways_unlike
from arctrue.workbench.diagnose.grounds import Grounds
from arctrue.workbench.diagnose.next_measurement import ONE_MORE_DIGIT, WHOLE_TURNS_OF_THE_HEADS
from arctrue.workbench.diagnose.posterior import PARTS_ADVANTAGE, posterior, stated
from arctrue.workbench.diagnose.rivals import NEAR_TIE
from arctrue.workbench.diagnose.rounding import rounded_at_the_stations
from arctrue.workbench.diagnose.undetermined import WHOLE_TURNS, undetermined
from arctrue.workbench.inference.left import Left


@dataclass(frozen=True, eq=False)
class Facts:
    """Faults of a set, its survey with the quantities that the rules need, and the coverage of the
    survey."""

    faults: Sequence[str] = ()
    too_short: str | None = None
    """Reason why runs of less than one turn determine no model."""
    case: Case | None = None
    """The survey's case; None where the rows are faulty, or too few to show their noise."""
    covers: Coverage = field(default_factory=Coverage)

    @property
    def said(self) -> Decision:
        """The decision of the rules of the survey."""
        assert self.case is not None
        return self.case.decision

    @cached_property
    def blindness(self) -> Blindness | None:
        """Reason why the set cannot show that the model is adequate; None if it can, or if an
        effect is found.

        If the rows do not determine the model, this is a reason even if an effect is found.
        """
        if self.too_short is not None:
            return Blindness(self.too_short, WHOLE_TURNS_OF_THE_HEADS)
        if self.case is None:
            return None
        why = undetermined(self.case.survey.base)
        if why is not None:
            return Blindness(why, WHOLE_TURNS)
        if self.said.verdict != "adequate":
            return None
        survey = self.case.survey
        left = {channel: item.residual_rms_arcsec for channel, item in survey.channels.items()}
        return (
            self._rounded_line
            or blindness(survey.residuals, self.covers, left, survey.matters_arcsec)
            or effect_or_noise(survey.candidates, survey.absent, survey.matters_arcsec)
        )

    @property
    def _rounded_line(self) -> Blindness | None:
        """Reason for doubt if the rounding of the display may cause the largest line of a log; else
        None."""
        assert self.case is not None
        survey = self.case.survey
        reference = survey.channels.get("reference")
        line = next((item for item in survey.candidates if item.regular is not None), None)
        if reference is None or line is None or line.regular is None:
            return None
        step = rounded_at_the_stations(line, reference.noise_arcsec)
        if step == 0.0:
            return None
        why = (
            f"the readings of the reference are rounded to {step:.3g}″, and this rounding may "
            f"cause the line that resembles {line.regular.words()}"
        )
        return Blindness(why, ONE_MORE_DIGIT.words)

    @cached_property
    def _posterior(self) -> dict[str, float]:
        """Probabilities within the bounds of the survey's rules."""
        if self.case is None:
            # Nothing was tested: the prior probabilities remain.
            return posterior(
                "cannot_tell", [], 1, effect_class=[], look_alikes=[], product=None,
                excluded=frozenset(), lack_of_fit_p=1.0, near_tie=NEAR_TIE,
                advantage=PARTS_ADVANTAGE,
            )  # fmt: skip
        survey, said = self.case.survey, self.said
        product = said.described
        if product is None and not said.effect_class:
            product = next(iter(survey.parts), None)
        return posterior(
            said.verdict if self.blindness is None else "cannot_tell",
            self.case.ranked,
            len(survey.untestable),
            effect_class=list(said.effect_class),
            look_alikes=list(said.look_alikes),
            product=product,
            excluded=self.case.excluded,
            lack_of_fit_p=min(survey.lack_of_fit.values(), default=1.0),
            near_tie=NEAR_TIE,
            advantage=PARTS_ADVANTAGE,
            confounded=said.confounded,
        )

    @cached_property
    def _left(self) -> Left | None:
        """Residual of the model with the best effect; None without a case.

        If no effect can be added, it is the residual of the model alone.
        """
        if self.case is None:
            return None
        found = self.case.before_and_after
        return self.case.before if found is None else found[1]

    @cached_property
    def unlike(self) -> tuple[str, ...]:
        """Ways in which the set differs from the sets on which the probabilities were
        calibrated."""
        case, left = self.case, self._left
        if case is None or left is None:
            return ()
        survey = case.survey
        return ways_unlike(
            left.solution.observations, left, survey.untestable, len(survey.candidates)
        )

    def grounds(self, decision: Decision) -> Grounds | None:
        """Return the quantities that determine the probability of a decision; None where nothing
        was tested."""
        case, left = self.case, self._left
        if case is None or left is None:
            return None
        survey, ranked = case.survey, case.ranked
        said = {"unknown": "unknown", "adequate": "none"}.get(decision.verdict)
        if said is None and decision.effect_class:
            said = decision.effect_class[0]
        best = ranked[0] if ranked else None
        others = [item.delta_bic for item in ranked[1:] if item.name not in decision.effect_class]
        fit_p = min(survey.lack_of_fit.values(), default=1.0)
        return Grounds(
            evidence=0.0 if said is None else self._posterior.get(said, 0.0),
            log_p=0.0 if best is None else float(np.log10(max(best.p_corrected, LEAST_P))),
            delta_bic=0.0 if best is None else best.delta_bic,
            lead=0.0 if best is None else best.delta_bic - max([0.0, *others]),
            block_share=None if best is None or best.share is None else best.share.share,
            lack_of_fit_log_p=float(np.log10(max(fit_p, LEAST_P))),
            class_size=len(decision.effect_class),
            ways=len(self.unlike),
            distance=distance(
                left.solution.observations, left, survey.untestable, len(survey.candidates)
            ),
            rests_on=decision.rests_on,
        )

    @property
    def offered(self) -> Mapping[str, float]:
        """Probabilities from the evidence and the rules alone, before calibration; they select the
        decision."""
        return self._posterior

    def probability(self, decision: Decision) -> dict[str, float]:
        """Return the probabilities that are stated with a decision; the sum is 1."""
        grounds = self.grounds(decision)
        sure = None if grounds is None else confidence(decision.verdict, grounds)
        return stated(self._posterior, decision.verdict, list(decision.effect_class), sure)
