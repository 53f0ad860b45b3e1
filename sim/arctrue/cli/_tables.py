"""Tables on the terminal: text is wrapped, numbers are never broken, 80 columns suffice."""

from __future__ import annotations

from collections.abc import Sequence

from rich.table import Column, Table

WIDTH = 80
"""Width in columns of the narrowest terminal that every table fits."""


def words(heading: str = "") -> Column:
    """Make a left-aligned column of text; long text continues on the next line."""
    return Column(heading, overflow="fold")


def number(heading: str) -> Column:
    """Make a right-aligned column of numbers; a line break in the heading keeps it narrow."""
    return Column(heading, justify="right", no_wrap=True)


def table(title: str, *columns: Column, lines: bool = False) -> Table:
    """Make an empty table of these columns; ``lines`` draws a line below each row."""
    return Table(*columns, title=title, title_justify="left", show_lines=lines)


def pairs() -> Table:
    """Make an empty two-column table of terms and their descriptions, without lines."""
    return Table.grid(padding=(0, 2))


def live_row(cells: Sequence[str], columns: Sequence[tuple[str, int]]) -> str:
    """Format a row of a table that is printed row by row (rich prints a table only when complete).

    ``columns``: heading and width of each; a negative width aligns to the left.
    """
    return " ".join(
        cell.ljust(-width) if width < 0 else cell.rjust(width)
        for cell, (_, width) in zip(cells, columns, strict=True)
    ).rstrip()


def live_head(columns: Sequence[tuple[str, int]]) -> str:
    """Format the headings of a table that :func:`live_row` prints row by row."""
    return live_row([heading for heading, _ in columns], columns)
