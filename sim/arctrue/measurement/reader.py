"""Reads a measurement set; raises a MeasurementError for a faulty file."""

from __future__ import annotations

import difflib
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from arctrue.base.progress import ReportBytes
from arctrue.measurement.csv_blocks import Columns, CsvFile
from arctrue.measurement.date import moment
from arctrue.measurement.description import (
    Channel,
    Description,
    ReferenceKeys,
    read_description,
)
from arctrue.measurement.error_sign import of_opposite_sign
from arctrue.measurement.errors import MeasurementError
from arctrue.measurement.mask_file import with_mask_file
from arctrue.measurement.measurement_set import (
    CAPTURE_COLUMNS,
    CAPTURE_OPTIONAL,
    HEAD_COLUMNS,
    REFERENCE_COLUMNS,
    REFERENCE_OPTIONAL,
    Capture,
    MeasurementSet,
    Reference,
    Table,
)
from arctrue.measurement.uncertainty import of_zero
from arctrue.measurement.wraps import same_turn, unwrapped_counts, without_wraps


def read_measurement_set(
    folder: Path | str, *, report_bytes: ReportBytes | None = None
) -> MeasurementSet:
    """Read a whole measurement set into memory.

    Each field needs 8 bytes; while the blocks of a file are joined, one column is in memory twice.

    Parameters
    ----------
    folder : Path or str
        The folder with ``measurement.toml``.
    report_bytes : callable, optional
        Function that is called with file, bytes read and size in bytes for every block that
        pyarrow reads.

    Returns
    -------
    MeasurementSet
        The set with the content of its files.

    Raises
    ------
    MeasurementError
        If a file is missing or wrong; the error names file, row, column, expected and found value.
    """
    folder = Path(folder)
    description = read_description(folder)
    warnings = list(description.warnings)
    capture_path = data_file(description, "capture")
    reference_path = data_file(description, "reference")
    if capture_path is None and reference_path is None:
        raise MeasurementError(
            "missing", folder, "has neither a capture.csv nor a reference.csv: nothing was measured"
        )
    heads = compared = None
    if capture_path:
        heads = _capture(description, capture_path, warnings, report_bytes)
        heads = with_mask_file(folder, "capture", capture_path, heads, warnings)
        warnings += of_zero(heads, f"{capture_path}", 2)
    if reference_path:
        compared = _reference(description, reference_path, warnings, report_bytes)
        compared = with_mask_file(folder, "reference", reference_path, compared, warnings)
        warnings += of_zero(compared, f"{reference_path}", 2)
        warnings += of_opposite_sign(compared, description.keys.table, f"{reference_path}")
    return MeasurementSet(
        table=description.keys.table,
        capture=heads,
        reference=compared,
        title=description.keys.title,
        origin=description.keys.origin,
        other=description.other,
        warnings=tuple(warnings),
        folder=folder,
        date=moment(description.keys.date) if description.keys.date else None,
    )


def unread_columns(measurement: MeasurementSet, folder: Path) -> list[tuple[Path, str]]:
    """Return file and name of each column in ``folder`` that ``measurement`` lacks, because the
    column is not numeric or its name occurs twice. Raises MeasurementError."""
    description = read_description(folder)
    found: list[tuple[Path, str]] = []
    for section, rows, required, optional in (
        ("capture", measurement.capture, CAPTURE_COLUMNS, CAPTURE_OPTIONAL),
        ("reference", measurement.reference, REFERENCE_COLUMNS, REFERENCE_OPTIONAL),
    ):
        path = data_file(description, section)
        if path is not None and rows is not None:
            header = CsvFile(path, required, optional).header
            read = {*required, *optional, *rows.conditions}
            found += [(path, name) for name in dict.fromkeys(header) if name not in read]
    return found


@contextmanager
def open_capture(folder: Path | str) -> Iterator[Iterator[Columns]]:
    """Yield the capture of a set in checked blocks, for sets that do not fit into the memory.

    Parameters
    ----------
    folder : Path or str
        The folder with ``measurement.toml``.

    Yields
    ------
    iterator of dict of str to ndarray, shape (rows,)
        The columns of each block, in the units of ``capture.csv``.

    Raises
    ------
    MeasurementError
        If the set has no capture, or a file is wrong.
    """
    description = read_description(Path(folder))
    path = data_file(description, "capture")
    if path is None:
        raise MeasurementError("missing", Path(folder), "has no capture.csv")
    _require_for_capture(description.keys.table, description.path, description.other)
    yield _checked_blocks(CsvFile(path, CAPTURE_COLUMNS, CAPTURE_OPTIONAL))


