"""``arctrue monitor PORT``: shows and records the telemetry of a device, turn by turn."""

from __future__ import annotations

import sqlite3
import sys
from pathlib import Path

import click

from arctrue.base.figures import figure
from arctrue.base.read_errors import sentence
from arctrue.cli._device import console_at, watch_at
from arctrue.cli._numbers import Finite
from arctrue.cli._outputs import OutputFile, OutputFolder
from arctrue.cli._tables import live_head, live_row
from arctrue.cli._terminal import note, say, tell_error
from arctrue.device.connection import Watch, open_console
from arctrue.device.console import Console, ConsoleError, TelemetryLine
from arctrue.device.dated_set import write_dated_set
from arctrue.device.recorder import Recorder
from arctrue.measurement import MeasurementSet

NO_DEVICE = 2


@click.command(short_help="Show and record a device's telemetry.")
@click.argument("port")
@click.option("--turns", type=click.IntRange(min=1), help="End after this number of turns.")
@click.option(
    "--record",
    type=OutputFile(),
    help="Append every turn to this SQLite file.",
)
@click.option(
    "--sets",
    type=OutputFolder(),
    help="Folder for captures as measurement sets: the first turn, then one of every --every "
    "turns.",
)
@click.option(
    "--every",
    type=click.IntRange(min=1),
    default=100,
    show_default=True,
    help="Number of turns between two captures.",
)
@click.option(
    "--silence",
    type=Finite(min=0.1),
    default=60.0,
    show_default=True,
    help="Seconds without a turn after which a warning is printed.",
)
@click.option(
    "--trend",
    type=Finite(min=0.0),
    default=0.1,
    show_default=True,
    help="Report an order that changes steadily by more than this within 128 turns, ″.",
)
def monitor(
    port: str,
    turns: int | None,
    record: Path | None,
    sets: Path | None,
    every: int,
    silence: float,
    trend: float,
) -> None:
    """Show the telemetry of the device at PORT (/dev/ttyUSB1, COM5) until Ctrl-C.

    Any number of monitors can watch a port that arctrue device run owns.

    Exit code 2: the device does not answer, or a file cannot be written.
    """
    from arctrue.metrology.trend import TrendWatch

    try:
        watching = watch_at(port)
        console = None if watching is not None else console_at(port)
        if console is not None:
            console.command("telemetry on")
        recorder = None if record is None else Recorder(record)
        watch = TrendWatch(trend)
        say(_HEAD)
        seen = 0
        captures = 0
        while turns is None or seen < turns:
            if sets is not None and seen >= captures * every:
                captures += 1
                taken = _capture(port, console, max(silence, 60.0))
                say(f"capture: {write_dated_set(sets, taken)}")
            turn = _turn(watching or console, silence)
            if turn is None:
                note(f"no turn for {silence:g} s; does the table turn?")
                continue
            seen += 1
            say(_row(turn))
            for moving in watch.add(int(turn.fields["turn"]), turn.fields.get("harmonics", [])):
                say(f"      trend: {moving}")
            if recorder is not None:
                recorder.add(turn)
    except KeyboardInterrupt:
        return
    except sqlite3.Error as error:
        tell_error(f"{record}: cannot be written: {error}")
        sys.exit(NO_DEVICE)
    except (ConsoleError, OSError) as error:
        tell_error(sentence(error))
        sys.exit(NO_DEVICE)


def _turn(source: Watch | Console | None, seconds: float) -> TelemetryLine | None:
    return None if source is None else source.turn(seconds)


def _capture(port: str, console: Console | None, seconds: float) -> MeasurementSet:
    """Capture a turn; without ``console``, open the daemon's console only for this capture."""
    if console is not None:
        return console.dump(seconds)
    console = open_console(port, lambda _: None)
    try:
        return console.dump(seconds)
    finally:
        console.close()


_COLUMNS = (
    ("turn", 5),
    ("result", -8),
    ("reason", -18),
    ("head 2 °", 10),
    ("noise″", 6),
    ("error″", 7),
    ("die °C", 6),
    ("order1″", 8),
)
"""Columns of the live table; the table is 75 characters wide, spaces included."""

_HEAD = live_head(_COLUMNS)


def _row(turn: TelemetryLine) -> str:
    fields = turn.fields
    harmonics = fields.get("harmonics", [])
    line = live_row(
        [
            str(fields["turn"]),
            turn.result,
            str(fields["reason"]),
            figure(fields.get("separation_deg"), 5),
            figure(fields.get("noise_arcsec"), 3),
            figure(fields.get("active_arcsec"), 3),
            figure(fields.get("temperature_c"), 1),
            figure(harmonics[0][1] if harmonics else None, 3),
        ],
        _COLUMNS,
    )
    alarms = fields.get("alarms", [])
    return f"{line}\n      alarm: {', '.join(alarms)}" if alarms else line
