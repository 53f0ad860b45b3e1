"""Joins two logs of one motion: one with a reading, the other with a reference."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from arctrue.importing.choices import Ambiguous, Choices, checked_number
from arctrue.importing.clocks import ClockOffset, UndeterminedOffsetError, clock_offset
from arctrue.importing.file_rows import FileRows
from arctrue.importing.settings import Settings

Float = NDArray[np.float64]


def joined_logs(
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
        return ClockOffset(_offset(settings.clock_offset_s), nan, nan, nan, nan)
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
        return ClockOffset(_offset(given), nan, nan, nan, nan)
    choices.note(
        f"clocks: {found.offset_s:+.6f} s are added to the reference's time, standard uncertainty "
        f"{found.u_s:.2g} s; the offsets of parts differ by at most {found.left_s:.2g} s, "
        f"the rates differ by {found.drift_ppm:.2g} ± {found.u_drift_ppm:.2g} ppm"
    )
    return found


def _offset(given: str | float) -> float:
    return checked_number("--clock-offset", given, "seconds")
