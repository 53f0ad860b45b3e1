"""Makes a measurement set from the contents of files, asks the user, and records the decisions."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from arctrue.base.head_places import places_from_text
from arctrue.importing.choices import Ambiguous, Choices, checked_number
from arctrue.importing.clocks import ClockOffset
from arctrue.importing.columns import Mapped, map_columns, tell_unused, timed_error
from arctrue.importing.file_content import FileContent
from arctrue.importing.file_rows import FileRows, rows_of
from arctrue.importing.quantities import HEADS
from arctrue.importing.row_order import in_order
from arctrue.importing.set_of_rows import capture_of, reference_of
from arctrue.importing.settings import Settings
from arctrue.importing.two_logs import joined_logs
from arctrue.measurement import MeasurementSet, Table

LATE_START_S = 1e6
"""Latest first time (seconds) of a log whose times count from the log's start; later first times
count from an epoch."""
LEAST_COUNTS = 4
"""Smallest number of counts per turn, as in the measurement set: the edges of one line."""
SIDEREAL_DEG_S = 360.0 / 86164.0905
"""Speed of an axis that follows the stars: a turn in a sidereal day (IERS Conventions 2010, chapter
1: nominal mean rotation of the Earth)."""


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
        table = replace(table, counts_per_rev=_counts(choices.ask(asked)))
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
        references, clocks = joined_logs(encoders, lonely, references, settings, choices)
    heads = [f for f in files if {"head1", "head2"} <= set(f.angles) and f.time_s is not None]
    capture = None
    if heads:
        table = _with_places(table, _heads_of(heads), choices)
        capture = capture_of(heads, table, choices)
    settings = replace(settings, table=table)
    reference = reference_of(references, settings, choices) if references else None
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


def _counts(text: str) -> int:
    try:
        counts = int(text)
    except ValueError:
        counts = 0
    if counts < LEAST_COUNTS:
        raise ValueError(
            f"--counts-per-rev: expected a whole number from {LEAST_COUNTS}, found {text!r}"
        )
    return counts


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
            places = places_from_text(given)
            if len(places) != len(heads):
                raise ValueError(f"expected {len(heads)} places, found {len(places)}")
            return replace(table, head_places_deg=places)
        except ValueError as error:
            raise ValueError(f"--places: {error}") from None
    asked = Ambiguous(
        "--separation",
        "At how many degrees from head 1 is head 2, in the direction of increasing counts?",
        ["180", "90", "33"],
        free_text=True,
    )
    separation = checked_number(
        "--separation",
        choices.ask(asked),
        "degrees between -360 and 360",
        lambda degrees: abs(degrees) < 360.0,
    )
    return replace(table, head_separation_deg=separation)


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
    given: str | float | None = rate_deg_s
    if given is None:
        asked = Ambiguous(
            "--rate",
            f"{rows.name} has times and errors but no angle. How fast does the axis turn, in "
            f"degrees per second? A telescope that follows the stars: {SIDEREAL_DEG_S:.9f}.",
            [f"{SIDEREAL_DEG_S:.9f}"],
            free_text=True,
        )
        given = choices.ask(asked)
    rate = checked_number("--rate", given, "degrees per second other than 0", bool)
    choices.note(f"{rows.name}: the angle is {rate:.9g}°/s times the time (--rate)")
    return replace(rows, angles={**rows.angles, "target": rows.time_s * (rate / 360.0)})
