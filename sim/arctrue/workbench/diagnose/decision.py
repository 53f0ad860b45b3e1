"""What is said of a set, and what it rests on."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Literal

from arctrue.workbench.diagnose.candidate import Candidate
from arctrue.workbench.diagnose.grounds import RESTS_ON
from arctrue.workbench.diagnose.next_measurement import NextMeasurement, Question
from arctrue.workbench.inference.forward.oscillation import Oscillation

Verdict = Literal["adequate", "named", "ambiguous", "unknown", "cannot_tell", "bad_data"]


@dataclass(frozen=True, eq=False)
class Decision:
    """A verdict and what it rests on."""

    verdict: Verdict
    first: Candidate | None = None
    """The effect that is named, or that stands first in the class."""
    effect_class: Sequence[str] = ()
    class_correlation: Mapping[str, float] = field(default_factory=dict)
    described: Candidate | None = None
    """The product of parts that explains what no known effect does."""
    confounded: bool = False
    """``described`` is the first growing with another condition, which the rows cannot tell."""
    unconfirmed: str | None = None
    """Why an effect that fits, and has no rival, is not named."""
    look_alikes: Mapping[str, list[str]] = field(default_factory=dict)
    resembles: Candidate | None = None
    """The effect of the catalogue that an unknown one looks like."""
    unlike: str | None = None
    """Why it is not that one."""
    undescribed_arcsec: Mapping[str, float] = field(default_factory=dict)
    """RMS beyond the noise, by channel, where neither an effect nor a product of parts takes it."""
    seen: str | None = None
    """What takes more than any effect and is none, in words: a jump, a damped oscillation."""
    oscillation: Oscillation | None = None
    """The damped oscillation that is ``seen``."""
    faults: tuple[str, ...] = ()
    """Of the data themselves, a sentence each."""
    cannot_tell: str | None = None
    """Why nothing found says nothing."""
    question: Question | None = None
    """What the next measurement has to split, where that is tried on paper."""
    next: NextMeasurement | None = None
    """What to measure, where the rule knows it."""
    beside: Decision | None = None
    """What would be said with the first in the model; None where that was not asked."""

    @property
    def rests_on(self) -> str:
        """What an ``unknown`` rests on: one of RESTS_ON; empty for another verdict."""
        if self.verdict != "unknown":
            return ""
        found = (self.resembles, self.described, self.seen, True)
        return next(name for name, it in zip(RESTS_ON, found, strict=True) if it)

    @property
    def spoken_of(self) -> Candidate | None:
        """The effect that is named, or that stands first in the class, or that it resembles."""
        return self.first or self.resembles
