"""Writes a self-contained report of text, tables and pictures as HTML and PDF, and its text and
tables as Markdown."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from markupsafe import Markup
from matplotlib.backends.backend_pdf import FigureCanvasPdf, PdfPages
from matplotlib.figure import Figure

from arctrue.base.printable import one_line
from arctrue.base.whole_file import whole_file, write_whole_text
from arctrue.report.html_templates import html_environment
from arctrue.report.svg import to_svg

_A4_INCHES = (8.27, 11.69)
_MARGIN = 0.06
"""Margin of a page, as a share of its width."""
COLUMNS = 110
"""Number of characters per line of a page."""
LINES = 72
"""Number of lines per page."""
_FONT_POINTS = 7.5


@dataclass(frozen=True)
class Text:
    """A paragraph of text."""

    text: str


@dataclass(frozen=True)
class Rows:
    """A table; the first ``names`` columns contain text, the further columns contain numbers."""

    title: str
    headings: Sequence[str]
    rows: Sequence[Sequence[str]]
    names: int = 1


@dataclass(frozen=True)
class Picture:
    """A picture, drawn as a matplotlib figure."""

    title: str
    figure: Figure


Block = Text | Rows | Picture


@dataclass(frozen=True)
class Document:
    """A report: title, facts (name and value), and its blocks in order."""

    title: str
    facts: Sequence[tuple[str, str]]
    blocks: Sequence[Block]


def write_document(document: Document, folder: Path, stem: str) -> list[Path]:
    """Write ``stem``.md, .html and .pdf into ``folder``. Raises OSError."""
    markdown, html, pdf = (folder / f"{stem}.{ending}" for ending in ("md", "html", "pdf"))
    write_whole_text(markdown, _markdown(document))
    write_whole_text(html, document_html(document))
    _write_pdf(document, pdf)
    return [markdown, html, pdf]


def _markdown(document: Document) -> str:
    lines = [f"# {_cell(document.title)}", "", "| | |", "|---|---|"]
    lines += [f"| {_cell(name)} | {_cell(value)} |" for name, value in document.facts]
    for block in document.blocks:
        lines.append("")
        if isinstance(block, Text):
            lines += textwrap.wrap(_as_text(block.text), 110)
        elif isinstance(block, Rows):
            rule = ["---"] * block.names + ["---:"] * (len(block.headings) - block.names)
            lines += [f"## {_cell(block.title)}", "", _row(block.headings), f"|{'|'.join(rule)}|"]
            lines += [_row(row) for row in block.rows]
    return "\n".join(lines) + "\n"


def _row(cells: Sequence[str]) -> str:
    return f"| {' | '.join(map(_cell, cells))} |"


def _cell(text: str) -> str:
    return _as_text(text).replace("|", "\\|")


def _as_text(text: str) -> str:
    """Escape text, because Markdown passes HTML on and reads brackets as links and pictures."""
    return one_line(text).replace("&", "&amp;").replace("<", "&lt;").replace("](", "]\\(")


def document_html(document: Document) -> str:
    """Return the document as one self-contained HTML file."""
    blocks: list[dict[str, object]] = []
    for block in document.blocks:
        if isinstance(block, Picture):
            blocks.append(
                {"kind": "Picture", "title": block.title, "svg": Markup(to_svg(block.figure))}
            )
        else:
            blocks.append({"kind": type(block).__name__, "block": block})
    template = html_environment().get_template("report.html.j2")
    return template.render(document=document, blocks=blocks)


def _write_pdf(document: Document, path: Path) -> None:
    lines: list[str] = [document.title, ""]
    width = max((len(name) for name, _ in document.facts), default=0)
    for name, value in document.facts:
        lines += _wrapped(f"{name:<{width}}  {one_line(value)}", width + 2)
    pictures = []
    for block in document.blocks:
        lines.append("")
        if isinstance(block, Text):
            lines += _wrapped(one_line(block.text), 0)
        elif isinstance(block, Rows):
            lines += [block.title, "", *table_lines(block)]
        else:
            pictures.append(block)
    with (
        whole_file(path) as unfinished,
        PdfPages(
            unfinished,
            metadata={
                "Title": one_line(document.title),
                "Creator": "arctrue",
                "CreationDate": None,
            },
        ) as pdf,
    ):
        for start in range(0, len(lines), LINES):
            pdf.savefig(text_page(lines[start : start + LINES]))
        for picture in pictures:
            pdf.savefig(picture.figure)


def text_page(lines: Sequence[str]) -> Figure:
    """Return an A4 page with these lines; the lines must fit on it."""
    page = Figure(figsize=_A4_INCHES)
    FigureCanvasPdf(page)
    page.text(
        _MARGIN,
        0.96,
        "\n".join(lines),
        family="DejaVu Sans Mono",
        size=_FONT_POINTS,
        verticalalignment="top",
        linespacing=1.35,
        parse_math=False,
    )
    return page


def _wrapped(text: str, indent: int) -> list[str]:
    return textwrap.wrap(text, COLUMNS, subsequent_indent=" " * indent) or [""]


def table_lines(block: Rows) -> list[str]:
    """Return the lines of the table. Each column is as wide as its longest text; if the lines are
    too long, the widest text columns become narrower and their text is wrapped."""
    numbers = [
        max(_width(row[i]) for row in (block.headings, *block.rows))
        for i in range(block.names, len(block.headings))
    ]
    left = COLUMNS - sum(numbers) - 2 * (len(block.headings) - 1)
    needed = [
        max(_width(row[i]) for row in (block.headings, *block.rows)) for i in range(block.names)
    ]
    while sum(needed) > left and max(needed) > 8:
        needed[needed.index(max(needed))] -= 1

    def lines_of(row: Sequence[str]) -> list[str]:
        cells = [
            textwrap.wrap(one_line(cell), width) or [""]
            for cell, width in zip(row, needed, strict=False)
        ]
        found = []
        for place in range(max(len(cell) for cell in cells)):
            texts = [
                _left(cell[place] if place < len(cell) else "", width)
                for cell, width in zip(cells, needed, strict=True)
            ]
            for cell, width in zip(row[block.names :], numbers, strict=True):
                texts.append(" " * (width - _width(cell)) + cell if place == 0 else " " * width)
            found.append("  ".join(texts).rstrip())
        return found

    rows = [line for row in block.rows for line in lines_of(row)]
    return [*lines_of(block.headings), "-" * COLUMNS, *rows]


def _width(text: str) -> int:
    """Return the printed width of a text in characters: the combining bar of x̄ has no width."""
    return len(text) - text.count("\u0304")


def _left(text: str, width: int) -> str:
    return text + " " * (width - _width(text))
