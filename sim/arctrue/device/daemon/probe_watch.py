"""Collects the events of probe and compare (edges of probe_in, pulses of compare_out): the daemon
requests them from the device while no operator has the console."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Sequence

from arctrue.device.probe import EVENTS_COMMAND, Latch, event_of, missed_before

ANSWER_S = 2.0
"""Longest time in seconds to wait for an answer; a calibration delays it by 0.3 s."""


class ProbeWatch:
    """Requests events with ``send``, which sends to the device, and passes the new events of each
    answer to ``found``.

    The requests read the queue of events, or the latch of the probe if the device has no queue.
    ``line`` also passes on the events that an operator reads from the queue.
    """

    def __init__(
        self, send: Callable[[bytes], None], found: Callable[[Sequence[Latch]], None]
    ) -> None:
        """Store the callbacks; nothing is known about the device yet."""
        self._send, self._found = send, found
        self._asked_s: float | None = None
        self._answer: dict[str, float] = {}
        self._events: list[Latch] = []
        self.forget()

    def forget(self) -> None:
        """Discard clock frequency, counts per turn and the number of the last event, after a
        restart or a lost port."""
        self._clock_hz = self._counts_per_rev = 0.0
        self._edge: int | None = None
        self._asked_s = None
        self._send_events()
        self._asks_queue = False
        self._has_queue = True
        """Whether the device may have a queue; False after it has refused the command."""

    def look(self, now_s: float) -> None:
        """Request missing values, or events if no value is missing; wait for a pending answer."""
        if self._asked_s is not None and now_s < self._asked_s + ANSWER_S:
            return
        self._asked_s, self._answer = now_s, {}
        self._asks_queue = False
        if not self._clock_hz:
            self._send(b"version\r")
        elif not self._counts_per_rev:
            self._send(b"show parameters\r")
        elif self._has_queue:
            self._asks_queue = True
            self._send(f"{EVENTS_COMMAND}\r".encode())
        else:
            self._send(b"probe\r")

    def interrupted(self) -> None:
        """Stop waiting for an answer, because an operator has the console."""
        self._asked_s = None

    def line(self, text: str) -> None:
        """Process a line from the device that is not telemetry."""
        if text.startswith("event "):
            self._take_event(text)
            return
        if text.startswith(("ok", "error")):
            self._send_events()
        if self._asked_s is None:
            return
        if text.startswith(("ok", "error")):
            self._asked_s = None
            if self._asks_queue:
                self._has_queue = text.startswith("ok")
            else:
                self._take_answer()
            return
        name, _, value = text.partition(" ")
        with contextlib.suppress(ValueError):
            self._answer[name] = float(value)

    def _take_event(self, text: str) -> None:
        if not (self._clock_hz and self._counts_per_rev):
            return
        latch = event_of(text, self._clock_hz, self._counts_per_rev, self._edge)
        if latch is not None:
            self._edge = latch.edge
            self._events.append(latch)

    def _send_events(self) -> None:
        events, self._events = self._events, []
        if events:
            self._found(events)

    def _take_answer(self) -> None:
        answer = self._answer
        self._clock_hz = answer.get("clock_hz", self._clock_hz)
        self._counts_per_rev = answer.get("counts_per_rev", self._counts_per_rev)
        if not {"edges", "time_clocks", "position_counts", "angle_counts"} <= answer.keys():
            return
        edge, before = int(answer["edges"]), self._edge
        self._edge = edge
        if before is None or edge == before or not (self._clock_hz and self._counts_per_rev):
            return
        latch = Latch(
            edge,
            answer["time_clocks"] / self._clock_hz,
            int(answer["position_counts"]),
            answer["angle_counts"] / self._counts_per_rev * 360.0,
            missed_before(edge, before),
        )
        self._found([latch])
