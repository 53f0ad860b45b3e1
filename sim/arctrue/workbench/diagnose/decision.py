"""Holds the decision on a set: the verdict and the results on which it rests."""

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
    """A verdict and the results on which it rests."""

    verdict: Verdict
    first: Candidate | None = None
    """The effect that is named, or the first effect of the class (the effects that the data cannot
    distinguish)."""
    effect_class: Sequence[str] = ()
    class_correlation: Mapping[str, float] = field(default_factory=dict)
    described: Candidate | None = None
    """The product of parts that explains the error if no known effect does; with the verdict
    ``ambiguous``, a product that explains it as well as the first effect."""
    confounded: bool = False
    """True if ``described`` is the error of the first effect as a function of another condition,
    and the rows cannot distinguish the two conditions."""
    unconfirmed: str | None = None
    """Reason, other than an effect in ``effect_class``, why an effect that fits is not named."""
    look_alikes: Mapping[str, list[str]] = field(default_factory=dict)
    resembles: Candidate | None = None
    """Effect of the catalogue that the unknown effect resembles."""
    unlike: str | None = None
    """Reason why the unknown effect is not the effect in ``resembles``."""
    a_part: bool = False
    """True if the effect in ``resembles`` explains a part of the unknown error: it keeps its gain
    with ``described``, which is then the remaining part, in the model."""
    undescribed_arcsec: Mapping[str, float] = field(default_factory=dict)
    """RMS of the residual beyond the noise, by channel, if neither an effect nor a product of parts
    explains this error."""
    seen: str | None = None
    """Description of a detection that is not an effect of the catalogue and explains more than any
    of them, such as a jump or a damped oscillation."""
    oscillation: Oscillation | None = None
    """The damped oscillation that ``seen`` describes."""
    faults: tuple[str, ...] = ()
    """Faults of the data, one sentence each."""
    cannot_tell: str | None = None
    """Reason why the set does not show whether an effect is missing."""
    question: Question | None = None
    """Effects that the next measurement must distinguish; None if no planned measurement is to be
    calculated."""
    next: NextMeasurement | None = None
    """The next measurement, if the rule itself determines it."""
    further: Decision | None = None
    """The decision with the first effect in the model; None if that decision was not needed."""

    @property
    def rests_on(self) -> str:
        """Ground of the verdict ``unknown``, one of RESTS_ON; empty for other verdicts."""
        if self.verdict != "unknown":
            return ""
        found = (self.resembles, self.described, self.seen, True)
        return next(name for name, it in zip(RESTS_ON, found, strict=True) if it)

    @property
    def spoken_of(self) -> Candidate | None:
        """The effect that is named or first in the class; without such an effect, the effect that
        the unknown effect resembles."""
        return self.first or self.resembles