def data_file(description: Description, section: str) -> Path | None:
    """Return the file of the section "capture" or "reference"; None if the description has no such
    section and the file of the default name does not exist.

    Raises MeasurementError if the description has the section, but its file does not exist.
    """
    keys: Channel | None = getattr(description.keys, section)
    name = None if keys is None else keys.file
    path = description.path.parent / (name or f"{section}.csv")
    try:
        there = path.is_file()
    except OSError as error:  # the name is not valid for any file
        raise MeasurementError(
            "value", description.path, f"{section}.file: {error.strerror}: {str(name)[:80]!r}"
        ) from error
    if there:
        return path
    if keys is not None:
        found = "is a folder" if path.is_dir() else "no such file"
        raise MeasurementError(
            "missing", path, f"{found}, but {description.path.name} has a [{section}]"
        )
    return None


def _require_for_capture(table: Table, path: Path, other: Iterable[str] = ()) -> None:
    """Raise MeasurementError if ``table`` lacks keys that a capture needs.

    ``path``: file in which the table's keys are expected; ``other``: unknown keys in this file.
    """
    for key in ("counts_per_rev", "head_separation_deg"):
        if getattr(table, key) is None:
            near = difflib.get_close_matches(f"table.{key}", list(other), 1)
            meant = f"; {near[0]} is not known: is it meant?" if near else ""
            raise MeasurementError(
                "missing", path, f"table.{key}: is missing; a capture needs it{meant}"
            )
    if table.head_separation_deg == 0:
        raise MeasurementError(
            "value",
            path,
            "table.head_separation_deg: expected an angle other than 0, found 0: "
            "two heads at the same place see no difference",
        )


def _capture(
    description: Description, path: Path, warnings: list[str], report_bytes: ReportBytes | None
) -> Capture:
    _require_for_capture(description.keys.table, description.path, description.other)
    file = CsvFile(
        path, CAPTURE_COLUMNS, CAPTURE_OPTIONAL, report_bytes=report_bytes, with_conditions=True
    )
    columns = _typed(file, _joined(list(_checked_blocks(file))))
    _require_a_place_each(description.keys.table, path, columns, description.path)
    count_on_past_the_turn(description.keys.table, path, columns, warnings)
    warnings.extend(file.warnings)
    keys = description.keys.capture
    return Capture(**columns, clock_hz=None if keys is None else keys.clock_hz)


def require_heads(table: Table, path: Path, columns: dict[str, Any], of_table: Path) -> None:
    """Raise MeasurementError if the table of a capture does not state the counts of a turn and a
    place for each head.

    ``path``, ``of_table``: files of the columns and of the table, for the message.
    """
    _require_for_capture(table, of_table)
    _require_a_place_each(table, path, columns, of_table)


def _require_a_place_each(
    table: Table, path: Path, columns: dict[str, Any], of_table: Path
) -> None:
    """Raise MeasurementError if the number of heads of a capture differs from the number of places
    of its table."""
    places = table.places_deg
    assert places is not None
    there = [name for name in HEAD_COLUMNS if name in columns]
    if there != list(HEAD_COLUMNS[: len(there)]):
        raise MeasurementError(
            "missing", path, "is missing; a capture with head4_counts needs it",
            row=1, column="head3_counts",
        )  # fmt: skip
    if len(there) != len(places):
        key = "table.head_places_deg"
        raise MeasurementError(
            "value",
            of_table,
            f"{key}: expected a place for each of the {len(there)} heads of {path.name}, found "
            f"{len(places)}; {_places_of(len(there))}",
        )


def _places_of(heads: int) -> str:
    example = [0, 33, 162.5, 300.5][:heads]
    return f"write head_places_deg = {example} with the angles of your table after head 1"


def count_on_past_the_turn(
    table: Table, path: Path, columns: dict[str, Any], warnings: list[str]
) -> None:
    """Continue counts that restart at each turn; then shift each further head by whole turns.

    After the shift, each head's counts differ from those of head 1 by the angle of its place. If no
    count restarts, nothing is changed. The function changes the ``columns`` of a capture; ``path``,
    their file, is named in ``warnings``.
    """
    counts_per_rev, places_deg = table.counts_per_rev, table.places_deg
    assert counts_per_rev is not None
    assert places_deg is not None
    heads = [name for name in HEAD_COLUMNS if name in columns]
    wrapped = 0
    for name in heads:
        columns[name], wraps = unwrapped_counts(
            columns[name], columns["run"], columns["time_s"], counts_per_rev
        )
        wrapped += wraps
        if wraps:
            warnings.append(
                f"{path}: {name} starts anew at {counts_per_rev} counts {wraps} times; it is "
                "continued past the turn"
            )
    if wrapped:
        for name, place_deg in zip(heads[1:], places_deg[1:], strict=True):
            columns[name] = same_turn(
                columns["head1_counts"],
                columns[name],
                columns["run"],
                counts_per_rev,
                place_deg,
            )


