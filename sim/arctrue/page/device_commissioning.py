"""Runs the steps of a commissioning in the background while the operator moves the table."""

from __future__ import annotations

import threading
from collections.abc import Callable
from contextlib import closing
from dataclasses import dataclass, replace

from arctrue.calibration.commissioning import Connection
from arctrue.device.commissioning import (
    MeasuredTurn,
    Parameters,
    Turned,
    both_directions,
    measure_turn,
    planned_places,
    read_connection,
    read_heads_table,
    read_parameters,
    write_delays,
    write_places,
)
from arctrue.device.connection import open_console
from arctrue.device.console import Console
from arctrue.page.people import failure

_MOVEMENT_S = 300.0
"""Longest time in seconds that a step waits for the operator to move the table."""


@dataclass(frozen=True)
class CompletedSteps:
    """Results of the completed steps; when a step is repeated, the results of later steps are
    deleted."""

    plan_deg: tuple[float, ...] = ()
    connection: Connection | None = None
    forward: MeasuredTurn | None = None
    turned: Turned | None = None
    written: bool = False

    def next_step(self) -> str:
        """Return the name of the first step without a valid result; after all steps, return
        "write"."""
        if self.connection is None or self.connection.faults:
            return "connection"
        if self.forward is None:
            return "forward"
        return "backward" if self.turned is None else "write"


class DeviceCommissioning:
    """Commissions the heads of one device; only one step runs at a time."""

    def __init__(self, port: str) -> None:
        """Store ``port``, the serial port of the device or HOST:PORT of its daemon."""
        self._port = port
        self.completed = CompletedSteps()
        self.table: list[tuple[str, ...]] = []
        """Latest table of the heads that the device has sent; empty before the first one."""
        self.running = ""
        """Name of the running step, or "" if none is running."""
        self.problem = ""
        """Reason why the latest step failed, or ""."""
        self._lock = threading.Lock()

    def start(self, step: str, plan_deg: tuple[float, ...] | None) -> None:
        """Start a step unless one is running. ``plan_deg``: planned places of the heads; None: the
        places stored in the device. The step "table" reads the device's table of the heads and may
        run at any time.

        Raises ValueError for a step whose earlier steps are missing.
        """
        steps: dict[str, Callable[[Console, Parameters, CompletedSteps], CompletedSteps]] = {
            "connection": lambda console, device, _: _connection(console, device, plan_deg),
            "forward": _forward,
            "backward": _backward,
            "write": _write,
        }
        order = list(steps)
        with self._lock:
            if self.running:
                return
            if step == "table":
                self.running, self.problem = step, ""
                threading.Thread(target=self._take, args=(self._read_table,), daemon=True).start()
                return
            if step not in order or order.index(step) > order.index(self.completed.next_step()):
                raise ValueError(f"step {step!r} needs the steps before it")
            self.running, self.problem = step, ""
        threading.Thread(target=self._take, args=(steps[step],), daemon=True).start()

    def _read_table(
        self, console: Console, _: Parameters, before: CompletedSteps
    ) -> CompletedSteps:
        self.table = read_heads_table(console)
        return before

    def _take(self, work: Callable[[Console, Parameters, CompletedSteps], CompletedSteps]) -> None:
        try:
            with closing(open_console(self._port, lambda _: None)) as console:
                self.completed = work(console, read_parameters(console), self.completed)
        except Exception as error:
            self.problem = failure(error)
        self.running = ""


def _connection(
    console: Console, device: Parameters, plan_deg: tuple[float, ...] | None
) -> CompletedSteps:
    plan = plan_deg or planned_places(device)
    return CompletedSteps(plan, read_connection(console, device, plan, _MOVEMENT_S))


def _forward(console: Console, device: Parameters, before: CompletedSteps) -> CompletedSteps:
    turn = measure_turn(console, device, before.plan_deg, _MOVEMENT_S)
    return CompletedSteps(before.plan_deg, before.connection, turn)


def _backward(console: Console, device: Parameters, before: CompletedSteps) -> CompletedSteps:
    assert before.forward is not None
    turn = measure_turn(console, device, before.plan_deg, _MOVEMENT_S)
    turned = both_directions(device, before.forward, turn)
    return replace(before, turned=turned, written=False)


def _write(console: Console, device: Parameters, before: CompletedSteps) -> CompletedSteps:
    assert before.turned is not None
    write_places(console, tuple(before.turned.places_deg.tolist()))
    if before.turned.skew.head_delays != int(device.get("head_delays", 0.0)):
        write_delays(console, before.turned.skew)
    return replace(before, written=True)
