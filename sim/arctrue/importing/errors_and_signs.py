"""Computes the error of indication of each row, the reading minus the true angle."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from arctrue.importing.choices import Ambiguous, Choices
from arctrue.importing.file_rows import FileRows

Float = NDArray[np.float64]

SIGNS = ("reading-true", "true-reading")
FAR_ZERO_TURNS = 0.5 / 360.0
"""Largest mean error, turns, that counts as an error of the table; a larger mean shows that reading
and reference have different zeros."""
FARTHEST_FROM_ONE_ZERO_TURNS = 2.0 / 360.0
"""Largest distance, in turns, of a file's mean error from the mean of all files; above it, one
shift of all files is refused. Reversal errors of tables and drifts between two files are
smaller."""
LONGEST_STEP_TURNS = 0.25
STANDSTILL_SHARE = 1e-3
"""Largest range of a column that stands still (with noise), as a share of the range of the column
that moves."""
SAME_MOTION = 0.1
"""Largest relative difference between the motions of reading and reference; a larger difference
means a wrong unit."""


def signed_error(rows: FileRows, sign: str, choices: Choices) -> Float:
    """Return the file's error column in turns (n,) as reading minus true angle; ask the user for
    the sign if ``sign`` is empty. Raises AmbiguousError if nobody answers."""
    if not sign:
        sign = choices.ask(
            Ambiguous(
                "--sign",
                f"{rows.name}: the error may be the reading minus the true angle, or the true "
                "angle minus the reading (ISO 230-2).",
                SIGNS,
            )
        )
    choices.note(f"{rows.name}: the error column is {sign}" + _turned(sign))
    return rows.angles["error"] * (1.0 if sign == SIGNS[0] else -1.0)


def _turned(sign: str) -> str:
    return "" if sign == SIGNS[0] else "; its sign is changed for the set"


@dataclass(frozen=True)
class Compared:
    """Reference angle and error of one file, both in turns (n,).

    ``mean``: circular mean of head1 − target; None if a column of the file gives the error.
    """

    target: Float
    error: Float
    mean: float | None


def error_of_readings(rows: FileRows, sign: str, choices: Choices) -> Compared:
    """Compute the true angle and the error of each row from reading and reference.

    If the reference counts in the opposite direction, the function changes the reference's sign and
    adds a note. The sign of an error column follows from reading and reference. Raises ValueError
    if reading and reference move by different amounts (a wrong unit or column), or if the error
    column or the stated sign contradicts them.
    """
    reading, target = rows.angles["head1"], rows.angles["target"]
    way = _way(rows, reading, target)
    if way < 0:
        target = -target
        choices.note(
            f"{rows.name}: target counts in the opposite direction to head1; its sign is changed"
        )
    mean = _circular_mean(reading - target)
    error = mean + _within_half(reading - target - mean)
    if "error" in rows.angles:
        given = rows.angles["error"]
        error_sign = _sign_of(rows, given, error)
        choices.note(
            f"{rows.name}: the error column is {SIGNS[error_sign < 0]}, as head1 and target show"
            + _turned(SIGNS[error_sign < 0])
        )
        if sign and sign != SIGNS[error_sign < 0]:
            raise ValueError(
                f"{rows.name}: --sign {sign}, but head1 and target show {SIGNS[error_sign < 0]}"
            )
        return Compared(target, given * error_sign, None)
    choices.note(f"{rows.name}: error = head1 − target")
    return Compared(target, error, mean)


def one_zero(
    files: Sequence[FileRows], compared: Mapping[int, Compared], zero: str, choices: Choices
) -> dict[int, Compared]:
    """Shift the references of all files to the zero of the readings, if the zeros differ.

    ``files`` and ``compared`` are indexed by the number of the file. The shift is made only if the
    user wants it. All files get the same shift: a difference between files, such as the reversal
    error between an upward and a downward run, is an error of the table.

    If the zeros differ and ``zero`` is neither ``shift`` nor ``keep``, the user is asked. Raises
    AmbiguousError if nobody answers, and ValueError if the zeros of the files differ too much for
    one shift.
    """
    means = {number: item.mean for number, item in compared.items() if item.mean is not None}
    if not means:
        return dict(compared)
    sizes = {number: compared[number].target.size for number in means}
    # The means of all files are shifted by whole turns towards the first file's mean, because means
    # near half a turn may have either sign.
    first = next(iter(means.values()))
    near = {number: mean - round(mean - first) for number, mean in means.items()}
    together = sum(near[number] * sizes[number] for number in near) / sum(sizes.values())
    together -= round(together)
    if max(abs(mean) for mean in (*means.values(), together)) <= FAR_ZERO_TURNS:
        return dict(compared)
    listed = ", ".join(f"{mean * 360.0:.4f}° in {files[n].name}" for n, mean in means.items())
    if not zero:
        zero = choices.ask(
            Ambiguous(
                "--zero",
                f"The mean of head1 − target is not zero ({listed}): shift the reference's zero to "
                "that of head1, by the same angle in all rows, or keep the difference as an error?",
                ["shift", "keep"],
            )
        )
    if zero != "shift":
        return dict(compared)
    far = [
        n
        for n in means
        if abs(math.remainder(near[n] - together, 1.0)) > FARTHEST_FROM_ONE_ZERO_TURNS
    ]
    if far:
        raise ValueError(
            f"--zero shift: the files have different zeros: head1 − target is {listed} on average. "
            "One shift applies to files of one measurement: import the files one by one, then "
            "use arctrue join"
        )
    choices.note(
        f"{together * 360.0:.6f}° are added to target in all rows: its zero is that of head1"
    )
    shifted = dict(compared)
    for number in means:
        item = compared[number]
        error = item.error - together
        error = error - np.round(np.mean(error))
        shifted[number] = Compared(item.target + together, error, 0.0)
    return shifted


def _way(rows: FileRows, reading: Float, target: Float) -> int:
    """Return +1 if reading and reference move in the same direction, −1 if they move in opposite
    directions. Raises ValueError if one of them stands still or they move by different amounts."""
    _refuse_standstill(rows, reading, target)
    step = _within_half(np.diff(target))
    read = _within_half(np.diff(reading))
    usable = (np.abs(step) < LONGEST_STEP_TURNS) & (np.abs(read) < LONGEST_STEP_TURNS)
    # Each step is weighted by its square, so that large steps determine the sign, and noise at a
    # standstill does not.
    power = float(step[usable] @ step[usable])
    if int(usable.sum()) >= 2 and power > 0.0:
        slope = float(step[usable] @ read[usable]) / power
    else:
        same = abs(np.mean(np.exp(2j * np.pi * (reading - target))))
        other = abs(np.mean(np.exp(2j * np.pi * (reading + target))))
        slope = 1.0 if same > 0.9 >= other else -1.0 if other > 0.9 >= same else 0.0
    if abs(abs(slope) - 1.0) > SAME_MOTION:
        units = ", ".join(f"{name} in {rows.sources[name].unit}" for name in ("head1", "target")
                          if name in rows.sources)  # fmt: skip
        raise ValueError(
            f"{rows.name}: head1 moves {slope:.4g} times as far as target; expected the same. "
            f"Check the units ({units}) and --counts-per-rev"
        )
    return 1 if slope > 0.0 else -1


def _refuse_standstill(rows: FileRows, reading: Float, target: Float) -> None:
    """Raise ValueError if the reading or the reference stands still, or both do."""
    ways = {"head1": _range_turns(reading), "target": _range_turns(target)}
    for still, moving in (("target", "head1"), ("head1", "target")):
        if ways[still] <= STANDSTILL_SHARE * ways[moving]:
            where = rows.angles[still][0] * 360.0
            column = rows.sources[still].column if still in rows.sources else still
            more = (
                "A reference angle changes when the table turns: name a column that changes"
                if still == "target"
                else "Is the encoder connected, and is this its column? Name the right one"
            )
            if ways[moving] == 0.0:
                raise ValueError(
                    f"{rows.name}: neither target nor head1 moves; {still} is {where:.6g}° in "
                    "every row. An error curve needs a run over the angle"
                )
            raise ValueError(
                f"{rows.name}: {still} (column {column}) stands still at {where:.6g}° while "
                f"{moving} moves over {ways[moving] * 360.0:.6g}°. {more} "
                f"(--column {still}=…)"
            )


def _range_turns(angle: Float) -> float:
    """Return the range of an angle in turns; the angle may restart at the end of a turn."""
    step = _within_half(np.diff(angle))
    return float(np.ptp(np.cumsum(step))) if step.size > 1 else float(np.abs(step).sum())


def _sign_of(rows: FileRows, given: Float, error: Float) -> int:
    """Return the sign, +1 or −1, for which ``error`` equals the sign times the error column
    ``given`` plus a constant."""
    rest = {
        sign: float(
            np.std(_within_half(error - sign * given - _circular_mean(error - sign * given)))
        )
        for sign in (1, -1)
    }
    best = 1 if rest[1] <= rest[-1] else -1
    if rest[best] > 0.5 * rest[-best]:
        raise ValueError(
            f"{rows.name}: the error column is neither head1 − target nor target − head1; leave "
            "out the wrong column (--column NAME=none)"
        )
    return best


def _within_half(turns: Float) -> Float:
    return turns - np.round(turns)


def _circular_mean(turns: Float) -> float:
    return float(np.angle(np.mean(np.exp(2j * np.pi * turns)))) / (2.0 * np.pi)
