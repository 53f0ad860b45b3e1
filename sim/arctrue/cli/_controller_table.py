"""Writes the correction of a model as a table for another controller."""

from __future__ import annotations

from pathlib import Path

from arctrue.base.printable import one_line
from arctrue.base.whole_file import write_whole_text
from arctrue.cli._loaded_set import LoadedSet, console, write_json
from arctrue.cli._refused import end_unless_written, may_write
from arctrue.metrology.controllers import TableFormat
from arctrue.metrology.correction import Correction, table_objections


def write_controller_table(
    loaded: LoadedSet,
    correction: Correction,
    form: TableFormat,
    points: int,
    path: Path,
    json_file: Path | None,
    *,
    force: bool,
) -> None:
    """Write ``correction`` in the format ``form``, and print the orders that the table contains.

    Exits with NOT_WRITTEN if the table would increase the error of the reference run and ``force``
    is False.
    """
    text = form.text(correction, points, one_line(loaded.measurement))
    left = form.left(text, correction)
    refused = table_objections(
        loaded.measurement_set.reference, correction, loaded.observations.counts_per_rev
    )
    left_out = form.not_corrected(correction)
    written = may_write(correction.warnings, refused, force=force)
    if written:
        write_whole_text(path, text)
    orders = ", ".join(map(str, correction.orders)) or "none"
    console.print(f"orders in the table: {orders}", soft_wrap=True)
    console.print(
        f"{form.name}, {points} steps a turn: the table, as the controller interpolates it, "
        f"differs from the model by at most {left.largest_arcsec:.3f}″ ({left.rms_arcsec:.3f}″ "
        "RMS)",
        soft_wrap=True,
    )
    for one in left_out:
        console.print(f"not corrected: {one}", soft_wrap=True)
    if written:
        console.print(f"wrote {path}", soft_wrap=True)
    write_json(
        json_file,
        {
            "schema": 1,
            "file": str(path) if written else None,
            "format": form.name,
            "points": points,
            "refused": refused,
            "orders": correction.orders,
            "reversal_arcsec": correction.reversal_arcsec,
            "left_arcsec": {"largest": left.largest_arcsec, "rms": left.rms_arcsec},
            "not_corrected": left_out,
        },
    )
    end_unless_written(path, written=written)
