"""Runs the daemon: its serial link, record and server share one event loop; threads make the
captures, another process the daily files."""

from __future__ import annotations

import asyncio
import contextlib
import os
import signal
import sqlite3
import time
from collections.abc import Callable, Sequence
from dataclasses import asdict
from typing import Any

from arctrue.device.announcement import Announcement, announce
from arctrue.device.daemon.captures import drop_oldest, take_capture
from arctrue.device.daemon.day_writer import DayWriter, DayWriterError
from arctrue.device.daemon.machine_alarms import (
    checked_machine_alarms,
    read_machine_alarms,
    write_machine_alarms,
)
from arctrue.device.daemon.probe_watch import ProbeWatch
from arctrue.device.daemon.serial_link import SerialLink
from arctrue.device.daemon.server import Server, turn_event
from arctrue.device.daemon.service_manager import keep_alive, notify
from arctrue.device.daemon.settings import DaemonSettings
from arctrue.device.daemon.state import DaemonState
from arctrue.device.daemon.store_lock import StoreLock
from arctrue.device.daemon.zero import checked_zero, read_zero, write_zero
from arctrue.device.lines import LineAssembler, TelemetryLine, is_telemetry, telemetry_of
from arctrue.device.port import ConsoleError
from arctrue.device.probe import Latch
from arctrue.device.recorder import RecordedTurn, Recorder, read_turns
from arctrue.measurement import MeasurementError

SILENCE_S = 30.0
"""Time in seconds without a byte from the device after which the daemon switches telemetry on
again, because a board that was switched off may have started with telemetry off."""
RETRY_RECORD_S = 5.0
"""Time in seconds between two attempts to open the record after a failure."""
LONGEST_PAUSE_S = 3600.0
"""Longest pause in seconds between two attempts to write the daily files. The pause doubles after
each failure, because attempts on a full disk take space from the record."""
SLOW_S = 2.0
"""Time in seconds after which an ending daemon reports that it is still closing the day's file."""
_CAPTURE_ERRORS = (ConsoleError, OSError, MeasurementError, ValueError)


