"""Edges at probe_in: the daemon asks the device for its latch while no operator has the console."""

from __future__ import annotations

import contextlib
from collections.abc import Callable

from arctrue.device.probe import EDGES_WRAP, Latch

ANSWER_S = 2.0
"""Longest time for an answer: a calibration takes 0.3 s."""


class ProbeWatch:
    """Sends each new edge to ``found``; ``send`` sends to the device."""

    def __init__(self, send: Callable[[bytes], None], found: Callable[[Latch], None]) -> None:
        """Start without any values of the device."""
        self._send, self._found = send, found
        self._asked_s: float | None = None
        self._answer: dict[str, float] = {}
        self._clock_hz = self._counts_per_rev = 0.0
        self._edge: int | None = None

    def forget(self) -> None:
        """Ask again for clock and counts: the port was lost, or the board was restarted."""
        self._clock_hz = self._counts_per_rev = 0.0
        self._edge = self._asked_s = None

    def look(self, now_s: float) -> None:
        """Ask for missing values, else for the latch, unless an answer is still open."""
        if self._asked_s is not None and now_s < self._asked_s + ANSWER_S:
            return
        self._asked_s, self._answer = now_s, {}
        if not self._clock_hz:
            self._send(b"version\r")
        elif not self._counts_per_rev:
            self._send(b"show parameters\r")
        else:
            self._send(b"probe\r")

    def interrupted(self) -> None:
        """Stop waiting for an answer: an operator has the console."""
        self._asked_s = None

    def line(self, text: str) -> None:
        """Process a line of the device that is not telemetry."""
        if self._asked_s is None:
            return
        if text.startswith(("ok", "error")):
            self._asked_s = None
            self._take_answer()
            return
        name, _, value = text.partition(" ")
        with contextlib.suppress(ValueError):
            self._answer[name] = float(value)

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
        self._found(
            Latch(
                edge,
                answer["time_clocks"] / self._clock_hz,
                int(answer["position_counts"]),
                answer["angle_counts"] / self._counts_per_rev * 360.0,
                (edge - before) % EDGES_WRAP - 1,
            )
        )
