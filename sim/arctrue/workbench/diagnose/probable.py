"""States the probabilities of a diagnosis in sentences."""

from __future__ import annotations

from arctrue.base.percent import probability_percent
from arctrue.workbench.diagnose.calibrated import LIKE_BENCHMARK
from arctrue.workbench.diagnose.diagnosis import Diagnosis
from arctrue.workbench.diagnose.probabilities import NONE

SHOWN_PROBABILITIES = 3
"""Largest number of probabilities in a sentence; the JSON contains all probabilities."""
LEAST_SHOWN = 0.01
"""Smallest probability in a sentence; the JSON contains all probabilities."""
THAT_IT_CAN_SHOW = "none that this set can show"


def probable(result: Diagnosis) -> list[str]:
    """Return the largest probabilities in a sentence.

    The effects of a class share one number, because the data cannot separate them. If the set can
    test a part of the catalogue only, ``none`` is a statement on this part. If the set differs from
    the sets of the calibration, a sentence before the number states how.
    """
    shown = [
        f"{words} {probability_percent(value)}"
        for words, value in _ranked(result)[:SHOWN_PROBABILITIES]
        if value >= LEAST_SHOWN
    ]
    if not shown:
        return []
    said = [f"Probability of the effect to add next: {', '.join(shown)}."]
    if len(result.unlike) >= LIKE_BENCHMARK:
        said.insert(
            0,
            "The following probability was calibrated on few or no sets like this one: "
            f"{'; '.join(result.unlike)}.",
        )
    return said


def _ranked(result: Diagnosis) -> list[tuple[str, float]]:
    """Return hypotheses in words with their probabilities, the class of the answer first, the
    others in the order of their probabilities."""
    left = dict(result.probability)
    first: list[tuple[str, float]] = []
    members = [name for name in result.effect_class if name in left]
    if result.verdict == "ambiguous" and len(members) > 1:
        names = f"{', '.join(members[:-1])} or {members[-1]}"
        together = min(sum(left.pop(name) for name in members), 1.0)
        first = [(f"one of the class ({names})", together)]
    if NONE in left and _shows_a_part_only(result):
        left[THAT_IT_CAN_SHOW] = left.pop(NONE)
    return first + sorted(left.items(), key=lambda item: -item[1])


def _shows_a_part_only(result: Diagnosis) -> bool:
    return result.verdict == "cannot_tell" or (
        result.verdict == "adequate" and bool(result.untestable)
    )
