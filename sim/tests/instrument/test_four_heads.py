"""The device with four heads: capture, calibration of the mean, load, and what fresh turns show.

The table has 2¹⁸ counts a turn, 4.94″ each, so that a turn is simulated in seconds.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner
from numpy.typing import NDArray

from arctrue.cli import main
from arctrue.device.dump import read_head, read_row
from arctrue.device.load import DEVICE_LOADS, load_frames
from arctrue.gateware.coefficient_file import read_coefficient_file
from arctrue.gateware.coefficients import Coefficients
from arctrue.gateware.extension import Extension
from arctrue.gateware.mean_set import MeanSet
from arctrue.instrument import HEAD4_A, HEAD4_B, Firmware, Instrument, PinFault
from arctrue.instrument.recording import EdgeTrack
from arctrue.measurement import read_measurement_set, write_measurement_set
from arctrue.studies.heads.bench import PLACES_DEG
from arctrue.studies.heads.shown import BALLS
from arctrue.studies.revolution import ECCENTRICITY_DIRECTION_RAD, ECCENTRICITY_M
from arctrue.studies.revolution.settings import RevolutionSettings
from arctrue.table import (
    DISC_RADIUS_M,
    Cause,
    DiscEccentricity,
    GraduationHarmonics,
    RotaryTable,
    heads_at,
)
from arctrue.table.causes.radial_motion import RadialMotion

SETTINGS = RevolutionSettings(
    lines=256, lanes=4, samples=1600, orders=8, noise_arcsec=0.0, clocks_per_count=1.15
)
HUB = DiscEccentricity(2e-6, 1.1)
"""The disc's centre moves by 2 µm against the axis: 7.6″ at its radius, once a turn."""
AXIS = (BALLS, RadialMotion(3, 0.05e-6 + 0j))
GRADUATION = {2: 1.6, 5: 0.9}
"""Order of the disc, arcseconds."""
TURNS = 3.0
"""Of a recording: the balls' order 4.37 is then a whole period off the disc's."""
EVERY = 16
"""Edges between two that are kept."""
LINE_ARCSEC = 0.25
"""Of a fitted amplitude: readings are rounded to counts of 4.94″, 1.43″ RMS. The mean of four has
half of it, and as the heads' differences drift by 58 counts a turn, some 60 roundings a turn are
independent: 0.71″ × √(2/60) = 0.13″. Twice that. docs/heads.md has 2²⁴ counts: 0.004″."""


def table(*causes: Cause) -> RotaryTable:
    orders = tuple(GRADUATION)
    disc = (
        DiscEccentricity(ECCENTRICITY_M, ECCENTRICITY_DIRECTION_RAD),
        GraduationHarmonics(
            orders, tuple(np.radians(GRADUATION[n] / 3600.0) for n in orders), (0.4, 1.9)
        ),
    )
    return RotaryTable(
        heads_at(np.radians(PLACES_DEG).tolist()),
        (*disc, *causes),
        counts_per_rev=SETTINGS.counts_per_rev,
        rounding="nearest",
    )


@dataclass(frozen=True)
class Track:
    """What a signal was off from the table, up to a constant."""

    angle_rad: NDArray[np.float64]
    error_arcsec: NDArray[np.float64]

    def line(self, order: float) -> complex:
        """The component at an order, beside the whole orders 0 to 8, arcseconds."""
        columns = [np.ones(self.angle_rad.size)]
        for n in (order, *(n for n in range(1, 9) if n != order)):
            columns += [np.cos(n * self.angle_rad), np.sin(n * self.angle_rad)]
        matrix = np.stack(columns, axis=1)
        found, *_ = np.linalg.lstsq(matrix, self.error_arcsec, rcond=None)
        return complex(found[1], -found[2])


def track_of(edges: EdgeTrack) -> Track:
    turn = edges.true_angle_rad / (2.0 * np.pi)
    error = edges.position - turn * edges.counts_per_rev
    return Track(edges.true_angle_rad, (error - error.mean()) * SETTINGS.arcsec_per_count)