def _reference(
    description: Description, path: Path, warnings: list[str], report_bytes: ReportBytes | None
) -> Reference:
    file = CsvFile(
        path, REFERENCE_COLUMNS, REFERENCE_OPTIONAL, report_bytes=report_bytes, with_conditions=True
    )
    columns = _typed(file, _joined(list(_checked_blocks(file))))
    columns["error_arcsec"], wrapped = without_wraps(columns["error_arcsec"])
    if wrapped.size:
        warnings.append(
            f"{path}, row {file.row_of(int(wrapped[0]))}, column error_arcsec: differs by whole "
            f"turns from the other rows, as in {wrapped.size} rows in all; these turns are "
            "subtracted"
        )
    warnings.extend(file.warnings)
    direction = columns.get("direction")
    if direction is not None:
        _require(file, "direction", direction, np.abs(direction) == 1, "+1 or -1")
    keys = description.keys.reference or ReferenceKeys()
    return Reference(
        **columns,
        instrument=keys.instrument,
        faces=description.keys.table.faces if keys.faces is None else keys.faces,
        standard_uncertainty_arcsec=keys.standard_uncertainty_arcsec,
        clock_offset_s=keys.clock_offset_s,
    )


def _joined(blocks: list[Columns]) -> dict[str, Any]:
    # The blocks are joined column by column, so that only one column is in memory twice. If a
    # condition is missing in a later block, because a field there is not a number, the condition is
    # left out.
    names = [name for name in blocks[0] if all(name in block for block in blocks)]
    return {name: np.concatenate([block.pop(name) for block in blocks]) for name in names}


def _typed(file: CsvFile, columns: dict[str, Any]) -> dict[str, Any]:
    """Return the columns with ``mask`` as booleans and all conditions in one mapping.

    Raises MeasurementError for a mask other than 0 or 1, or for a negative uncertainty.
    """
    mask, uncertainty = columns.get("mask"), columns.get("u_arcsec")
    if mask is not None:
        _require(file, "mask", mask, (mask == 0) | (mask == 1), "0 or 1")
        columns["mask"] = mask == 1
    if uncertainty is not None:
        _require(file, "u_arcsec", uncertainty, uncertainty >= 0.0, "0 or more")
    conditions = {name: columns.pop(name) for name in file.conditions if name in columns}
    return {**columns, "conditions": conditions}


def _require(file: CsvFile, column: str, values: Any, right: Any, expected: str) -> None:
    wrong = np.flatnonzero(~right)
    if wrong.size:
        place = int(wrong[0])
        raise MeasurementError(
            "value",
            file.path,
            f"expected {expected}, found {values[place]}",
            row=file.row_of(place),
            column=column,
        )


def _checked_blocks(file: CsvFile) -> Iterator[Columns]:
    """Yield the blocks of ``file``; check that the rows of each run follow one another and that the
    time never decreases within a run."""
    finished: set[int] = set()
    last_run: int | None = None
    last_time = 0.0
    start = 0
    for block in file.blocks():
        runs, times = block.get("run"), block.get("time_s")
        if runs is None and times is not None:
            runs = np.zeros(times.size, dtype=np.int64)
        if runs is not None:
            before_run = np.concatenate(([runs[0] if last_run is None else last_run], runs[:-1]))
            changes = np.flatnonzero(runs != before_run)
            for index in changes:
                finished.add(int(before_run[index]))
                if int(runs[index]) in finished:
                    raise MeasurementError(
                        "order",
                        file.path,
                        f"run {runs[index]} continues here after another run; the rows of a run "
                        "must be together",
                        row=file.row_of(start + int(index)),
                        column="run",
                    )
            if times is not None:
                before = np.concatenate(([times[0] if last_run is None else last_time], times[:-1]))
                back = np.flatnonzero((times < before) & (runs == before_run))
                if back.size:
                    first = int(back[0])
                    raise MeasurementError(
                        "time",
                        file.path,
                        f"time runs backwards, from {before[first]} to {times[first]} s",
                        row=file.row_of(start + first),
                        column="time_s",
                    )
                last_time = float(times[-1])
            last_run = int(runs[-1])
            start += runs.size
        yield block
