"""The console of the firmware: commands, telemetry and dumps over a serial port."""

from __future__ import annotations

import errno
import json
import logging
import os
import time
from dataclasses import dataclass
from typing import Any

import serial
from msgspec import Struct

from arctrue.base.typed_content import typed
from arctrue.device.dump import DumpHead, read_head, read_row
from arctrue.device.exclusive_port import keep_others_out, let_others_in, other_users
from arctrue.measurement import MeasurementSet

BAUD = 115_200
ATTEMPTS = 3
"""Of what was spoiled on the way."""
SILENCE_S = 5.0
"""A dump that is silent for so long has ended, and its end was spoiled."""
LONGEST_LINE = 65_536
"""Characters kept of a line without an end; the longest line of the firmware has 2,128."""
LATE_S = 10.0
"""An answer later than this does not come any more."""

_LOG = logging.getLogger(__name__)


class ConsoleError(Exception):
    """The device does not answer, or not as expected; the message is for people."""


class _Told(Struct):
    """What every line of telemetry has, and what is shown of one; there may be more."""

    turn: int
    result: str
    reason: str
    alarms: list[str] = []
    separation_deg: float | None = None
    noise_arcsec: float | None = None
    active_arcsec: float | None = None
    temperature_c: float | None = None
    harmonics: list[tuple[int, float, float, float, int]] = []
    """Order, amplitude, phase, standard uncertainty, whether it was applied."""


@dataclass(frozen=True, slots=True)
class TelemetryLine:
    """One line of telemetry; ``fields`` has all of it."""

    fields: dict[str, Any]

    @property
    def result(self) -> str:
        """``applied``, ``kept`` or ``refused``; ``alarm``: one between turns, and no turn."""
        return str(self.fields["result"])


