"""Shows the open questions of an import on one screen, with the first rows of the files."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from arctrue.cli._terminal import note
from arctrue.importing import Ambiguous
from arctrue.importing.questions import Import


def preview_lines(import_: Import) -> list[str]:
    """Return the previews of all files, one line per row."""
    return [line for preview in import_.previews() for line in preview.lines()]


def all_open(import_: Import, first: Ambiguous) -> str:
    """Return the message for a script: each question, its option, and the first rows of the
    files."""
    asked = import_.questions(first)
    if len(asked) == 1:
        return "\n".join([asked[0].in_words(), *preview_lines(import_)])
    return "\n".join(
        [
            f"{len(asked)} questions are open, and the answers may lead to others:",
            *(f"{number}. {item.in_words()}" for number, item in enumerate(asked, start=1)),
            *preview_lines(import_),
        ]
    )


@dataclass
class Asker:
    """Asks the user at the terminal; before the first question, it shows the first rows of the
    files and the names of all open questions."""

    import_: Import
    ask: Callable[[Ambiguous], str]
    _shown: bool = False

    def __call__(self, asked: Ambiguous) -> str:
        """Ask the question and return the answer."""
        if not self._shown:
            self._shown = True
            for line in preview_lines(self.import_):
                note(line)
            open_ = self.import_.questions(asked)
            note(f"open: {', '.join(item.name for item in open_)}")
        return self.ask(asked)
