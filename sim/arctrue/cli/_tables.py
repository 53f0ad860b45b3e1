"""Tables on the terminal: words are folded, numbers are never broken, 80 columns are enough."""

from __future__ import annotations

from collections.abc import Sequence

from rich.table import Column, Table

WIDTH = 80
"""Columns of the narrowest terminal that every table fits into."""


def words(heading: str = "") -> Column:
    """A column of text, on the left; what is too long goes on in the next line."""
    return Column(heading, overflow="fold")


def number(heading: str) -> Column:
    """A column of numbers, on the right; a line break in the heading keeps it narrow."""
    return Column(heading, justify="right", no_wrap=True)


def table(title: str, *columns: Column, lines: bool = False) -> Table:
    """An empty table of these columns; ``lines``: one below each row."""
    return Table(*columns, title=title, title_justify="left", show_lines=lines)


def pairs() -> Table:
    """An empty table of words and what they stand for, without lines."""
    return Table.grid(padding=(0, 2))


def live_row(cells: Sequence[str], columns: Sequence[tuple[str, int]]) -> str:
    """A line of a table whose rows come one by one, which rich could draw at its end only.

    ``columns``: headings and widths, negative ones on the left.
    """
    return " ".join(
        cell.ljust(-width) if width < 0 else cell.rjust(width)
        for cell, (_, width) in zip(cells, columns, strict=True)
    ).rstrip()


def live_head(columns: Sequence[tuple[str, int]]) -> str:
    """The headings of such a table."""
    return live_row([heading for heading, _ in columns], columns)
