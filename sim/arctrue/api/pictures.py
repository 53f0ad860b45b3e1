"""Shows pictures and HTML tables in a notebook."""

from __future__ import annotations

import base64
import html
import tempfile
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from arctrue.base.extras import needs_extras
from arctrue.base.whole_file import whole_file

if TYPE_CHECKING:
    from arctrue.report.charts.chart import Chart


@dataclass(frozen=True)
class Pictures:
    """PNG pictures, which a notebook shows.

    Parameters
    ----------
    images : dict of str to bytes
        The content of each PNG file, by file name.
    """

    images: dict[str, bytes]

    def save(self, folder: Path | str) -> list[Path]:
        """Write the pictures into a folder.

        Parameters
        ----------
        folder : Path or str
            The folder; it is made if it does not exist.

        Returns
        -------
        list of Path
            The files.

        Raises
        ------
        OSError
            The folder cannot be written.
        """
        paths = [Path(folder) / name for name in self.images]
        for path in paths:
            with whole_file(path) as unfinished:
                unfinished.write_bytes(self.images[path.name])
        return paths

    def _repr_html_(self) -> str:
        return "".join(
            f'<img alt="{html.escape(name)}" src="data:image/png;base64,'
            f'{base64.b64encode(image).decode("ascii")}">'
            for name, image in self.images.items()
        )


def pictures(charts: Callable[[], Mapping[str, Chart]]) -> Pictures:
    """Draw the charts that ``charts`` returns as PNG pictures, which are named after the charts.

    Raises MissingExtraError if matplotlib is not installed.
    """
    with needs_extras():
        from arctrue.report.charts.matplotlib_chart import save_charts

        drawn = charts()
        with tempfile.TemporaryDirectory() as folder:
            paths = save_charts(drawn, Path(folder))
            return Pictures({path.name: path.read_bytes() for path in paths})


def html_table(headings: Sequence[str], rows: Iterable[Sequence[object]]) -> str:
    """Return a table as HTML; the text of every cell is escaped."""

    def row(cells: Iterable[object], tag: str) -> str:
        return "<tr>" + "".join(f"<{tag}>{html.escape(str(c))}</{tag}>" for c in cells) + "</tr>"

    return (
        "<table>" + row(headings, "th") + "".join(row(cells, "td") for cells in rows) + "</table>"
    )
