"""Tests ``arctrue load`` against the firmware's own console at the other end of a
pseudo-terminal."""

from __future__ import annotations

import dataclasses
import os
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner, Result
from sim.tests.cli.test_monitor import Device
from sim.tests.firmware.emulator import PATIENCE_S

from arctrue.cli import main
from arctrue.device.console import ConsoleError
from arctrue.gateware.coefficient_file import write_coefficient_file
from arctrue.gateware.coefficients import Coefficients, Extension
from arctrue.gateware.extension import Conditions
from arctrue.gateware.mean_set import MeanSet

COUNTS_PER_REV = 1 << 24


class SpoilingDevice(Device):
    """A device whose serial line once loses a digit of the first frame of a lane."""

    spoiled = False

    def received(self, data: bytes) -> bytes:
        if not self.spoiled and b"load lane" in data:
            self.spoiled = True
            return data.replace(b"1", b"", 1)
        return data


@pytest.fixture(params=[Device, SpoilingDevice])
def device(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> Iterator[Device]:
    made: Device = request.param()
    with made.running(monkeypatch):
        yield made


def file_of(
    folder: Path, lanes: dict[int, tuple[float, float]], counts_per_rev: int = COUNTS_PER_REV
) -> Path:
    counts = np.array([amplitude for amplitude, _ in lanes.values()]) * counts_per_rev / 1_296_000
    phases = [phase for _, phase in lanes.values()]
    path = folder / "coefficients.toml"
    write_coefficient_file(
        path, Coefficients.from_harmonics(list(lanes), counts, phases, counts_per_rev, 32)
    )
    return path


def run(device: Device, path: Path) -> Result:
    return CliRunner().invoke(main, ["load", device.port, str(path), "--timeout", str(PATIENCE_S)])


def test_a_file_is_loaded(device: Device, tmp_path: Path) -> None:
    """The command loads a file with orders 1 and 2 of the simulated table."""
    done = run(device, file_of(tmp_path, {1: (150.0, 0.4), 2: (6.0, 4.2)}))
    assert done.exit_code == 0, done.output
    assert "2 orders are loaded and active" in done.output
    assert getattr(device, "spoiled", True), "expected that the damaged frame is sent again"


def test_a_file_is_refused_with_the_reason(device: Device, tmp_path: Path) -> None:
    done = run(device, file_of(tmp_path, {1: (150.0, 0.4), 5: (8.0, 0.0)}))
    assert done.exit_code == 1, done.output
    assert "the device refuses: worse_prediction: the captured turn contradicts" in done.output
    done = run(device, file_of(tmp_path, {1: (150.0, 0.4)}, 3_600_000))
    assert done.exit_code == 1, done.output
    assert "another_table: the coefficients were made for another counts_per_rev" in done.output


class OtherEnd(Device):
    """A device that answers every ``load status`` with ``lines``, whatever file was loaded."""

    lines: tuple[str, ...] = ()

    def received(self, data: bytes) -> bytes:
        if b"load status" in data:
            os.write(self.end, "".join(line + "\r\n" for line in (*self.lines, "ok")).encode())
            return data.replace(b"load status\r", b"")
        return data


@pytest.mark.parametrize(
    ("lines", "said"),
    [
        (("load none",), "the device says load none"),
        (("load active", "loaded_order 7"), "it has the orders 7"),
        (("load active", "loaded_order 1", "loaded_crc 00000000"), "it has the orders 1"),
    ],
)
def test_what_is_not_active_in_the_end_is_no_success(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, lines: tuple[str, ...], said: str
) -> None:
    """The command reports a failure if something else (another program, ``forget``, a re-arm)
    changed the state during the load."""
    monkeypatch.setattr(OtherEnd, "lines", lines)
    made = OtherEnd()
    with made.running(monkeypatch):
        done = run(made, file_of(tmp_path, {1: (150.0, 0.4)}))
    assert done.exit_code == 1, done.output
    assert "these coefficients are not active" in done.output
    assert said in done.output


class TakesAll:
    """A console that accepts every frame. The model of the core in the other tests would refuse
    some frames, because it has no MODULATORS."""

    port = "a port"

    def __init__(self) -> None:
        self.frames: list[str] = []

    def command(self, line: str) -> list[str]:
        if line == "load status":
            return ["load active", f"loaded_crc {self.frames[-1].split()[-1]}"]
        self.frames.append(line)
        return []


def test_lanes_that_no_turn_shows_are_named(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """The command names the lane of order 0 × direction: this lane adds the same value to both
    heads, so that no turn shows it. The command does not name the lane of order 1 × direction,
    which adds different values."""
    plain = Coefficients.from_harmonics([1, 0, 1], [9.0, 5.0, 3.0], [0.0] * 3, COUNTS_PER_REV, 32)
    extension = Extension(
        conditions=Conditions(1600, 4, 45.0), modulators=((1, "direction"), (2, "direction"))
    )
    path = tmp_path / "coefficients.toml"
    write_coefficient_file(path, dataclasses.replace(plain, extension=extension))
    console = TakesAll()
    monkeypatch.setattr("arctrue.cli.load.console_at", lambda port: console)
    done = CliRunner().invoke(main, ["load", console.port, str(path), "--unseen"])
    assert done.exit_code == 0, done.output
    said = " ".join(done.output.split())
    assert "1 orders are loaded and active, and 2 lanes that follow a condition" in said
    assert "no turn of two heads shows 1 of these lanes" in said
    assert any(frame.startswith("load force 2 ") for frame in console.frames)


class TakesSets(TakesAll):
    """A console that refuses the first frame of a prepared set with ``reason``; the command sends
    this frame before ``load begin``, as a test."""

    reason = ""

    def command(self, line: str) -> list[str]:
        if line.startswith("load without ") and not any("begin" in one for one in self.frames):
            raise ConsoleError(f"{self.port}: 'load without' is refused: error: {self.reason}")
        return super().command(line)


@pytest.mark.parametrize(
    ("reason", "are_sent"),
    [
        ("load wrong_frame", True),
        ("load no_failover", False),
        ("use: load begin FRAMES COUNTS CRC", False),
    ],
)
def test_sets_for_a_missing_head_go_to_a_gateware_that_takes_them(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, reason: str, are_sent: bool
) -> None:
    """A core without FAILOVER, or an older firmware, receives the file without these sets; the
    command warns that they were not loaded."""
    heads = MeanSet((20000, 15536, 14000, 16000), (0, 160, 320, 480))
    without = MeanSet((40000, 30000, 0, -4464), (0, 160, 320, 480), 1, 3)
    plain = Coefficients.from_harmonics([2], [1.0], [0.0], COUNTS_PER_REV, 32)
    three = dataclasses.replace(plain, extension=Extension(mean=without))
    four = dataclasses.replace(plain, extension=Extension(mean=heads, without=(three,)))
    path = tmp_path / "four.toml"
    write_coefficient_file(path, four)
    monkeypatch.setattr(TakesSets, "reason", reason)
    console = TakesSets()
    monkeypatch.setattr("arctrue.cli.load.console_at", lambda port: console)
    done = CliRunner().invoke(main, ["load", console.port, str(path)])
    assert done.exit_code == 0, done.output
    assert any(frame.startswith("load without ") for frame in console.frames) == are_sent
    said = " ".join(done.output.split())
    assert ("with the coefficients for the loss of a head" in said) == are_sent
    assert ("built without FAILOVER" in said) != are_sent


@pytest.mark.parametrize(
    ("line", "said"),
    [
        ("waits_for the_other_direction", "waiting for a turn in the other direction"),
        ("waits_for another_speed", "waiting for a turn at another speed"),
    ],
)
def test_the_condition_that_no_turn_has_shown_is_named(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, line: str, said: str
) -> None:
    monkeypatch.setattr(OtherEnd, "lines", ("load waiting", line))
    made = OtherEnd()
    with made.running(monkeypatch):
        path = file_of(tmp_path, {1: (150.0, 0.4)})
        done = CliRunner().invoke(main, ["load", made.port, str(path), "--timeout", "1"])
    assert done.exit_code == 2, done.output
    assert said in " ".join(done.output.split())
    assert "--force" in done.output


def test_an_order_that_two_heads_cannot_see_takes_force(device: Device, tmp_path: Path) -> None:
    path = file_of(tmp_path, {1: (150.0, 0.4), 120: (0.5, 0.0)})
    done = run(device, path)
    assert done.exit_code == 1, done.output
    assert "unseen_order: two heads at this angle cannot see" in done.output
    assert "(order 120)" in done.output
    done = CliRunner().invoke(
        main, ["load", device.port, str(path), "--timeout", str(PATIENCE_S), "--force"]
    )
    assert done.exit_code == 0, done.output
    assert "2 orders are loaded and active; not tested by any turn: 120" in done.output


def test_orders_that_turns_do_not_decide_are_named(device: Device, tmp_path: Path) -> None:
    path = file_of(tmp_path, {1: (150.0, 0.4), 11: (0.0005, 0.0)})
    done = CliRunner().invoke(main, ["load", device.port, str(path), "--timeout", "3"])
    assert done.exit_code == 2, done.output
    assert "did not show whether the orders 11 are right" in done.output


def test_what_is_no_coefficient_file(device: Device, tmp_path: Path) -> None:
    done = run(device, tmp_path / "none.toml")
    assert done.exit_code == 2
    assert "no such file" in done.output
    path = file_of(tmp_path, {1: (150.0, 0.4)})
    text = path.read_text("utf-8").replace("counts = 0.0\nword = 0", "counts = 1.0\nword = 2048")
    path.write_text(text, encoding="utf-8")
    done = run(device, path)
    assert done.exit_code == 2
    assert "offset.word is 2048; expected 0" in done.output


def test_sets_for_a_missing_head_are_named_as_not_loaded(
    tmp_path: Path,
) -> None:
    """If a lane of the file follows a condition, the command does not load the sets for a missing
    head; its warning names these heads. The test needs no device, because the warning is printed
    before the port is opened."""
    heads = MeanSet((20000, 15536, 14000, 16000), (0, 160, 320, 480))
    without = MeanSet((40000, 30000, 0, -4464), (0, 160, 320, 480), 1, 3)
    plain = Coefficients.from_harmonics([2], [1.0], [0.0], COUNTS_PER_REV, 32)
    three = dataclasses.replace(plain, extension=Extension(mean=without))
    four = dataclasses.replace(plain, extension=Extension(mean=heads, without=(three,)))
    assert four.extension is not None
    speed = dataclasses.replace(
        four.extension, modulators=((0, "speed"),), conditions=Conditions(16, 0, 90.0)
    )
    path = tmp_path / "four.toml"
    write_coefficient_file(path, dataclasses.replace(four, extension=speed))
    done = CliRunner().invoke(main, ["load", str(tmp_path / "no_port"), str(path)])
    assert done.exit_code == 2, done.output
    assert "the coefficients for the loss of head 3 are not sent" in done.output
    write_coefficient_file(path, four)
    done = CliRunner().invoke(main, ["load", str(tmp_path / "no_port"), str(path)])
    assert "are not sent" not in done.output
