"""Controls the console of the firmware: commands, telemetry, and dumps (captures, row by row)."""

from __future__ import annotations

import logging
import os
import time

from arctrue.device.dump import DumpHead, read_head, read_row
from arctrue.device.lines import LineAssembler, TelemetryLine, is_telemetry, telemetry_of
from arctrue.device.port import BAUD, ConsoleError, SerialTransport, Transport
from arctrue.measurement import MeasurementSet

__all__ = ["Console", "ConsoleError", "TelemetryLine"]
ATTEMPTS = 3
"""Number of attempts to receive data that are damaged in transmission."""
SILENCE_S = 5.0
"""Silence in seconds after which a dump counts as ended, if its last line was damaged."""
LATE_S = 10.0
"""Longest delay of a late answer, seconds."""

_LOG = logging.getLogger(__name__)


class Console:
    """The console of one device; it divides the device's lines into answers, telemetry (``{``) and
    dumps."""

    def __init__(
        self, port: str, *, timeout_s: float = 1.0, transport: Transport | None = None
    ) -> None:
        """Open ``port``, a device or a URL of pyserial, for this program alone.

        With ``transport`` nothing is opened, and ``port`` only names the device in messages. Raises
        ConsoleError, which names the program that uses the port if the system reveals it.
        """
        self._transport = transport or SerialTransport(port, timeout_s)
        self.port = port
        self._turns: list[TelemetryLine] = []
        self._in_step = False
        self._markers = 0
        self._lines = LineAssembler()

    def close(self) -> None:
        """Close the port."""
        self._transport.close()

    def command(self, line: str, seconds: float = 5.0) -> list[str]:
        """Send a line and return the lines of the answer, without the final ``ok``.

        Raises ConsoleError if the answer is an error, or if none arrives within ``seconds``.
        """
        return self._answer(line, seconds)[:-1]

    def confirmed(self, line: str, seconds: float = 5.0) -> str:
        """Send a line and return the text after the final ``ok``. Raises the errors of
        :meth:`command`."""
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
        """Discard all lines before the answer to a marker, because they answer other requests.

        These are an earlier command whose answer came too late, or a command from another program.
        The marker is not a command; the device repeats it in its error message.
        """
        self._markers += 1
        marker = f"marker{os.getpid()}.{self._markers}"
        # The end of line comes first, because the device may have received a part of a line.
        self._write(f"\r{marker}")
        late = 0
        end = time.monotonic() + max(seconds, LATE_S)
        while time.monotonic() < end:
            text = self._line()
            if text is not None and text.startswith("error") and text.endswith(f" {marker}"):
                if late:
                    _LOG.warning(
                        "%s: %d late lines that no command waits for are dropped", self.port, late
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
        """Return the next line of telemetry; None if none arrives within ``seconds``. Raises
        ConsoleError."""
        end = time.monotonic() + seconds
        while not self._turns and time.monotonic() < end:
            self._line()
        return self._turns.pop(0) if self._turns else None

    def dump(self, seconds: float) -> MeasurementSet:
        """Return a capture of the next turn; request damaged rows again.

        Raises ConsoleError if no turn arrives, if the first line or rows are damaged in every
        attempt, or if the samples have no times.
        """
        for _ in range(ATTEMPTS):
            self.command("dump")
            head = read_head(self._wait_for(("dump ", "error"), seconds))
            rows: dict[int, tuple[int, ...]] = {}
            self._take_rows(rows, seconds)
            if head is not None and head.period_clocks == 0:
                raise ConsoleError(
                    f"{self.port}: the samples came at edges of sync_in, so that their times are "
                    "not known; enter `sync capture 0` on the console for samples at equal times"
                )
            if head is not None:
                return self._completed(head, rows, seconds)
        raise ConsoleError(f"{self.port}: the first line of the dump was damaged {ATTEMPTS} times")

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
                f"{self.port}: {lacking} of {head.samples} rows were damaged {ATTEMPTS} times: "
                "check the cable, and that no other program uses the port"
            )
        return head.measurement(rows, self.port)

    def _take_rows(self, rows: dict[int, tuple[int, ...]], seconds: float) -> None:
        """Receive rows until the last line of the dump, or until silence if that line was
        damaged."""
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            text = self._line()
            if text is None:
                continue
            # ``seconds`` limits the silence between two lines, not the duration of the whole dump.
            end = time.monotonic() + min(seconds, SILENCE_S)
            if text == "end of dump":
                return
            row = read_row(text)
            if row is not None:
                rows[row[0]] = row[1:]

    def _write(self, line: str) -> None:
        try:
            self._transport.write(line.encode("ascii") + b"\r")
        except OSError as error:
            raise ConsoleError(f"{self.port}: {error}") from error

    def _line(self) -> str | None:
        """Return the next line that is not telemetry, and store telemetry lines; None if no line
        arrives in time."""
        try:
            data = self._transport.read_until(b"\n")
        except OSError as error:
            raise ConsoleError(f"{self.port}: {error}; was the cable pulled?") from error
        # The read may return a part of a line, because the device may pause within a line.
        for text in self._lines.add(data):
            if not is_telemetry(text):
                return text
            turn = telemetry_of(text)
            # A line of telemetry that was damaged in transmission is dropped; only its turn is
            # missing.
            if turn is not None:
                self._turns.append(turn)
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
