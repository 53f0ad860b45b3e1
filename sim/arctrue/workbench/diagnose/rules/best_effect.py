"""Decision that an error only resembles the best effect, and properties of this effect that several
rules use."""

from __future__ import annotations

from arctrue.workbench.diagnose.candidate import RUNS_ARE_THE_SAMPLE, Candidate
from arctrue.workbench.diagnose.case import Case
from arctrue.workbench.diagnose.decision import Decision
from arctrue.workbench.diagnose.of_the_runs import LEAST_OFFSETS
from arctrue.workbench.diagnose.survey import Survey

LEAST_TAKEN = 0.1
"""Smallest share of the error's mean square above the noise that an effect must remove; an effect
that removes less does not explain this error."""


def only_resembles(
    case: Case, why: str, left: Decision | None = None, described: Candidate | None = None
) -> Decision:
    """Return the verdict `unknown`: the error resembles the best effect, which ``why`` contradicts.

    ``left``: verdict with the best effect in the model. ``described``: product of parts that
    describes the error; that of the deepest `unknown` in ``left`` replaces it.
    """
    deepest = left
    while deepest is not None and deepest.verdict != "unknown":
        deepest = deepest.further
    if deepest is not None:
        described = deepest.described
    return Decision(
        "unknown",
        described=described,
        resembles=case.best,
        unlike=why,
        further=left,
    )


def is_of_the_runs(case: Case) -> bool:
    """Return True if the offsets of enough runs decide whether the best effect exists."""
    best = case.best
    if best is None or best.evidence is None:
        return False
    if best.second_of_runs is not None:
        return True
    if best.solution.observations.runs - best.rank < LEAST_OFFSETS:
        return False
    return best.evidence.index_share >= RUNS_ARE_THE_SAMPLE


def channels_moved(item: Candidate, survey: Survey) -> list[str]:
    """Return the channel that an effect changes most, in units of the noise of its rows."""
    noise = {name: fit.noise_arcsec for name, fit in survey.channels.items()}
    return sorted(
        (name for name in item.moved_arcsec if name in noise),
        key=lambda name: -item.moved_arcsec[name] / max(noise[name], 1e-12),
    )[:1]


def largest_arcsec(item: Candidate) -> float:
    """Return the RMS by which an effect changes the channel that it changes most."""
    return max(item.moved_arcsec.values(), default=0.0)
