"""Handles questions that a file leaves open: a user answers them; a script stops with an error."""

from __future__ import annotations

import math
import shlex
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field


@dataclass(frozen=True)
class Ambiguous:
    """Describes one question that the files leave open.

    Parameters
    ----------
    option : str
        The option of the command line that answers the question.
    question : str
        Text of the question, for people.
    answers : sequence of str
        Possible answers.
    free_text : bool, optional
        True: ``answers`` are examples, and any text may be given.
    numbered : mapping of str to str, optional
        Answers by the numbers under which the question lists them.
    key : str, optional
        Key of an option that takes ``KEY=ANSWER`` (``--unit head1=counts``).
    """

    option: str
    question: str
    answers: Sequence[str]
    free_text: bool = False
    """True: ``answers`` are examples, and any text is accepted."""
    numbered: Mapping[str, str] = field(default_factory=dict)
    """Answers by the numbers under which the question lists them."""
    key: str = ""

    @property
    def name(self) -> str:
        """Option, followed by its key if it has one; it identifies the question within an
        import."""
        return f"{self.option} {self.key}" if self.key else self.option

    def option_value(self, answer: str) -> str:
        """Return the text that the user types after the option to give this answer.

        Parameters
        ----------
        answer : str
            The answer.

        Returns
        -------
        str
            The answer, after the key if the option takes one.
        """
        return f"{self.key}={answer}" if self.key else answer

    def typed(self, answer: str) -> str:
        """Return the option with an answer, quoted for a shell.

        Parameters
        ----------
        answer : str
            The answer.

        Returns
        -------
        str
            Option and answer, quoted where the shell needs it.
        """
        return f"{self.option} {shlex.quote(self.option_value(answer))}"

    def in_words(self) -> str:
        """Return the question as a text that ends with the options to type.

        Returns
        -------
        str
            One or more sentences.
        """
        listed = ", ".join(map(self.typed, self.answers))
        more = "Answer for instance with:" if self.free_text else "Answer with one of:"
        return f"{self.question} {more} {listed}"


class AmbiguousError(ValueError):
    """Is raised when the files leave a question open and no person can answer it."""

    def __init__(self, asked: Ambiguous) -> None:
        """Compose the error message from the question and the options to type."""
        super().__init__(asked.in_words())
        self.asked = asked


def refuse(asked: Ambiguous) -> str:
    """Raise AmbiguousError, because a script has no user who could answer.

    Parameters
    ----------
    asked : Ambiguous
        The question.

    Returns
    -------
    str
        The function never returns.

    Raises
    ------
    AmbiguousError
        Always.
    """
    raise AmbiguousError(asked)


def checked_number(
    option: str,
    given: str | float,
    expected: str,
    allowed: Callable[[float], bool] = lambda _: True,
) -> float:
    """Return the number that a user gave for an option.

    Raises ValueError, which names option and expected value, if ``given`` is no finite number or is
    not ``allowed``.
    """
    try:
        number = float(given)
    except ValueError:
        number = math.nan
    if not (math.isfinite(number) and allowed(number)):
        raise ValueError(f"{option}: expected {expected}, found {given!r}")
    return number


def checked_period(given: str | float) -> float:
    """Return the time between two rows in seconds. Raises ValueError if it is not above 0."""
    return checked_number("--period", given, "seconds above 0", lambda period: period > 0.0)


_OF_THE_DATA = ("--zero", "--clock-offset", "--order")
"""Options that answer questions about time, order and zero, which the import asks last."""


def open_questions(
    attempt: Callable[[Choices], object], no: str, given: Mapping[str, str]
) -> list[Ambiguous]:
    """Find all questions of ``attempt`` that ``given`` leaves open.

    The search answers each question provisionally with the first possible answer, and collects the
    questions that follow. If ``no`` is the last possible answer of the question for the column of
    the error, the provisional answer is ``no``. If a provisional answer leads to an error, the
    search ends. A question about zero, clocks or row order is collected only if it comes first,
    because its answer depends on the data that the earlier answers select.
    """
    found: list[Ambiguous] = []

    def answer(asked: Ambiguous) -> str:
        if asked.option not in _OF_THE_DATA or not found:
            found.append(asked)
        may_lack = (asked.option, asked.key) == ("--column", "error") and asked.answers[-1] == no
        return asked.answers[-1 if may_lack else 0]

    with suppress(ValueError, OSError):
        attempt(Choices(answer, given=dict(given)))
    return found


@dataclass
class Choices:
    """Asks the user questions, and records the answers and the decisions of the import.

    Parameters
    ----------
    answer : callable, optional
        Function that answers an Ambiguous with a text; without it every question is refused.
    notes : list of str, optional
        Findings and decisions, one sentence each.
    answers : list of (str, str), optional
        Options with the answers that a person gave, as they would be typed.
    given : dict of str to str, optional
        Answers by :attr:`Ambiguous.name`.
    """

    answer: Callable[[Ambiguous], str] = refuse
    notes: list[str] = field(default_factory=list)
    answers: list[tuple[str, str]] = field(default_factory=list)
    given: dict[str, str] = field(default_factory=dict)

    def ask(self, asked: Ambiguous) -> str:
        """Return the answer to a question: the given one, or else the answer of the user.

        Parameters
        ----------
        asked : Ambiguous
            The question.

        Returns
        -------
        str
            The answer.

        Raises
        ------
        AmbiguousError
            If nobody answers.
        """
        if asked.name in self.given:
            return self.given[asked.name]
        answer = self.answer(asked)
        if answer not in asked.answers:
            answer = asked.numbered.get(answer, answer)
        self.given[asked.name] = answer
        self.answers.append((asked.option, asked.option_value(answer)))
        return answer

    def note(self, text: str) -> None:
        """Store a sentence for the summary; a sentence that is stored already is not repeated.

        Parameters
        ----------
        text : str
            The sentence.
        """
        if text not in self.notes:
            self.notes.append(text)