@dataclass
class Device:
    """The instrument with four heads, and its console."""

    instrument: Instrument
    firmware: Firmware

    def attach(self, *causes: Cause, turns: float = 30.0) -> None:
        """Put a turning table with these causes before the heads."""
        motion = type(SETTINGS.motion()).steady(
            SETTINGS.speed_rad_s, turns * 2.0 * np.pi / SETTINGS.speed_rad_s, start_rad=-0.2
        )
        self.instrument.attach(table(*causes), motion)

    def turn_before(self, *causes: Cause) -> None:
        """The same; the device looks for the indices anew."""
        self.attach(*causes)
        self.firmware.start()

    def save(self) -> None:
        """Keep settings and coefficients in the flash."""
        self.firmware.send("save")
        self.firmware.run(until=lambda f: "saved_record 1" in f.send("status"))

    def accepted_turn(self) -> dict[str, Any]:
        """What telemetry says of the next turn that is not refused."""
        first = len(self.firmware.telemetry)

        def accepted() -> list[dict[str, Any]]:
            new = self.firmware.telemetry[first:]
            return [line for line in new if line["result"] in ("applied", "kept")]

        self.firmware.run(until=lambda _: bool(accepted()), poll_clocks=SETTINGS.poll_clocks)
        return accepted()[0]

    def dumped(self, folder: Path) -> Path:
        """One capture as the console tells it, as a measurement set."""
        self.firmware.send("dump")
        said = ""
        while "end of dump" not in said:
            self.instrument.run(SETTINGS.poll_clocks)
            said += self.firmware.step() + "\n"
        lines = [line.strip() for line in said.splitlines()]
        (head,) = [found for line in lines if (found := read_head(line)) is not None]
        rows = {row[0]: row[1:] for line in lines if (row := read_row(line)) is not None}
        write_measurement_set(folder, head.measurement(rows, "the instrument"))
        return folder

    def load(self, coefficients: Coefficients) -> str:
        """Send the frames and wait for the turn that judges them; the state that follows."""
        for frame in load_frames(coefficients):
            answer = self.firmware.send(frame)
            assert answer.strip() == "ok", f"{frame}: {answer}"
        self.firmware.run(
            until=lambda f: "load waiting" not in f.send("load status"),
            poll_clocks=10 * SETTINGS.poll_clocks,
        )
        return self.firmware.send("load status").splitlines()[0].strip()

    def record(self) -> tuple[Track, Track]:
        """Table angles and errors in arcseconds: of the output and of head 1 as it comes in."""
        self.firmware.run(until=lambda _: not self.instrument.read("status.ramp_busy"))
        self.instrument.record(every=EVERY, turns=TURNS)
        end = self.instrument.true_angle_rad + TURNS * 2.0 * np.pi
        self.firmware.run(until=lambda _: self.instrument.true_angle_rad >= end)
        recording = self.instrument.recording()
        return track_of(recording.output), track_of(recording.head1)


@pytest.fixture(scope="module")
def device() -> Iterator[Device]:
    with Instrument(4, 2048, clock_hz=SETTINGS.clock_hz, generics={"HEADS": 4}) as made:
        firmware = made.firmware
        for name, value in (
            ("counts_per_rev", SETTINGS.counts_per_rev),
            ("sample_period", SETTINGS.sample_period_clocks),
            *SETTINGS.ramp_parameters.items(),
            ("output_spacing", 1),
            ("orders", SETTINGS.orders),
            ("separation_deg", PLACES_DEG[1]),
            ("alarm_noise_arcsec", SETTINGS.arcsec_per_count),
        ):
            firmware.set(name, value)
        yield Device(made, firmware)