class Console:
    """One device. Lines are kept apart: answers, telemetry (``{``) and dumps."""

    def __init__(self, port: str, *, timeout_s: float = 1.0) -> None:
        """Open ``port`` for this program alone: a device or a URL of pyserial.

        Raises ConsoleError, which names the program that has the port where that can be known.
        """
        try:
            self._serial = serial.serial_for_url(port, BAUD, timeout=timeout_s, exclusive=True)
        except (serial.SerialException, ValueError) as error:
            raise _not_opened(port, error) from error
        if users := other_users(port):
            self._serial.close()
            raise _in_use(port, users)
        keep_others_out(self._serial)
        self.port = port
        self._turns: list[TelemetryLine] = []
        self._in_step = False
        self._markers = 0
        self._begun = b""

    def close(self) -> None:
        """Close the port."""
        if self._serial.is_open:
            let_others_in(self._serial)
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
        if not self._in_step:
            self._drop_late_answers(line, seconds)
        self._write(line)
        answer: list[str] = []
        self._in_step = False
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            text = self._line()
            if text is None:
                continue
            self._in_step = text.startswith("error") or text == "ok" or text.startswith("ok,")
            if text.startswith("error"):
                raise ConsoleError(f"{self.port}: {line}: the device says {text}")
            answer.append(text)
            if self._in_step:
                return answer
        raise self._no_answer(line, seconds)

    def _drop_late_answers(self, line: str, seconds: float) -> None:
        """Read up to the answer to a marker: what comes before it was meant for somebody else.

        That is an earlier line, whose answer was not waited for any longer, or another program's.
        The marker is no command, and the device repeats it.
        """
        self._markers += 1
        marker = f"marker{os.getpid()}.{self._markers}"
        # An end of line first: a part of a line may wait in the device.
        self._write(f"\r{marker}")
        late = 0
        end = time.monotonic() + max(seconds, LATE_S)
        while time.monotonic() < end:
            text = self._line()
            if text is not None and text.startswith("error") and text.endswith(f" {marker}"):
                if late:
                    _LOG.warning(
                        "%s: %d lines that nobody waits for any more are left out", self.port, late
                    )
                return
            late += bool(text)
        raise self._no_answer(line, max(seconds, LATE_S))

    def _no_answer(self, line: str, seconds: float) -> ConsoleError:
        return ConsoleError(
            f"{self.port}: no answer to {line!r} within {seconds:g} s; is it the console of the "
            f"device, at {BAUD} baud?"
        )

    def turn(self, seconds: float) -> TelemetryLine | None:
        """The next line of telemetry, None where there is none within ``seconds``."""
        end = time.monotonic() + seconds
        while not self._turns and time.monotonic() < end:
            self._line()
        return self._turns.pop(0) if self._turns else None

    def dump(self, seconds: float) -> MeasurementSet:
        """The capture of the next turn; rows that were spoiled on the way are asked for again.

        Raises ConsoleError where it cannot be made whole, or where its samples have no times.
        """
        for _ in range(ATTEMPTS):
            self.command("dump")
            head = read_head(self._wait_for(("dump ", "error"), seconds))
            rows: dict[int, tuple[int, ...]] = {}
            self._take_rows(rows, seconds)
            if head is not None and head.period_clocks == 0:
                raise ConsoleError(
                    f"{self.port}: the samples came at edges of sync_in, so that their times are "
                    "not known; say `sync capture 0` on the console for samples at equal times"
                )
            if head is not None:
                return self._completed(head, rows, seconds)
        raise ConsoleError(f"{self.port}: the head of the dump was spoiled {ATTEMPTS} times")

    def _completed(
        self, head: DumpHead, rows: dict[int, tuple[int, ...]], seconds: float
    ) -> MeasurementSet:
        for _ in range(ATTEMPTS):
            for first, number in head.missing(rows):
                self.command(f"dump rows {first} {number}")
                self._take_rows(rows, seconds)
        if head.missing(rows):
            lacking = head.samples - len(rows)
            raise ConsoleError(
                f"{self.port}: {lacking} of {head.samples} rows were spoiled {ATTEMPTS} times: "
                "is the cable good, the port free?"
            )
        return head.measurement(rows, self.port)

    def _take_rows(self, rows: dict[int, tuple[int, ...]], seconds: float) -> None:
        """Up to the end of the dump, or until nothing comes any more where that was spoiled."""
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            text = self._line()
            if text is None:
                continue
            # What the line carries counts, not whether the device is fast.
            end = time.monotonic() + min(seconds, SILENCE_S)
            if text == "end of dump":
                return
            row = read_row(text)
            if row is not None:
                rows[row[0]] = row[1:]

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
        # The device may stop in the middle of a line for longer than a read waits.
        self._begun += data
        if not data.endswith(b"\n"):
            self._begun = self._begun[-LONGEST_LINE:]
            return None
        data, self._begun = self._begun, b""
        text = data.decode("ascii", "replace").strip()
        if not text.startswith("{"):
            return text
        try:
            fields = json.loads(text)
            typed(fields, _Told)
            self._turns.append(TelemetryLine(fields))
        except ValueError:
            # A line that was spoiled on the way is one turn less, no more.
            return None
        return None

    def _wait_for(self, starts: tuple[str, ...], seconds: float) -> str:
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            text = self._line()
            if text is not None and text.startswith(starts):
                if text.startswith("error"):
                    raise ConsoleError(f"{self.port}: the device says {text}")
                return text
        raise ConsoleError(f"{self.port}: nothing came within {seconds:g} s; does the table turn?")


def _not_opened(port: str, error: Exception) -> ConsoleError:
    # pyserial says the port's name and the system's error twice; its lock has an error of its own.
    number = getattr(error, "errno", None)
    if number in (errno.EBUSY, errno.EAGAIN) or "exclusively lock" in str(error):
        return _in_use(port, other_users(port))
    why = os.strerror(number) if number else str(error)
    return ConsoleError(
        f"{port}: cannot be opened: {why}; is the device plugged in, and may you use the port?"
    )


def _in_use(port: str, users: list[str]) -> ConsoleError:
    who = " and ".join(users) or "another program, whose name the system does not tell you"
    return ConsoleError(f"{port}: is in use by {who}; end that first, two cannot share a port")
