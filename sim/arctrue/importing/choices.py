"""Questions that a file does not answer: asked of a person, or refused with the options."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field


@dataclass(frozen=True)
class Ambiguous:
    """One question: ``option`` of the command line answers it, with one of ``answers``."""

    option: str
    question: str
    answers: Sequence[str]
    free_text: bool = False
    """True: ``answers`` are examples, and any text may be given."""


class AmbiguousError(ValueError):
    """The files leave a question open, and nobody is there to answer it."""

    def __init__(self, asked: Ambiguous) -> None:
        """Say the question and what to type."""
        joined = "=" if asked.option.rpartition(" ")[0] else " "
        example = f"{asked.option}{joined}"
        listed = ", ".join(f"{example}{answer}" for answer in asked.answers)
        more = "Say it, for instance:" if asked.free_text else "Say it with one of:"
        super().__init__(f"{asked.question} {more} {listed}")
        self.asked = asked


def refuse(asked: Ambiguous) -> str:
    """The answer of a script: none. Raises AmbiguousError."""
    raise AmbiguousError(asked)


@dataclass
class Choices:
    """Asks, and keeps what was decided.

    ``notes``: what was found or decided, one sentence each. ``answers``: options with the answers
    that a person gave, as they would be typed.
    """

    answer: Callable[[Ambiguous], str] = refuse
    notes: list[str] = field(default_factory=list)
    answers: list[tuple[str, str]] = field(default_factory=list)

    def ask(self, asked: Ambiguous) -> str:
        """The answer, asked once. Raises AmbiguousError where nobody answers."""
        option, key = asked.option.partition(" ")[::2]
        start = f"{key}=" if key else ""
        for earlier, answer in self.answers:
            if earlier == option and answer.startswith(start):
                return answer.removeprefix(start)
        given = self.answer(asked)
        self.answers.append((option, f"{start}{given}"))
        return given

    def note(self, text: str) -> None:
        """Keep a sentence for the summary, once."""
        if text not in self.notes:
            self.notes.append(text)
