"""Makes a measurement set from the contents of files, asks the user, and records the decisions."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from datetime import datetime
from typing import Any

import numpy as np
from numpy.typing import NDArray

from arctrue.base.runs import run_spans
from arctrue.base.units import ARCSEC_PER_TURN
from arctrue.importing.choices import Ambiguous, Choices
from arctrue.importing.clocks import ClockOffset, UndeterminedOffsetError, clock_offset
from arctrue.importing.columns import NONE, Mapped, map_columns, tell_unused, timed_error
from arctrue.importing.errors_and_signs import error_of_readings, one_zero, signed_error
from arctrue.importing.file_content import FileContent
from arctrue.importing.file_rows import FileRows, rows_of
from arctrue.importing.motion import Pass, cycles, passes
from arctrue.importing.quantities import HEADS
from arctrue.importing.row_order import in_order
from arctrue.measurement import Capture, MeasurementSet, Reference, Table
from arctrue.measurement.wraps import same_turn, unwrapped_counts

Integer = NDArray[np.int64]
Float = NDArray[np.float64]

LATE_START_S = 1e6
"""Latest first time (seconds) of a log whose times count from the log's start; later first times
count from an epoch."""
SIDEREAL_DEG_S = 360.0 / 86164.0905
"""Speed of an axis that follows the stars: a turn in a sidereal day (IERS Conventions 2010, chapter
1: nominal mean rotation of the Earth)."""
KEEP_ZERO, REFERENCE_ZERO = "keep", "shift"


@dataclass(frozen=True)
class Settings:
    """Statements of the user about the files; "" or None means that the user stated nothing.

    Parameters
    ----------
    columns : mapping of str to str, optional
        Name of the column, by quantity.
    units : mapping of str to str, optional
        Unit of the column, by quantity.
    sign : {"", "reading-true", "true-reading"}, optional
        Sign of an error column.
    zero : {"", "keep", "shift"}, optional
        ``shift`` moves the reference's zero to the zero of the reading.
    clock_offset_s : float, optional
        Encoder's time minus the reference's time, seconds.
    rate_deg_s : float, optional
        Constant speed of the axis, degrees per second, for files with times and errors but no
        angle.
    missing : {"", "drop"}, optional
        ``drop`` leaves out the rows in which a value is missing.
    order : str, optional
        Treatment of rows whose time steps back, see ``row_order``.
    table : Table, optional
        Description of the table, as in the measurement set.
    instrument : str, optional
        Name of the reference instrument.
    standard_uncertainty_arcsec : float, optional
        Standard uncertainty of the reference, arcseconds.
    title : str, optional
        One line that names the set.
    date : datetime, optional
        Date and time of the measurement, with the time zone.
    """

    columns: Mapping[str, str] = field(default_factory=dict)
    units: Mapping[str, str] = field(default_factory=dict)
    sign: str = ""
    zero: str = ""
    clock_offset_s: float | None = None
    rate_deg_s: float | None = None
    missing: str = ""
    order: str = ""
    table: Table = field(default_factory=Table)
    instrument: str | None = None
    standard_uncertainty_arcsec: float | None = None
    title: str = ""
    date: datetime | None = None


@dataclass(frozen=True)
class Imported:
    """Holds a measurement set that was assembled from recordings.

    Parameters
    ----------
    measurement : MeasurementSet
        The set.
    mapped : sequence of dict
        Source of each column: for each file a mapping by quantity.
    notes : sequence of str
        Decisions of the import, one sentence each.
    clocks : ClockOffset, optional
        Offset between the clocks of two logs.
    """

    measurement: MeasurementSet
    mapped: Sequence[Mapped]
    notes: Sequence[str]
    clocks: ClockOffset | None = None


def import_recordings(
    recordings: Sequence[FileContent], settings: Settings, choices: Choices
) -> Imported:
    """Make a measurement set from recordings.

    Files with the same quantities become successive runs of one set. If one file has a reading and
    another file has a reference, they are two logs of one motion; the function aligns their clocks
    and interpolates the reading at the reference's times.

    Parameters
    ----------
    recordings : sequence of FileContent
        Contents of the files, as readers returned them.
    settings : Settings
        Statements of the user about the files.
    choices : Choices
        Asks the user for the missing statements.

    Returns
    -------
    Imported
        The set and the decisions.

    Raises
    ------
    MeasurementError
        If a value is missing or is not a number (the error names file, row and column), or if no
        row has all values.
    AmbiguousError
        If a question is open.
    ValueError
        If the columns make no set, or files contradict each other.
    """
    for recording in recordings:
        for text in recording.notes:
            choices.note(text)
    mapped = map_columns(recordings, settings.columns, settings.units, choices)
    table = settings.table
    if table.counts_per_rev is None and _needs_counts(mapped):
        asked = Ambiguous(
            "--counts-per-rev", "How many counts are one turn?", ["16777216"], free_text=True
        )
        table = replace(table, counts_per_rev=_whole(choices.ask(asked)))
    files = [
        rows_of(recording, sources, table.counts_per_rev, settings.missing, choices)
        for recording, sources in zip(recordings, mapped, strict=True)
    ]
    files = [in_order(f, settings.order, choices) for f in files]
    files = _from_the_start(files, choices)
    files = [_turning(f, settings.rate_deg_s, choices) for f in files]
    encoders = [f for f in files if "head1" in f.angles and "target" not in f.angles]
    references = [f for f in files if "target" in f.angles]
    clocks: ClockOffset | None = None
    lonely = [f for f in references if not {"head1", "error"} & set(f.angles)]
    if lonely:
        references, clocks = _joined_logs(encoders, lonely, references, settings, choices)
    heads = [f for f in files if {"head1", "head2"} <= set(f.angles) and f.time_s is not None]
    capture = None
    if heads:
        table = _with_places(table, _heads_of(heads), choices)
        capture = _capture(heads, table, choices)
    settings = replace(settings, table=table)
    reference = _reference(references, settings, choices) if references else None
    if reference is not None and clocks is not None and capture is not None:
        reference = replace(reference, clock_offset_s=clocks.offset_s)
    if capture is None and reference is None:
        raise ValueError(
            "the columns make neither a capture (time, head1 and head2) nor a reference run "
            "(target, with error or head1)"
        )
    tell_unused(recordings, mapped, settings.columns, choices)
    measurement = MeasurementSet(
        table, capture, reference, title=settings.title, date=settings.date
    )
    return Imported(measurement, mapped, tuple(choices.notes), clocks)


def _whole(text: str) -> int:
    try:
        return int(text)
    except ValueError:
        raise ValueError(f"expected a whole number, found {text!r}") from None


def _needs_counts(mapped: Sequence[Mapped]) -> bool:
    in_counts = any(source.unit == "counts" for sources in mapped for source in sources.values())
    return in_counts or any({"head1", "head2"} <= set(sources) for sources in mapped)


def _heads_of(files: Sequence[FileRows]) -> list[str]:
    """Return the names of the heads that the files contain. Raises ValueError for a head 4 without
    a head 3."""
    there = [name for name in HEADS if any(name in rows.angles for rows in files)]
    if there != list(HEADS[: len(there)]):
        raise ValueError("found head4 without head3: number the heads without a gap")
    return there


def _with_places(table: Table, heads: Sequence[str], choices: Choices) -> Table:
    """Return the table with a place for each head; ask the user for missing places."""
    places = table.places_deg
    if places is not None:
        if len(places) == len(heads):
            return table
        raise ValueError(
            f"expected a place for each of the {len(heads)} heads, found {len(places)}: give "
            f"--places {','.join(map(str, (0, 33, 162.5, 300.5)[: len(heads)]))} with the places "
            "of your table"
        )
    if len(heads) > 2:
        asked = Ambiguous(
            "--places",
            f"At how many degrees from head 1 are the {len(heads)} heads, in the direction of "
            "increasing counts?",
            ["0,120,240" if len(heads) == 3 else "0,64.3,177,257.9"],
            free_text=True,
        )
        given = choices.ask(asked)
        try:
            return replace(table, head_places_deg=tuple(float(one) for one in given.split(",")))
        except ValueError as error:
            raise ValueError(f"--places {given}: {error}") from None
    asked = Ambiguous(
        "--separation",
        "At how many degrees from head 1 is head 2, in the direction of increasing counts?",
        ["180", "90", "33"],
        free_text=True,
    )
    given = choices.ask(asked)
    try:
        return replace(table, head_separation_deg=float(given))
    except ValueError:
        raise ValueError(f"--separation: expected degrees, found {given!r}") from None


def _from_the_start(files: list[FileRows], choices: Choices) -> list[FileRows]:
    """Subtract the earliest time, rounded down to whole seconds, if the times count from an
    epoch."""
    starts = [float(f.time_s[0]) for f in files if f.time_s is not None and f.time_s.size]
    if not starts or min(starts) < LATE_START_S:
        return files
    start = float(np.floor(min(starts)))
    choices.note(f"times count from {start:.0f} s, the beginning of the first log")
    return [f if f.time_s is None else replace(f, time_s=f.time_s - start) for f in files]


def _turning(rows: FileRows, rate_deg_s: float | None, choices: Choices) -> FileRows:
    """Add the angle to a file of times and errors, for an axis that turns at constant speed."""
    if not timed_error(rows.sources) or rows.time_s is None:
        return rows
    if rate_deg_s is None:
        asked = Ambiguous(
            "--rate",
            f"{rows.name} has times and errors but no angle. How fast does the axis turn, in "
            f"degrees per second? A telescope that follows the stars: {SIDEREAL_DEG_S:.9f}.",
            [f"{SIDEREAL_DEG_S:.9f}"],
            free_text=True,
        )
        text = choices.ask(asked)
        try:
            rate_deg_s = float(text)
        except ValueError:
            raise ValueError(f"--rate: expected degrees per second, found {text!r}") from None
    if not np.isfinite(rate_deg_s) or rate_deg_s == 0.0:
        raise ValueError(f"--rate: expected degrees per second other than 0, found {rate_deg_s:g}")
    choices.note(f"{rows.name}: the angle is {rate_deg_s:.9g}°/s times the time (--rate)")
    return replace(rows, angles={**rows.angles, "target": rows.time_s * (rate_deg_s / 360.0)})


def _joined_logs(
    encoders: list[FileRows],
    lonely: list[FileRows],
    references: list[FileRows],
    settings: Settings,
    choices: Choices,
) -> tuple[list[FileRows], ClockOffset | None]:
    """Return the references and the clock offset; the reference without a reading gets the
    encoder's reading, interpolated at the reference's times."""
    if len(encoders) != 1 or len(lonely) != 1:
        raise ValueError(
            f"{len(encoders)} files have a reading without a reference and {len(lonely)} "
            "have a reference without a reading; expected one of each: import each pair by "
            "itself, then use arctrue join"
        )
    encoder, log = encoders[0], lonely[0]
    for one in (encoder, log):
        if one.time_s is None:
            raise ValueError(f"{one.name}: two logs are aligned by their times; name the column "
                             "of times by --column time=…")  # fmt: skip
        _require_order(one)
    assert encoder.time_s is not None
    assert log.time_s is not None
    reading = encoder.unwrapped("head1", choices)
    target = log.unwrapped("target", choices)
    clocks = _clocks(log.time_s, target, encoder.time_s, reading, settings, choices)
    at = log.time_s + clocks.offset_s
    inside = (at >= encoder.time_s[0]) & (at <= encoder.time_s[-1])
    if not inside.any():
        raise ValueError(f"{encoder.name} and {log.name} do not overlap in time")
    if not inside.all():
        choices.note(
            f"{int((~inside).sum())} rows of {log.name} are outside the times of {encoder.name} "
            "and are left out"
        )
    found = replace(log, angles={**log.angles, "target": target}).where(inside)
    head1 = np.interp(at[inside], encoder.time_s, reading)
    found = replace(found, angles={**found.angles, "head1": head1})
    return [f for f in references if f is not log] + [found], clocks


def _require_order(rows: FileRows) -> None:
    assert rows.time_s is not None
    back = np.flatnonzero(np.diff(rows.time_s) <= 0.0)
    if back.size:
        raise rows.fault("time steps back here", int(back[0]) + 1, "time")


def _clocks(
    reference_time_s: Float,
    target: Float,
    time_s: Float,
    reading: Float,
    settings: Settings,
    choices: Choices,
) -> ClockOffset:
    nan = float("nan")
    if settings.clock_offset_s is not None:
        return ClockOffset(settings.clock_offset_s, nan, nan, nan, nan)
    try:
        found = clock_offset(reference_time_s, target, time_s, reading)
    except UndeterminedOffsetError as error:
        candidates = [f"{value:.6g}" for value in error.candidates_s] or ["0"]
        given = choices.ask(
            Ambiguous(
                "--clock-offset",
                f"The two logs: {error}. How many seconds must be added to the reference's time?",
                candidates,
                free_text=not error.candidates_s,
            )
        )
        return ClockOffset(float(given), nan, nan, nan, nan)
    choices.note(
        f"clocks: {found.offset_s:+.6f} s are added to the reference's time, standard uncertainty "
        f"{found.u_s:.2g} s; the offsets of parts differ by at most {found.left_s:.2g} s, "
        f"the rates differ by {found.drift_ppm:.2g} ± {found.u_drift_ppm:.2g} ppm"
    )
    return found


def _labelled(
    rows: FileRows, angle: Float, choices: Choices, *, split: bool
) -> tuple[Integer, Integer | None, Integer]:
    """Find run, direction (None if the rows are not in order of angle) and cycle of each row.

    A run, direction or cycle that the file states in a column takes precedence over one derived
    from the motion. With ``split``, a reversal divides a stated run, too.
    """
    given = rows.whole.get("run")
    label = np.zeros(angle.size, dtype=np.int64) if given is None else given
    begins = np.diff(label, prepend=label[:1]) != 0
    if rows.time_s is not None:
        back = np.flatnonzero((np.diff(rows.time_s, prepend=rows.time_s[:1]) < 0.0) & ~begins)
        if back.size:
            choices.note(
                f"{rows.name}: time steps back {back.size} times, first at row "
                f"{rows.line(int(back[0]))}: a new run begins there"
            )
        begins[back] = True
    stretches = run_spans(np.cumsum(begins))
    run = np.zeros(angle.size, dtype=np.int64)
    direction = np.zeros(angle.size, dtype=np.int64)
    cycle = np.zeros(angle.size, dtype=np.int64)
    moved = True
    number = 0
    for start, end in stretches:
        found = passes(angle[start:end])
        moved = moved and bool(found)
        cycle[start:end] = cycles(angle[start:end], found)
        pieces = found or [Pass(0, end - start, 0)]
        for piece in pieces:
            here = slice(start + piece.start, start + piece.end)
            direction[here] = piece.direction
            run[here] = number
            number += int(split or given is None)
        number += int(not split and given is not None)
    if given is None and moved and number > 1:
        choices.note(f"{rows.name}: {number} runs, from the reversals of the motion")
    elif given is not None and split and number > len(stretches):
        choices.note(f"{rows.name}: runs with a reversal are divided: {number} runs")
    if not moved:
        choices.note(
            f"{rows.name}: the rows are not in order of angle: no directions or cycles are assigned"
        )
    own_direction = rows.whole.get("direction")
    if own_direction is not None:
        return run, own_direction, rows.whole.get("cycle", cycle)
    return run, direction if moved else None, rows.whole.get("cycle", cycle)


def _capture(files: list[FileRows], table: Table, choices: Choices) -> Capture:
    counts_per_rev, places_deg = table.counts_per_rev, table.places_deg
    assert counts_per_rev is not None
    assert places_deg is not None
    parts: dict[str, list[Any]] = {}
    first_run = 0
    for rows in files:
        assert rows.time_s is not None
        run, _, _ = _labelled(rows, rows.unwrapped("head1", choices), choices, split=True)
        columns: dict[str, Any] = {"run": run + first_run, "time_s": rows.time_s}
        first_run = int(columns["run"].max()) + 1
        wrapped = 0
        heads = [name for name in HEADS if name in rows.angles]
        for name in heads:
            counts = rows.counts(name, counts_per_rev)
            counts, wraps = unwrapped_counts(counts, run, rows.time_s, counts_per_rev)
            columns[f"{name}_counts"] = counts
            wrapped += wraps
            if wraps:
                choices.note(
                    f"{rows.name}: {name} restarts at {counts_per_rev} counts {wraps} times; "
                    "the counts are continued past each turn"
                )
        for name, place_deg in zip(heads[1:], places_deg[1:], strict=False):
            if wrapped:
                columns[f"{name}_counts"] = same_turn(
                    columns["head1_counts"],
                    columns[f"{name}_counts"],
                    run,
                    counts_per_rev,
                    place_deg,
                )
        columns |= rows.further()
        for name, values in columns.items():
            parts.setdefault(name, []).append(values)
    joined = _stacked(parts, len(files))
    conditions = {name[1:]: joined.pop(name) for name in list(joined) if name.startswith("=")}
    return Capture(**joined, conditions=conditions)


def _reference(files: list[FileRows], settings: Settings, choices: Choices) -> Reference:
    parts: dict[str, list[Any]] = {}
    first_run = first_cycle = 0
    compared = {
        number: error_of_readings(rows, settings.sign, choices)
        for number, rows in enumerate(files)
        if "head1" in rows.angles
    }
    compared = one_zero(files, compared, settings.zero, choices)
    for number, rows in enumerate(files):
        columns: dict[str, Any] = {}
        if number in compared:
            pair = compared.pop(number)
            target, error = pair.target, pair.error
            del pair
        else:
            target, error = rows.angles["target"], signed_error(rows, settings.sign, choices)
        run, direction, cycle = _labelled(
            rows, rows.unwrapped("target", choices, target), choices, split=False
        )
        if number:
            run, cycle = run + first_run, cycle + first_cycle
        columns["run"], columns["cycle"] = run, cycle
        first_run, first_cycle = int(columns["run"].max()) + 1, int(columns["cycle"].max()) + 1
        if rows.time_s is not None:
            columns["time_s"] = rows.time_s
        if direction is not None:
            columns["direction"] = direction
        columns["target_deg"] = target * 360.0
        columns["error_arcsec"] = error * ARCSEC_PER_TURN
        del target, error
        if "head1" in rows.angles and settings.table.counts_per_rev is not None:
            columns["head1_counts"] = rows.counts("head1", settings.table.counts_per_rev)
        columns |= rows.further()
        for name, values in columns.items():
            parts.setdefault(name, []).append(values)
    joined = _stacked(parts, len(files))
    conditions = {name[1:]: joined.pop(name) for name in list(joined) if name.startswith("=")}
    instrument = settings.instrument or next((f.instrument for f in files if f.instrument), None)
    return Reference(
        **joined,
        instrument=instrument,
        faces=settings.table.faces,
        standard_uncertainty_arcsec=settings.standard_uncertainty_arcsec,
        conditions=conditions,
    )


def _stacked(parts: dict[str, list[Any]], files: int) -> dict[str, Any]:
    lacking = [name.lstrip("=") for name, values in parts.items() if len(values) != files]
    if lacking:
        raise ValueError(f"some files lack {', '.join(lacking)}: import those files separately")
    # The function concatenates one column at a time, and returns a single file without a copy,
    # because a file may have 10⁶ rows.
    found = {}
    for name in list(parts):
        values = parts.pop(name)
        found[name] = values[0] if files == 1 else np.concatenate(values)
    return found


__all__ = ["NONE", "Imported", "Settings", "import_recordings"]
