"""Makes tables for the terminal: text is wrapped, numbers are never broken, and 80 columns
suffice."""

from __future__ import annotations

from collections.abc import Sequence

from rich.table import Column, Table

WIDTH = 80
"""Width in columns of the narrowest terminal on which every table fits."""


def words(heading: str = "") -> Column:
    """Return a left-aligned column of text; long text continues on the next line."""
    return Column(heading, overflow="fold")


def number(heading: str) -> Column:
    """Return a right-aligned column of numbers; a line break in the heading keeps the column
    narrow."""
    return Column(heading, justify="right", no_wrap=True)


def table(title: str, *columns: Column, lines: bool = False) -> Table:
    """Return an empty table with these columns; ``lines`` draws a line below each row."""
    return Table(*columns, title=title, title_justify="left", show_lines=lines)


def pairs() -> Table:
    """Return an empty table without lines, for terms and their descriptions."""
    return Table.grid(padding=(0, 2))


def live_row(cells: Sequence[str], columns: Sequence[tuple[str, int]]) -> str:
    """Return one row of a table that is printed row by row (rich prints only complete tables).

    ``columns``: heading and width of each column; a negative width aligns the column to the left.
    """
    return " ".join(
        cell.ljust(-width) if width < 0 else cell.rjust(width)
        for cell, (_, width) in zip(cells, columns, strict=True)
    ).rstrip()


def live_head(columns: Sequence[tuple[str, int]]) -> str:
    """Return the headings of a table whose rows :func:`live_row` formats."""
    return live_row([heading for heading, _ in columns], columns)
