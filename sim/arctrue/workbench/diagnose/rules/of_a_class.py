"""Rules that state the class of the best effect: ambiguous, or one name."""

from __future__ import annotations

from dataclasses import replace

from arctrue.workbench.diagnose.candidate import Candidate
from arctrue.workbench.diagnose.case import Case
from arctrue.workbench.diagnose.decision import Decision, Verdict
from arctrue.workbench.diagnose.lacking import lacking_words, separates
from arctrue.workbench.diagnose.next_measurement import NextMeasurement, Question
from arctrue.workbench.diagnose.rivals import NEAR_TIE, correlation


def cannot_be_split(case: Case) -> Decision | None:
    """Other effects explain these rows as well, or the set lacks data that the name needs."""
    best, similar = case.best, case.similar
    assert best is not None
    stranger = case.stand_in
    near_tie = stranger is not None and case.ahead > -NEAR_TIE
    rivals = list(case.rivals)
    if not (best.lacking_variety or rivals or near_tie):
        return None
    if stranger is not None and (near_tie or not rivals):
        rivals.append(stranger)
    also = case.confounded_effect
    if also is not None and also not in rivals:
        rivals.append(also)
    found = Question(best, rivals or [case.others[name] for name in similar.larger])
    why = f"it needs {'; '.join(best.lacking_variety)}" if best.lacking_variety else None
    return _of_class(
        case,
        "ambiguous",
        described=stranger,
        unconfirmed=why,
        look_alikes=case.look_alikes if best.lacking_variety else None,
        question=found,
        also=also,
    )


def looks_like_untestable(case: Case) -> Decision | None:
    """An effect that this set cannot test would look the same."""
    found = case.look_alikes
    if not found:
        return None
    lacking = "; ".join(lacking_words([what for items in found.values() for what in items]))
    best = case.best
    assert best is not None
    words = f"a set that has {lacking}"
    if best.solution.observations.capture is None:
        words = separates(best.name, found, best.effect.next_measurement)
    return _of_class(
        case,
        "ambiguous",
        look_alikes=found,
        unconfirmed=(
            f"{', '.join(found)} would look the same on these rows and cannot be tested: "
            f"the set lacks {lacking}"
        ),
        measurement=NextMeasurement(words, None),
    )


def grows_with_another(case: Case) -> Decision | None:
    """The effect may depend on another condition, which changed together with its own in this
    set."""
    best, other, also = case.best, case.confounded, case.confounded_effect
    assert best is not None
    if other is None:
        return None
    found = _of_class(
        case,
        "ambiguous",
        described=other if also is None else None,
        unconfirmed="the condition it depends on changed together with another one in this set",
        question=Question(best, [other]),
        also=also,
    )
    return replace(found, confounded=True)


def known_by_name(case: Case) -> Decision | None:
    """One effect is missing, and no other rule contradicts its name."""
    assert case.best is not None
    larger = [case.others[name] for name in case.similar.larger]
    return _of_class(case, "named", question=Question(case.best, larger) if larger else None)


def _of_class(
    case: Case,
    verdict: Verdict,
    *,
    question: Question | None = None,
    measurement: NextMeasurement | None = None,
    described: Candidate | None = None,
    unconfirmed: str | None = None,
    look_alikes: dict[str, list[str]] | None = None,
    also: Candidate | None = None,
) -> Decision:
    best, names = case.best, list(case.similar.all_names)
    assert best is not None
    unseen = look_alikes or {}
    if also is not None and also.name not in names:
        names.append(also.name)
    return Decision(
        verdict,
        first=best,
        effect_class=[best.name, *names, *unseen],
        class_correlation={
            name: correlation(case.survey, best, case.others[name]) for name in names
        },
        described=described,
        unconfirmed=unconfirmed,
        look_alikes=unseen,
        question=question,
        next=measurement,
        further=case.further,
    )
