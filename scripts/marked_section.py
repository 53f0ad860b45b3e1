"""The part of a hand-written page that a script writes: between its own mark and `<!-- end -->`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from arctrue.base.whole_file import write_whole_text

END = "<!-- end -->\n"


@dataclass(frozen=True, slots=True)
class MarkedSection:
    """The lines of ``page`` after the line ``begin`` and before the next ``END``."""

    page: Path
    begin: str

    def inserted(self, lines: str) -> str:
        """Return the text of the page with ``lines`` as its section.

        Raises ValueError if one of the two marks is missing.
        """
        before, begin, following = self.page.read_text(encoding="utf-8").partition(self.begin)
        _, end, after = following.partition(END)
        if not begin or not end:
            raise ValueError(f"{self.page} lacks the lines {self.begin.strip()} and {END.strip()}")
        return before + begin + lines + end + after

    def is_current(self, lines: str) -> bool:
        """Tell whether the page has ``lines`` as its section. Raises ValueError as ``inserted``."""
        return self.inserted(lines) == self.page.read_text(encoding="utf-8")

    def write(self, lines: str) -> None:
        """Replace the section by ``lines``. Raises ValueError as ``inserted``."""
        write_whole_text(self.page, self.inserted(lines))
