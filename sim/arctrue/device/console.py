"""The console of the firmware: commands, telemetry and dumps over a serial port."""

from __future__ import annotations

import json
import math
import os
import time
from dataclasses import dataclass
from typing import Any

import numpy as np
import serial
from numpy.typing import NDArray

from arctrue.measurement import Capture, MeasurementSet, Table

BAUD = 115_200
_ROW_FIELDS = 4
_HEADER = "run,time_s,head1_counts,head2_counts"


class ConsoleError(Exception):
    """The device does not answer, or not as expected; the message is for people."""


@dataclass(frozen=True, slots=True)
class Turn:
    """One line of telemetry; ``fields`` has all of it."""

    fields: dict[str, Any]

    @property
    def result(self) -> str:
        """``applied``, ``kept`` or ``refused``."""
        return str(self.fields["result"])


class Console:
    """One device. Lines are kept apart: answers, telemetry (``{``) and dumps."""

    def __init__(self, port: str, *, timeout_s: float = 1.0) -> None:
        """Open ``port``: a device or a URL of pyserial. Raises ConsoleError."""
        try:
            self._serial = serial.serial_for_url(port, BAUD, timeout=timeout_s)
        except (serial.SerialException, ValueError) as error:
            # pyserial says the port's name and the system's error twice.
            number = getattr(error, "errno", None)
            why = os.strerror(number) if number else str(error)
            raise ConsoleError(
                f"{port}: cannot be opened: {why}; is the device plugged in, "
                "and may you use the port?"
            ) from error
        self.port = port
        self._turns: list[Turn] = []

    def close(self) -> None:
        """Close the port."""
        self._serial.close()

    def command(self, line: str, seconds: float = 5.0) -> list[str]:
        """The lines of the answer without the closing ``ok``.

        Raises ConsoleError for an answer that says error, or none within ``seconds``.
        """
        return self._answer(line, seconds)[:-1]

    def confirmed(self, line: str, seconds: float = 5.0) -> str:
        """What follows the closing ``ok``; raises as :meth:`command`."""
        return self._answer(line, seconds)[-1].removeprefix("ok").removeprefix(",").strip()

    def _answer(self, line: str, seconds: float) -> list[str]:
        self._write(line)
        answer: list[str] = []
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            text = self._line()
            if text is None:
                continue
            if text.startswith("error"):
                raise ConsoleError(f"{self.port}: {line}: the device says {text}")
            answer.append(text)
            if text == "ok" or text.startswith("ok,"):
                return answer
        raise ConsoleError(
            f"{self.port}: no answer to {line!r} within {seconds:g} s; is it the console of the "
            f"device, at {BAUD} baud?"
        )

    def turn(self, seconds: float) -> Turn | None:
        """The next line of telemetry, None where there is none within ``seconds``."""
        end = time.monotonic() + seconds
        while not self._turns and time.monotonic() < end:
            self._line()
        return self._turns.pop(0) if self._turns else None

    def dump(self, seconds: float) -> MeasurementSet:
        """The capture of the next turn. Raises ConsoleError where it is not whole."""
        self.command("dump")
        head = self._wait_for("dump ", seconds)
        fields = dict(part.split("=", 1) for part in head.split()[1:])
        if self._wait_for("run,", seconds) != _HEADER:
            raise ConsoleError(f"{self.port}: the dump has other columns than {_HEADER}")
        rows: list[str] = []
        while (text := self._wait_for("", seconds)) != "end of dump":
            rows.append(text)
        try:
            return _measurement(fields, rows, self.port)
        except (KeyError, ValueError) as error:
            raise ConsoleError(f"{self.port}: the dump cannot be read: {error}") from error

    def _write(self, line: str) -> None:
        try:
            self._serial.write(line.encode("ascii") + b"\r")
        except serial.SerialException as error:
            raise ConsoleError(f"{self.port}: {error}") from error

    def _line(self) -> str | None:
        """The next line that is no telemetry; that is put aside. None: nothing came in time."""
        try:
            data: bytes = self._serial.read_until(b"\n")
        except serial.SerialException as error:
            raise ConsoleError(f"{self.port}: {error}; was the cable pulled?") from error
        if not data.endswith(b"\n"):
            return None
        text = data.decode("ascii", "replace").strip()
        if not text.startswith("{"):
            return text
        try:
            self._turns.append(Turn(json.loads(text)))
        except json.JSONDecodeError:
            # A line that lost characters on the way is one turn less, no more.
            return None
        return None

    def _wait_for(self, start: str, seconds: float) -> str:
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            text = self._line()
            if text is not None and text.startswith(start):
                return text
        raise ConsoleError(f"{self.port}: nothing came within {seconds:g} s; does the table turn?")


def _temperature(fields: dict[str, str], rows: int) -> NDArray[np.float64] | None:
    """Of the die, the same for every row; None where the device has told none."""
    if "temperature_c" not in fields:
        return None
    celsius = float(fields["temperature_c"])
    if not math.isfinite(celsius):
        raise ValueError("temperature_c")
    return np.full(rows, celsius)


def _measurement(fields: dict[str, str], rows: list[str], port: str) -> MeasurementSet:
    values = [row.split(",") for row in rows]
    bad = [i for i, row in enumerate(values) if len(row) != _ROW_FIELDS]
    if bad or len(rows) != int(fields["samples"]):
        where = f"row {bad[0] + 1} is {rows[bad[0]]!r}" if bad else f"{len(rows)} rows came"
        raise ConsoleError(
            f"{port}: expected {fields['samples']} whole rows, but {where}: characters were lost"
        )
    capture = Capture(
        run=np.array([int(row[0]) for row in values], dtype=np.int64),
        time_s=np.array([float(row[1]) for row in values]),
        head1_counts=np.array([int(row[2]) for row in values], dtype=np.int64),
        head2_counts=np.array([int(row[3]) for row in values], dtype=np.int64),
        clock_hz=float(fields["clock_hz"]),
        temperature_c=_temperature(fields, len(rows)),
    )
    separation = float(fields["separation_deg"])
    if not math.isfinite(separation):
        raise ValueError("separation_deg")
    title = f"capture {fields['sequence']} of {port}"
    if capture.temperature_c is not None:
        title += ", temperature of the die"
    table = Table(counts_per_rev=int(fields["counts_per_rev"]), head_separation_deg=separation)
    return MeasurementSet(table, capture, title=title)
