"""Writes a matplotlib figure to a file."""

from __future__ import annotations

from pathlib import Path

from matplotlib.figure import Figure

from arctrue.base.whole_file import whole_file


def save_picture(figure: Figure, path: Path, *, dots_per_inch: int = 150) -> Path:
    """Write the figure in the format of the file ending; make the folder if it does not exist.

    The file contains neither date nor program, so that equal figures give equal files. For a figure
    in the house style, call this within ``house_style``.
    """
    kind = path.suffix.removeprefix(".")
    path.parent.mkdir(parents=True, exist_ok=True)
    with whole_file(path) as unfinished:
        figure.savefig(
            unfinished,
            format=kind,
            dpi=dots_per_inch,
            metadata={"Date" if kind == "svg" else "Software": None},
        )
    return path