class Daemon:
    """The daemon of one device. ``report`` receives a sentence for the log at each event."""

    def __init__(self, settings: DaemonSettings, report: Callable[[str], None]) -> None:
        """Make the folder of the captures, lock the store and open the record.

        Raises ConsoleError if another daemon has the store, OSError or sqlite3.Error.
        """
        self._settings, self._report = settings, report
        self.state = DaemonState(settings.port)
        self._lines = LineAssembler()
        self._link = SerialLink(settings.port, settings.baud, self._received, self._link_changed)
        self._server = Server(
            settings,
            self.state,
            self._link.write,
            self._turns,
            lambda: self._capture("asked"),
            self._life,
            self._zero,
        )
        self._probe = ProbeWatch(self._link.write, self._probed)
        settings.captures.mkdir(parents=True, exist_ok=True)
        self._lock = StoreLock(settings.store, f"arctrue device run {settings.port}")
        self._in_files = None if settings.files is None else 0
        self._files = None if settings.files is None else DayWriter(settings.record, settings.files)
        self._recorder: Recorder | None = self._opened_record()
        self.state.machine_alarms = read_machine_alarms(settings.machine_alarms)
        self.state.zero_deg = read_zero(settings.zero)
        self._record_retry_s = 0.0
        self._last_line_s = time.monotonic()
        self._last_number = -1
        self._next_alarm_capture_s = 0.0
        self._capturing = asyncio.Lock()
        self._tasks: set[asyncio.Task[Any]] = set()
        self._self: Announcement | None = None

    async def run(self) -> None:
        """Serve clients until SIGINT, SIGTERM or SIGHUP.

        Raises ConsoleError or OSError if the daemon cannot start.
        """
        self._link.open()
        host, tcp_port = await self._server.start()
        settings = self._settings
        self._self = Announcement(settings.port, host, tcp_port, settings.token, os.getpid())
        file = announce(self._self)
        self._report(f"serving {self._self.address}; the token is in {file}")
        notify(f"READY=1\nSTATUS={settings.port}: serving {self._self.address}")
        tasks = (self._link.keep_open(), keep_alive(), self._wake(), self._schedule())
        for work in (*tasks, self._write_files(), self._watch_probe()):
            self._start(work)
        ended = asyncio.Event()
        ending = [signal.SIGINT, signal.SIGTERM]
        if signal.getsignal(signal.SIGHUP) != signal.SIG_IGN:  # under nohup
            ending.append(signal.SIGHUP)
        for number in ending:
            asyncio.get_running_loop().add_signal_handler(number, ended.set)
        try:
            await ended.wait()
        finally:
            notify("STOPPING=1")
            file.unlink(missing_ok=True)
            for task in self._tasks:
                task.cancel()
            await self._server.close()
            self._link.close()
            await self._close_files()
            if self._recorder is not None:
                self._recorder.close()
            self._lock.release()

    def _start(self, work: Any) -> None:
        task = asyncio.get_running_loop().create_task(work)
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)

    def _received(self, data: bytes) -> None:
        self._last_line_s = time.monotonic()
        self._server.to_operator(data)
        for text in self._lines.add(data):
            if is_telemetry(text):
                turn = telemetry_of(text)
                if turn is None:
                    self.state.damaged_lines += 1
                else:
                    self._turn(turn)
            else:
                self._probe.line(text)
        self.state.too_long_lines = self._lines.too_long

    def _turn(self, turn: TelemetryLine) -> None:
        number = int(turn.fields["turn"])
        if number < self._last_number:
            self._probe.forget()
            self._happened(
                "restart", "the board has started again: its turns are counted from the beginning"
            )
        self._last_number = number
        self.state.turns += 1
        identifier = self._record(turn)
        alarms = list(turn.fields.get("alarms", []))
        new = sorted(set(alarms) - set(self.state.alarms))
        self.state.alarms = alarms
        now = time.time()
        if turn.result != "alarm":
            self.state.latest = {**turn.fields, "id": identifier, "recorded_s": now}
        self._server.broadcast(turn_event(now, identifier, turn.fields))
        if new:
            self._happened("alarm", f"new alarm: {', '.join(new)}")
            self._capture_for_alarm()

    def _record(self, turn: TelemetryLine) -> int | None:
        """Write a turn to the record and return its id; return None if the turn could not be
        written."""
        try:
            if self._recorder is None:
                if time.monotonic() < self._record_retry_s:
                    self.state.unrecorded_turns += 1
                    return None
                self._recorder = self._opened_record()
            identifier = self._recorder.add(turn)
            if not self.state.recording:
                self.state.recording = True
                lost = self.state.unrecorded_turns
                self._happened("record", f"turns are recorded again; {lost} were not recorded")
        except sqlite3.Error as error:
            self._record_failed(error)
            self.state.unrecorded_turns += 1
            return None
        return identifier

    def _opened_record(self) -> Recorder:
        """Open the record. If daily files are written, a turn that no daily file contains yet is
        not deleted, even if the record exceeds its limits."""
        recorder = Recorder(self._settings.record, self._settings.retention)
        recorder.deletable = self._in_files
        return recorder

    def _record_failed(self, error: Exception) -> None:
        if self._recorder is not None:
            with contextlib.suppress(sqlite3.Error):
                self._recorder.close()
            self._recorder = None
        self._record_retry_s = time.monotonic() + RETRY_RECORD_S
        if self.state.recording:
            self.state.recording = False
            text = f"{self._settings.record}: cannot be written: {error}; telemetry continues"
            self._happened("record", text)

    def _turns(self, latest: int, after: int) -> list[RecordedTurn]:
        try:
            return read_turns(self._settings.record, latest, after)
        except sqlite3.Error:
            return []

    def _happened(self, kind: str, text: str) -> None:
        """Write an event to the log and the record, and send it to the watchers."""
        self._report(text)
        self._server.broadcast(
            {"event": kind, "recorded_s": time.time(), "text": text, "state": self.state.as_dict()}
        )
        if self._recorder is not None:
            try:
                self._recorder.event(kind, text)
            except sqlite3.Error as error:
                self._record_failed(error)

    def _link_changed(self, is_open: bool, text: str) -> None:
        if is_open and self.state.turns:
            self.state.reconnections += 1
        self.state.connected = is_open
        self._lines.forget_begun()
        self._probe.forget()
        self._server.forget_begun()
        self._happened("port", text)
        notify(f"STATUS={text}")
        if is_open:
            self._link.write(b"\rtelemetry on\r")

    async def _wake(self) -> None:
        """Switch telemetry on again after silence; wait while an operator has the console."""
        while True:
            await asyncio.sleep(SILENCE_S / 4.0)
            silent_s = time.monotonic() - self._last_line_s
            if silent_s > SILENCE_S and not self.state.console_in_use:
                self._link.write(b"\rtelemetry on\r")

    async def _watch_probe(self) -> None:
        """Request the events of probe and compare; wait while an operator has the console."""
        every_s = self._settings.probe_every_s
        while every_s > 0.0:
            await asyncio.sleep(every_s)
            if self.state.console_in_use or not self.state.connected:
                self._probe.interrupted()
            else:
                self._probe.look(time.monotonic())

    def _probed(self, latches: Sequence[Latch]) -> None:
        """Record the events of probe or compare, and send them to the watchers."""
        self.state.probe_edges += len(latches)
        self.state.probe_missed += sum(latch.missed for latch in latches)
        for latch in latches:
            self._server.broadcast({"event": "probe", "recorded_s": time.time(), **asdict(latch)})
        if self._recorder is not None:
            try:
                self._recorder.edges(latches)
            except sqlite3.Error as error:
                self._record_failed(error)

    async def _schedule(self) -> None:
        while self._settings.capture_every_s > 0.0:
            await asyncio.sleep(self._settings.capture_every_s)
            await self._capture("schedule")

    async def _write_files(self) -> None:
        """Update the daily files from the record, at the start and after each interval."""
        pause_s = self._settings.files_every_s
        while self._files is not None:
            exceeded = self._recorder is not None and self._recorder.exceeded
            try:
                written, deletable = await self._files.update(exceeded=exceeded)
            except DayWriterError as error:
                self._happened("files", f"{self._settings.files}: no file was written: {error}")
                pause_s = min(2.0 * pause_s, LONGEST_PAUSE_S)
            else:
                pause_s = self._settings.files_every_s
                self._in_files = deletable
                if self._recorder is not None:
                    self._recorder.deletable = deletable
                    if exceeded:
                        self._apply_retention(self._recorder)
                for path in written:
                    self._report(f"written: {path}")
            await asyncio.sleep(pause_s)

    def _apply_retention(self, recorder: Recorder) -> None:
        try:
            recorder.apply_retention()
        except sqlite3.Error as error:
            self._record_failed(error)

    async def _close_files(self) -> None:
        if self._files is None:
            return
        text = f"{self._settings.files}: closing the day's file"
        slow = asyncio.get_running_loop().call_later(SLOW_S, self._report, text)
        try:
            await self._files.close()
        except DayWriterError as error:
            self._happened("files", f"{self._settings.files}: no file was written: {error}")
        finally:
            slow.cancel()

    def _life(self, alarms: Any) -> dict[str, Any]:
        """Replace the alarms that ``arctrue life`` sent earlier by ``alarms``; return the answer to
        the request."""
        try:
            given = checked_machine_alarms(alarms)
            write_machine_alarms(self._settings.machine_alarms, given)
        except (ValueError, OSError) as error:
            return {"error": f"the alarms of the machine's history are not accepted: {error}"}
        before, self.state.machine_alarms = self.state.machine_alarms, given
        new = [text for name, text in given.items() if before.get(name) != text]
        ended = [name for name in before if name not in given]
        texts = [*new, *(f"{name}: its alarm has ended" for name in ended)]
        if texts:
            self._happened("life", f"history of the machine: {' '.join(texts)}")
        return {"alarms": len(given)}

    def _zero(self, degrees: Any) -> dict[str, Any]:
        """Keep the angle that another axis has at the index; return the answer to the request."""
        try:
            zero_deg = checked_zero(degrees)
            write_zero(self._settings.zero, zero_deg)
        except (ValueError, OSError) as error:
            return {"error": f"the zero is not accepted: {error}"}
        if zero_deg != self.state.zero_deg:
            self.state.zero_deg = zero_deg
            self._happened("zero", f"the zero was set: the index is at {zero_deg:.10g}°")
        return {"zero_deg": zero_deg}

    def _capture_for_alarm(self) -> None:
        now = time.monotonic()
        if self._settings.capture_on_alarm and now >= self._next_alarm_capture_s:
            self._next_alarm_capture_s = now + self._settings.capture_pause_s
            self._start(self._capture("alarm"))

    async def _capture(self, why: str) -> dict[str, Any]:
        """Capture a turn as soon as the console is free; return the answer, which has the folder of
        the set under ``capture``, or the reason for a failure under ``error``."""
        settings = self._settings
        assert self._self is not None
        async with self._capturing:
            try:
                async with asyncio.timeout(settings.capture_timeout_s):
                    async with self._server.console_free:
                        await self._server.console_free.wait_for(
                            lambda: not self.state.console_in_use
                        )
                arguments = (self._self, settings.captures, why, settings.capture_timeout_s)
                path = await asyncio.to_thread(take_capture, *arguments)
                drop_oldest(settings.captures, settings.most_captures)
            except TimeoutError:
                self.state.failed_captures += 1
                return {"error": "the console was in use all the time: no capture was taken"}
            except _CAPTURE_ERRORS as error:
                self.state.failed_captures += 1
                self._happened("capture", f"no capture: {error}")
                return {"error": str(error)}
        self.state.captures += 1
        self.state.latest_capture = str(path.resolve())
        self._happened("capture", f"captured: {path}")
        return {"capture": self.state.latest_capture}
