"""Makes a measurement set from the named columns of capture and reference run."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from arctrue.api.frame import SET_COLUMNS, Found, Frame, columns_of
from arctrue.api.keywords import keys_of
from arctrue.base.runs import run_spans
from arctrue.base.similar import did_you_mean
from arctrue.importing.motion import passes
from arctrue.measurement import Capture, MeasurementError, MeasurementSet, Reference
from arctrue.measurement.date import moment
from arctrue.measurement.description import Keys
from arctrue.measurement.error_sign import of_opposite_sign
from arctrue.measurement.reader import count_on_past_the_turn, require_heads
from arctrue.measurement.uncertainty import of_zero
from arctrue.measurement.wraps import without_wraps

_KINDS_OF_DATES: Mapping[str, str] = {
    "utc": "dates without a time zone",
    "zone": "dates with a time zone",
    "duration": "durations",
}


def set_of_frames(
    frames: list[Frame],
    columns: Mapping[str, str],
    units: Mapping[str, Any],
    metadata: Mapping[str, Any],
) -> MeasurementSet:
    """Return the set with the columns of ``frames``, at most one frame per channel.

    ``columns``: the column of each quantity; ``units``: the unit of each quantity or column;
    ``metadata``: keywords of :class:`~arctrue.api.keywords.Metadata`. Raises TypeError for an
    unknown name, MeasurementError for a missing column or a wrong value.
    """
    if not frames:
        raise TypeError("expected a capture, a reference or both")
    keys = keys_of(metadata)
    for name in (*columns, *units):
        _require_name(name, frames, columns)
    found = {
        frame.name: columns_of(
            frame, _of_frame(columns, frame, frames), units, keys.table.counts_per_rev
        )
        for frame in frames
    }
    for name, part in found.items():
        if not all(column.size for column in part.columns.values()):
            raise MeasurementError("empty", Path(name), "has no rows; leave this table out")
    _one_clock(found)
    warnings: list[str] = [text for part in found.values() for text in part.warnings]
    capture = _capture(found["capture"], keys, warnings) if "capture" in found else None
    reference = _reference(found["reference"], keys, warnings) if "reference" in found else None
    for name, rows in (("capture", capture), ("reference", reference)):
        warnings += [] if rows is None else of_zero(rows, name, 0)
    if reference is not None:
        warnings += of_opposite_sign(reference, keys.table, "reference")
    return MeasurementSet(
        table=keys.table,
        capture=capture,
        reference=reference,
        title=keys.title,
        date=moment(keys.date) if keys.date else None,
        warnings=tuple(warnings),
    )


def _require_name(name: str, frames: list[Frame], columns: Mapping[str, str]) -> None:
    """Raise TypeError if ``name`` is neither a quantity nor a column of one of the frames."""
    known = {one for frame in frames for pair in SET_COLUMNS[frame.name].items() for one in pair}
    there = {column for frame in frames for column in frame.columns}
    if name not in known | there:
        raise TypeError(
            f"{name} is neither a quantity nor a column.{did_you_mean(name, known | there)} "
            f"Quantities: {', '.join(sorted(known - there))}"
        )


def _of_frame(columns: Mapping[str, str], frame: Frame, frames: list[Frame]) -> dict[str, str]:
    """Return the entries for this frame: each entry whose column is in this frame or in no other
    frame."""
    if len(frames) == 1:
        return dict(columns)
    others = [other for other in frames if other is not frame]
    return {
        name: column
        for name, column in columns.items()
        if column in frame.columns or not any(column in other.columns for other in others)
    }


def _one_clock(found: Mapping[str, Found]) -> None:
    """Convert dates to seconds since the earliest date in any of the tables."""
    dated = [part for part in found.values() if part.time_ns is not None and part.time_ns.size]
    if not dated:
        return
    kinds = {part.dates: name for name, part in found.items() if part.dates is not None}
    if len(kinds) > 1:
        one, other = (f"{name} has {_KINDS_OF_DATES[kind]}" for kind, name in kinds.items())
        raise MeasurementError(
            "time",
            Path(next(iter(found))),
            f"{one}, {other}: expected the same in both tables, because a date without a time "
            "zone may be local time",
            column="time_s",
        )
    first = min(int(part.time_ns.min()) for part in dated if part.time_ns is not None)
    for part in dated:
        assert part.time_ns is not None
        part.columns["time_s"] = (part.time_ns - first) * 1e-9


def _capture(found: Found, keys: Keys, warnings: list[str]) -> Capture:
    columns: dict[str, Any] = found.columns
    place = Path("capture")
    require_heads(keys.table, place, columns, Path("keywords"))
    assert keys.table.counts_per_rev is not None
    if "run" not in columns:
        turns = columns["head1_counts"] / keys.table.counts_per_rev
        columns["run"] = np.zeros(turns.size, dtype=np.int64)
        step = turns - np.concatenate(([turns[0]], turns[:-1])) if turns.size else turns
        unwrapped = np.cumsum(step - np.round(step)) if turns.size else turns
        for number, part in enumerate(passes(unwrapped)):
            columns["run"][part.start : part.end] = number
    _in_order(place, columns)
    count_on_past_the_turn(keys.table, place, columns, warnings)
    _require_mask(place, columns)
    return Capture(
        **columns,
        conditions=found.conditions,
        clock_hz=None if keys.capture is None else keys.capture.clock_hz,
    )


def _reference(found: Found, keys: Keys, warnings: list[str]) -> Reference:
    columns: dict[str, Any] = found.columns
    place = Path("reference")
    columns["error_arcsec"], wrapped = without_wraps(
        np.asarray(columns["error_arcsec"], dtype=np.float64)
    )
    if wrapped.size:
        warnings.append(
            f"reference, row {wrapped[0]}: the error differs by whole turns from the other rows, "
            f"as in {wrapped.size} rows in all; these turns are subtracted"
        )
    if "time_s" in columns:
        _in_order(place, columns)
    direction = columns.get("direction")
    if direction is not None and (wrong := np.flatnonzero(np.abs(direction) != 1)).size:
        raise MeasurementError(
            "value",
            place,
            f"row {wrong[0]}: expected +1 (reached upwards) or -1, found {direction[wrong[0]]}",
            column="direction",
        )
    _require_mask(place, columns)
    of_reference = keys.reference
    assert of_reference is not None
    return Reference(
        **columns,
        conditions=found.conditions,
        instrument=of_reference.instrument,
        faces=of_reference.faces,
        standard_uncertainty_arcsec=of_reference.standard_uncertainty_arcsec,
        clock_offset_s=of_reference.clock_offset_s,
    )


def _in_order(place: Path, columns: Mapping[str, NDArray[Any]]) -> None:
    """Raise MeasurementError if the rows of a run are not together, or if time runs backwards in a
    run."""
    time_s = columns["time_s"]
    run = columns.get("run", np.zeros(time_s.size, dtype=np.int64))
    spans = run_spans(run)
    names = [int(run[start]) for start, _ in spans]
    for number, (start, end) in enumerate(spans):
        if names[number] in names[:number]:
            raise MeasurementError(
                "order",
                place,
                f"row {start}: run {names[number]} continues here after another run; sort the "
                "rows by run and time, or give each stretch its own number",
                column="run",
            )
        back = np.flatnonzero(np.diff(time_s[start:end]) < 0.0)
        if back.size:
            row = start + int(back[0]) + 1
            raise MeasurementError(
                "time",
                place,
                f"row {row}: time runs backwards, from {time_s[row - 1]:g} to {time_s[row]:g} s; "
                "sort the rows, or number the runs in a column run",
                column="time_s",
            )


def _require_mask(place: Path, columns: dict[str, Any]) -> None:
    """Convert ``mask`` to Boolean values.

    Raises MeasurementError for a mask other than 0 and 1, and for a negative u.
    """
    mask, u_arcsec = columns.get("mask"), columns.get("u_arcsec")
    if mask is not None:
        wrong = np.flatnonzero((mask != 0) & (mask != 1))
        if wrong.size:
            raise MeasurementError(
                "value",
                place,
                f"row {wrong[0]}: expected 0 or 1 (do not use the row), found {mask[wrong[0]]}",
                column="mask",
            )
        columns["mask"] = mask == 1
    if u_arcsec is not None and (negative := np.flatnonzero(u_arcsec < 0.0)).size:
        raise MeasurementError(
            "value",
            place,
            f"row {negative[0]}: expected 0 or more, found {u_arcsec[negative[0]]:g}",
            column="u_arcsec",
        )