@pytest.mark.slow
def test_capture_calibrate_load_and_fresh_turns(device: Device, tmp_path: Path) -> None:
    """The way of docs/heads.md on the device itself, its counts 64 times coarser."""
    balls_arcsec = np.degrees(0.25e-6 / DISC_RADIUS_M) * 3600.0
    hub_arcsec = np.degrees(2e-6 / DISC_RADIUS_M) * 3600.0
    device.turn_before(*AXIS)
    first = device.accepted_turn()
    assert "mean_of_heads" not in first
    two_heads, _ = device.record()
    assert abs(two_heads.line(BALLS.order)) == pytest.approx(balls_arcsec, abs=LINE_ARCSEC)

    sets = device.dumped(tmp_path / "set")
    capture = read_measurement_set(sets).capture
    assert capture is not None
    assert len(capture.heads) == 4
    out = tmp_path / "calibrated"
    words = ["calibrate", str(sets), "--angle", "mean", "--motion", "3", "--orders", "8"]
    done = CliRunner().invoke(main, [*words, "--lanes", "4", "--out", str(out)])
    assert done.exit_code == 0, done.output
    coefficients = read_coefficient_file(out / "coefficients.toml", DEVICE_LOADS)
    assert device.load(coefficients) == "load active"
    mean = device.accepted_turn()
    assert (mean["mean_of_heads"], mean["carrier"], mean["result"]) == (4, 1, "kept")
    # The largest place's error: the calibration's of 1,600 counts of 5″, twice.
    assert mean["mean_off_arcsec"] < 0.5
    assert mean["alarms"] == []
    before, head1_before = device.record()
    assert abs(before.line(BALLS.order)) < LINE_ARCSEC
    assert abs(head1_before.line(BALLS.order)) == pytest.approx(balls_arcsec, abs=LINE_ARCSEC)

    # The hub moves while the power is off. A turn confirms the saved set, nothing is fitted.
    device.save()
    flash = device.firmware.flash
    device.attach(*AXIS, HUB)
    device.instrument.reset()
    device.firmware.power_on(flash)
    assert device.accepted_turn()["mean_of_heads"] == 4
    assert device.firmware.send("status").count("saved confirmed") == 1
    after, head1_after = device.record()
    assert abs(after.line(BALLS.order)) < LINE_ARCSEC
    assert abs(after.line(1) - before.line(1)) < LINE_ARCSEC
    change = abs(head1_after.line(1) - head1_before.line(1))
    assert change == pytest.approx(hub_arcsec, abs=LINE_ARCSEC), "what head 1 sees of it"


def mean_of(**changes: Any) -> Coefficients:
    """A mean of four heads at PLACES_DEG, with no lane but one; ``changes`` of its words."""
    counts = SETTINGS.counts_per_rev
    offsets = tuple(round(place / 360.0 * counts * 16) for place in PLACES_DEG)
    mean = MeanSet((14634, 16406, 18396, 16100), offsets)
    lanes = Coefficients.from_harmonics([2], [0.1], [0.0], counts, 4)
    return replace(lanes, extension=Extension(mean=replace(mean, **changes)))


@pytest.mark.slow
def test_a_mean_of_other_heads_is_refused(device: Device) -> None:
    """A head 0.1 degrees off by a turn; three heads, other delays and a wrong sum at once."""
    device.turn_before(*AXIS)
    device.accepted_turn()
    offsets = list(mean_of().extension.mean.offsets)  # type: ignore[union-attr]
    offsets[2] += round(0.1 / 360.0 * SETTINGS.counts_per_rev * 16)
    assert device.load(mean_of(offsets=tuple(offsets))) == "load refused other_heads"
    three = mean_of(weights=(20000, 25536, 20000), offsets=(0, 1, 2), delays_clocks=())
    late = mean_of(delays_clocks=(0, 0, 0, 7))
    for coefficients, reason in ((three, "other_heads"), (late, "other_delays")):
        *frames, end = load_frames(coefficients)
        for frame in frames:
            assert device.firmware.send(frame).strip() == "ok"
        assert reason in device.firmware.send(end)
    frames = load_frames(mean_of())
    spoiled = [frame for frame in frames if not frame.startswith("load head 3 ")]
    for frame in spoiled[:-1]:
        assert device.firmware.send(frame).strip() == "ok"
    assert "wrong_crc" in device.firmware.send(spoiled[-1])


@pytest.mark.slow
def test_faults_of_head_4_are_told(device: Device) -> None:
    """An illegal transition: the counter on the console, and the drivers by choice."""
    device.firmware.send("set release_sources 128")
    device.turn_before(*AXIS)
    device.accepted_turn()
    assert "head4_illegals 0" in device.firmware.send("status")
    begin = device.instrument.clock + 100
    device.instrument.disturb(PinFault(begin, 40, invert=HEAD4_A | HEAD4_B))
    device.firmware.run(clocks=2000)
    assert "head4_illegals 0" not in device.firmware.send("status")
    assert "head3_illegals 0" in device.firmware.send("status")
    assert "released head4" in device.firmware.send("status")
    assert "ok" in device.firmware.send("clear_output")
    device.firmware.send("set release_sources 0")
