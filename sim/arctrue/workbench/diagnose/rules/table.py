"""Decides the verdict by one table of rules: the first rule that applies gives the verdict.

Rules of the set come first; they use the results of every stage, including the probabilities. A
survey is the result of all tests with one model. Rules of the survey apply to every survey of a
diagnosis, also to the survey with the first effect in the model. The first sentence of each rule is
its line in docs/workbench.md, "How the verdict is reached".
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from arctrue.workbench.diagnose.case import Case
from arctrue.workbench.diagnose.decision import Decision, Verdict
from arctrue.workbench.diagnose.facts import Facts
from arctrue.workbench.diagnose.rules.contradictions import (
    contradicts_itself,
    fails_its_own_test,
    moves_at_further_orders,
    rounded_by_the_display,
)
from arctrue.workbench.diagnose.rules.instead_of_an_effect import (
    described_by_parts,
    driven_by_noise,
    jumped_once,
    loses_counts_again,
    moved_between_cycles,
    refused_is_ahead,
    runs_change_equally,
    shown_at_one_speed,
)
from arctrue.workbench.diagnose.rules.leaves_more import (
    comes_again_and_again,
    leaves_a_larger_slow_change,
    leaves_its_own_kind,
)
from arctrue.workbench.diagnose.rules.of_a_class import (
    cannot_be_split,
    grows_with_another,
    known_by_name,
    looks_like_untestable,
)
from arctrue.workbench.diagnose.rules.of_the_set import (
    faulty_rows,
    too_improbable_for_a_name,
    too_little_to_see,
    unknown_is_likelier,
    unknown_noise,
)
from arctrue.workbench.diagnose.rules.removes_little import makes_it_worse, takes_little
from arctrue.workbench.diagnose.rules.without_an_effect import (
    jumped_or_not_white,
    left_undescribed,
    nothing_found,
    runs_follow_a_condition,
    sticks_and_slips,
)


@dataclass(frozen=True)
class Rule:
    """One rule, which is one line of the table of rules."""

    verdict: Verdict
    judge: Callable[[Any], Decision | None]
    """Function of the facts of a set, or of the case of a survey; it returns None if the rule does
    not apply."""
    of_survey: bool = True

    @property
    def says(self) -> str:
        """Sentence that states when the rule applies."""
        return (self.judge.__doc__ or "").partition("\n\n")[0].replace("\n   ", "")


RULES = (
    Rule("bad_data", faulty_rows, of_survey=False),
    Rule("cannot_tell", unknown_noise, of_survey=False),
    Rule("cannot_tell", too_little_to_see, of_survey=False),
    Rule("unknown", unknown_is_likelier, of_survey=False),
    Rule("ambiguous", too_improbable_for_a_name, of_survey=False),
    Rule("unknown", jumped_once),
    Rule("unknown", loses_counts_again),
    Rule("unknown", moved_between_cycles),
    Rule("unknown", driven_by_noise),
    Rule("unknown", runs_change_equally),
    Rule("unknown", described_by_parts),
    Rule("ambiguous", shown_at_one_speed),
    Rule("unknown", refused_is_ahead),
    Rule("unknown", left_undescribed),
    Rule("unknown", jumped_or_not_white),
    Rule("unknown", sticks_and_slips),
    Rule("unknown", runs_follow_a_condition),
    Rule("adequate", nothing_found),
    Rule("cannot_tell", rounded_by_the_display),
    Rule("unknown", contradicts_itself),
    Rule("unknown", makes_it_worse),
    Rule("unknown", takes_little),
    Rule("unknown", moves_at_further_orders),
    Rule("unknown", leaves_its_own_kind),
    Rule("unknown", leaves_a_larger_slow_change),
    Rule("unknown", comes_again_and_again),
    Rule("unknown", fails_its_own_test),
    Rule("ambiguous", cannot_be_split),
    Rule("ambiguous", looks_like_untestable),
    Rule("ambiguous", grows_with_another),
    Rule("named", known_by_name),
)
"""The first rule that applies gives the verdict; the last rule always applies."""


def decide(facts: Facts) -> Decision:
    """Return the verdict of a set: the verdict of the first rule that applies."""
    of_set = (rule.judge(facts) for rule in RULES if not rule.of_survey)
    return next((found for found in of_set if found is not None), None) or facts.said


def said_of(case: Case) -> Decision:
    """Return the decision of the survey's rules for one survey."""
    of_survey = (rule.judge(case) for rule in RULES if rule.of_survey)
    return next(found for found in of_survey if found is not None)


def rule_table() -> list[str]:
    """Return the table as lines of Markdown."""
    return ["| | Verdict | When |", "|---|---|---|"] + [
        f"| {number} | `{rule.verdict}` | {rule.says} |" for number, rule in enumerate(RULES, 1)
    ]
