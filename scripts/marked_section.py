"""Reads and replaces the section of a hand-written page that a script writes: the lines between the
script's mark and `<!-- end -->`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from arctrue.base.whole_file import write_whole_text

END = "<!-- end -->\n"


@dataclass(frozen=True, slots=True)
class MarkedSection:
    """Section of ``page``: the lines between the line ``begin`` and the next line ``END``."""

    page: Path
    begin: str

    def inserted(self, lines: str) -> str:
        """Return the text of the page with ``lines`` as its section.

        Raises ValueError if the mark at the beginning or at the end is missing.
        """
        before, begin, following = self.page.read_text(encoding="utf-8").partition(self.begin)
        _, end, after = following.partition(END)
        if not begin or not end:
            raise ValueError(f"{self.page} lacks the lines {self.begin.strip()} and {END.strip()}")
        return before + begin + lines + end + after

    def is_current(self, lines: str) -> bool:
        """Tell whether the section of the page consists of ``lines``. Raises ValueError like
        ``inserted``."""
        return self.inserted(lines) == self.page.read_text(encoding="utf-8")

    def write(self, lines: str) -> None:
        """Replace the section of the page by ``lines``. Raises ValueError like ``inserted``."""
        write_whole_text(self.page, self.inserted(lines))
