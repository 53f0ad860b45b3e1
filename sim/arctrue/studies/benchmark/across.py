"""Probabilities calibrated on the sets of one generator and scored on those of another.

Of each kind of answer (a name, ``unknown``, ``none``) the share that was right is counted where the
answer was sure, on one generator; on the other a sure answer of that kind then states this share.
What a constant would score there is known, and whether the counted shares do better.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from arctrue.studies.benchmark.intervals import Estimate, calibration_error, log_score_gain
from arctrue.studies.benchmark.outcome import Judged
from arctrue.studies.benchmark.score import SURE


@dataclass(frozen=True, slots=True)
class Across:
    """Of the sets of one generator: the probabilities as stated, and as the other one has them."""

    learned_on: str
    scored_on: str
    sets: int
    right_share: Mapping[str, float]
    """Of sure answers of each kind, on the generator that was learned on."""
    stated_error: Estimate
    stated_gain: Estimate
    learned_error: Estimate
    learned_gain: Estimate

    def words(self) -> str:
        """One line."""
        return (
            f"learned on {self.learned_on}, scored on {self.scored_on} ({self.sets} sets): "
            f"calibration error {_words(self.stated_error)} as stated, "
            f"{_words(self.learned_error)} learned; log score less that of a constant "
            f"{_words(self.stated_gain)} nats as stated, {_words(self.learned_gain)} learned"
        )


def _words(found: Estimate) -> str:
    return f"{found.value:.3f} ({found.low:.3f} … {found.high:.3f})"


def right_shares(sets: Sequence[Judged]) -> dict[str, float]:
    """Share of right answers of each kind where they are sure: (k + ½)/(n + 1), Jeffreys' prior."""
    found: dict[str, list[bool]] = {}
    for item in sets:
        pair, kind = item.first_probability(), item.first_kind()
        if pair is not None and kind is not None and pair[0] > SURE:
            found.setdefault(kind, []).append(pair[1])
    return {kind: (sum(right) + 0.5) / (len(right) + 1.0) for kind, right in found.items()}


def across(generators: Mapping[str, Sequence[Judged]]) -> list[Across]:
    """Of every pair of generators, each learned on and scored on in turn.

    A kind of answer of which the one has no sure answer keeps what it states.
    """
    return [
        _scored(learned_on, scored_on, generators)
        for learned_on in generators
        for scored_on in generators
        if learned_on != scored_on
    ]


def _scored(learned_on: str, scored_on: str, generators: Mapping[str, Sequence[Judged]]) -> Across:
    shares = right_shares(generators[learned_on])
    stated, learned, right = [], [], []
    for item in generators[scored_on]:
        pair, kind = item.first_probability(), item.first_kind()
        if pair is None or kind is None:
            continue
        stated.append(pair[0])
        learned.append(shares.get(kind, pair[0]) if pair[0] > SURE else pair[0])
        right.append(pair[1])
    if not right:
        raise ValueError(f"no set of the generator {scored_on} has an answer with probabilities")
    return Across(
        learned_on,
        scored_on,
        len(right),
        shares,
        calibration_error(stated, right),
        log_score_gain(stated, right),
        calibration_error(learned, right),
        log_score_gain(learned, right),
    )
