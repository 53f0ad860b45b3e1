"""Reads samples of LinuxCNC's HAL as ``halsampler`` prints them.

Each line is a sample: the values of the pins in the order of the sampler's configuration, separated
by spaces. The number of the sample precedes them if ``halsampler`` was started with -t; ``overrun``
marks lost samples.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from arctrue.importing.choices import Ambiguous, Choices, checked_period
from arctrue.importing.file_content import FileContent, Known
from arctrue.importing.reader import ReadSettings
from arctrue.importing.readers.unpacked_size import refuse_many_fields
from arctrue.measurement import MeasurementError


def recognises(path: Path, head: bytes) -> bool:
    """Tell whether one of the first lines is ``overrun``; files of halsampler without this word
    need --format linuxcnc."""
    return any(line.strip() == b"overrun" for line in head.splitlines())


def read(path: Path, settings: ReadSettings, choices: Choices) -> FileContent:
    """Return the columns ``1``, ``2`` … and ``time_s``, the thread's period times the number of
    samples since the first row.

    A file with an overrun and without sample numbers is refused, because the number of lost samples
    is unknown. The user is asked for a period that is not stated. Raises MeasurementError, which
    names the row of a wrong line, ValueError for an answer that is no period, and AmbiguousError if
    nobody answers.
    """
    rows: list[list[float]] = []
    places: list[int] = []
    overruns: list[int] = []
    with path.open(encoding="utf-8", errors="replace") as file:
        for number, text in enumerate(file, start=1):
            words = text.split()
            if not words:
                continue
            if words == ["overrun"]:
                overruns.append(number)
                continue
            if rows and len(words) != len(rows[0]):
                raise MeasurementError(
                    "format", path, f"expected {len(rows[0])} pins, found {len(words)}", row=number
                )
            rows.append([_number(path, number, place, word) for place, word in enumerate(words)])
            refuse_many_fields(path, len(rows) * (1 + len(words)))
            places.append(number)
    if not rows:
        raise MeasurementError("empty", path, "holds no samples")
    values = np.array(rows)
    columns = {str(place + 1): values[:, place] for place in range(values.shape[1])}
    steps = np.diff(values[:, 0])
    tagged = bool((values[:, 0] % 1.0 == 0.0).all() and (steps >= 1.0).all() and steps.size)
    if overruns and not tagged:
        raise MeasurementError(
            "format",
            path,
            "samples were lost here, and without sample numbers their number is unknown: "
            "record with halsampler -t",
            row=overruns[0],
        )
    period = settings.period_s
    if period is None:
        period = checked_period(
            choices.ask(
                Ambiguous(
                    "--period",
                    f"{path}: how many seconds are between two samples (the thread's period)?",
                    ["0.001"],
                    free_text=True,
                )
            )
        )
    sample = values[:, 0] - values[0, 0] if tagged else np.arange(len(rows), dtype=np.float64)
    columns["time_s"] = sample * period
    notes = [f"{path.name}: {len(rows)} samples of LinuxCNC, {period:g} s apart"]
    if tagged:
        lost = int((steps - 1.0).sum())
        notes.append(f"{path.name}: column 1 is the number of the sample; {lost} samples are lost")
    return FileContent(
        path,
        "linuxcnc",
        columns,
        np.array(places),
        known={"time": Known("time_s", "s")},
        notes=tuple(notes),
    )


def _number(path: Path, row: int, place: int, word: str) -> float:
    try:
        return float(word)
    except ValueError:
        raise MeasurementError(
            "value", path, f"expected a number, found {word!r}", row=row, column=str(place + 1)
        ) from None
