"""The error of each row with the sign of the set: reading less true angle."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from arctrue.importing.choices import Ambiguous, Choices
from arctrue.importing.file_rows import FileRows

Float = NDArray[np.float64]

SIGNS = ("reading-true", "true-reading")
FAR_ZERO_TURNS = 0.5 / 360.0
"""A mean error beyond this is a difference of zeros, no error of a table."""
LONGEST_STEP_TURNS = 0.25
SAME_MOTION = 0.1
"""Relative difference of the motions beyond which the units are wrong."""


def signed_error(rows: FileRows, sign: str, choices: Choices) -> Float:
    """The error column in turns (n,), as reading less true angle. Raises AmbiguousError."""
    for option, answer in choices.answers:
        if option == "--sign":
            sign = sign or answer
    if not sign:
        sign = choices.ask(
            Ambiguous(
                "--sign",
                f"{rows.name}: the error may be the reading less the true angle, or the true angle "
                "less the reading (ISO 230-2).",
                SIGNS,
            )
        )
    choices.note(f"{rows.name}: the error column is {sign}" + _turned(sign))
    return rows.angles["error"] * (1.0 if sign == SIGNS[0] else -1.0)


def _turned(sign: str) -> str:
    return "" if sign == SIGNS[0] else "; its sign is changed for the set"


def error_of_readings(
    rows: FileRows, sign: str, zero: str, choices: Choices
) -> tuple[Float, Float]:
    """The reference angle and the error in turns (n,), from reading and reference of each row.

    A reference that counts the other way is turned round, and said. An error column beside both
    tells its sign by itself. Raises ValueError where the two move differently (a wrong unit),
    AmbiguousError where their zeros differ and nobody says what that means.
    """
    reading, target = rows.angles["head1"], rows.angles["target"]
    way = _way(rows, reading, target)
    if way < 0:
        target = -target
        choices.note(f"{rows.name}: target counts the other way than head1; its sign is changed")
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
        return target, given * error_sign
    choices.note(f"{rows.name}: error = head1 − target")
    if abs(mean) > FAR_ZERO_TURNS:
        for option, answer in choices.answers:
            if option == "--zero":
                zero = zero or answer
        if not zero:
            zero = choices.ask(
                Ambiguous(
                    "--zero",
                    f"{rows.name}: head1 is {mean * 360.0:.4f}° from target on average: shift the "
                    "reference's zero to that of head1, or keep the difference as an error?",
                    ["shift", "keep"],
                )
            )
        if zero == "shift":
            target, error = target + mean, error - mean
            choices.note(
                f"{rows.name}: {mean * 360.0:.6f}° are added to target: its zero is head1's"
            )
    return target, error


def _way(rows: FileRows, reading: Float, target: Float) -> int:
    """+1 or −1: how the reading follows the reference."""
    step = _within_half(np.diff(target))
    read = _within_half(np.diff(reading))
    usable = (np.abs(step) < LONGEST_STEP_TURNS) & (np.abs(read) < LONGEST_STEP_TURNS)
    # Away from noise: only steps that are no standstill.
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
            f"{rows.name}: head1 moves {slope:.4g} times as far as target; they should move alike. "
            f"Look at the units ({units}) and at --counts-per-rev"
        )
    return 1 if slope > 0.0 else -1


def _sign_of(rows: FileRows, given: Float, error: Float) -> int:
    """+1 or −1: the sign with which the error column is head1 − target, but for a constant."""
    rest = {
        sign: float(
            np.std(_within_half(error - sign * given - _circular_mean(error - sign * given)))
        )
        for sign in (1, -1)
    }
    best = 1 if rest[1] <= rest[-1] else -1
    if rest[best] > 0.5 * rest[-best]:
        raise ValueError(
            f"{rows.name}: the error column is not the difference of head1 and target, with "
            "neither sign; leave out the column that is wrong (--column NAME=none)"
        )
    return best


def _within_half(turns: Float) -> Float:
    return turns - np.round(turns)


def _circular_mean(turns: Float) -> float:
    return float(np.angle(np.mean(np.exp(2j * np.pi * turns)))) / (2.0 * np.pi)
