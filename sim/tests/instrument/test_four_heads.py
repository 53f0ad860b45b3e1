"""Tests the device with four heads: capture, calibration of the mean, load, further turns.

The table has only 2¹⁸ counts of 4.94″ per turn, so that the simulation of a turn takes seconds.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner

from arctrue.cli import main
from arctrue.device.load import DEVICE_LOADS, load_frames
from arctrue.gateware.coefficient_file import read_coefficient_file
from arctrue.gateware.coefficients import Coefficients, Extension
from arctrue.gateware.mean_set import MeanSet
from arctrue.instrument import HEAD3_A, HEAD3_B, HEAD3_Z, HEAD4_A, HEAD4_B, PinFault
from arctrue.measurement import read_measurement_set, write_measurement_set
from arctrue.studies.heads.device import HeadsDevice
from arctrue.studies.heads.self_calibrated_table import PLACES_DEG
from arctrue.studies.heads.shown import BALLS
from arctrue.studies.revolution.settings import RevolutionSettings
from arctrue.table import (
    DISC_RADIUS_M,
    DiscEccentricity,
)
from arctrue.table.causes.radial_motion import RadialMotion

SETTINGS = RevolutionSettings(
    lines=256, lanes=4, samples=1600, orders=8, noise_arcsec=0.0, clocks_per_count=1.15
)
HUB = DiscEccentricity(2e-6, 1.1)
"""Displacement of the disc's centre from the axis by 2 µm, which adds 7.6″ of order 1 at the disc's
radius."""
AXIS = (BALLS, RadialMotion(3, 0.05e-6 + 0j))
LINE_ARCSEC = 0.25
"""Tolerance of a fitted amplitude.

Readings are rounded to counts of 4.94″, which is 1.43″ RMS, or half of this for the mean of four.
The heads' differences drift by 58 counts per turn, so that about 60 roundings in a turn are
independent: 0.71″ × √(2/60) = 0.13″. The tolerance is twice as large. With the 2²⁴ counts of
docs/heads.md it would be 0.004″.
"""


@pytest.fixture(scope="module")
def device() -> Iterator[HeadsDevice]:
    with HeadsDevice(SETTINGS) as made:
        yield made


@pytest.mark.large
def test_capture_calibrate_load_and_fresh_turns(device: HeadsDevice, tmp_path: Path) -> None:
    """The device performs the steps of docs/heads.md, with counts that are 64 times coarser."""
    balls_arcsec = np.degrees(0.25e-6 / DISC_RADIUS_M) * 3600.0
    hub_arcsec = np.degrees(2e-6 / DISC_RADIUS_M) * 3600.0
    device.turn_before(*AXIS)
    first = device.accepted_turn()
    assert "mean_of_heads" not in first
    two_heads, _ = device.record()
    assert abs(two_heads.line(BALLS.order)) == pytest.approx(balls_arcsec, abs=LINE_ARCSEC)

    sets = tmp_path / "set"
    write_measurement_set(sets, device.dumped())
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
    # The bound is twice the largest error of a head's angle in a calibration with 1,600 samples and
    # counts of 5″.
    assert mean["mean_off_arcsec"] < 0.5
    assert mean["alarms"] == []
    assert "active_arcsec" in first
    assert "active_arcsec" not in mean, (
        "the key describes head 1; a 0 would look like a perfect mean"
    )
    before, head1_before = device.record()
    assert abs(before.line(BALLS.order)) < LINE_ARCSEC
    assert abs(head1_before.line(BALLS.order)) == pytest.approx(balls_arcsec, abs=LINE_ARCSEC)

    # While the power is off, the hub is moved; a turn confirms the saved set without a new fit.
    device.firmware.send("save")
    device.run_until(lambda: "saved_record 1" in device.firmware.send("status"))
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
    assert change == pytest.approx(hub_arcsec, abs=LINE_ARCSEC), "the change of head 1's reading"


@pytest.mark.large
def test_the_device_calibrates_the_mean_alone(device: HeadsDevice) -> None:
    """Without a host, the firmware fits the coefficients, computes the weights, writes both and
    swaps; further turns agree with the true angle."""
    balls_arcsec = np.degrees(0.25e-6 / DISC_RADIUS_M) * 3600.0
    device.calibrate_alone()
    device.firmware.send("forget")
    device.turn_before(*AXIS)
    first = device.accepted_turn()
    assert (first["result"], first["mean_of_heads"], first["carrier"]) == ("applied", 4, 1)
    # The simulated heads and marks stand at the nominal places, within half a count. The 20″ of
    # u_places_arcsec are the uncertainty for a real table, with its mountings and marks.
    assert first["places_deg"] == pytest.approx(PLACES_DEG, abs=180.0 / SETTINGS.counts_per_rev)
    assert first["residual_arcsec"] < 1.6, "the parity has the rounding of one reading, 1.43″"
    next_turn = device.accepted_turn()
    assert next_turn["mean_off_arcsec"] < 1.0
    assert next_turn["active_arcsec"] < LINE_ARCSEC
    mean, head1 = device.record()
    assert abs(head1.line(BALLS.order)) == pytest.approx(balls_arcsec, abs=LINE_ARCSEC)
    for order in (BALLS.order, *range(1, 9)):
        assert abs(mean.line(order)) < LINE_ARCSEC, order
    assert abs(head1.line(1)) > 100.0

    # The firmware saves the set; after power off and on, a turn confirms the set with the same
    # words.
    records = re.compile(r"saved_record (\d+)")
    before = records.findall(device.firmware.send("status"))
    device.firmware.send("save")
    device.run_until(lambda: records.findall(device.firmware.send("status")) not in ([], before))
    flash = device.firmware.flash
    device.attach(*AXIS, HUB)
    device.instrument.reset()
    device.firmware.power_on(flash)
    assert device.accepted_turn()["mean_of_heads"] == 4
    assert "saved confirmed" in device.firmware.send("status")
    moved, _ = device.record()
    assert abs(moved.line(1) - mean.line(1)) < LINE_ARCSEC, "the hub moved by 7.6″"
    device.calibrate_alone(on=False)
    device.firmware.send("forget")


def mean_of(**changes: Any) -> Coefficients:
    """Return a mean of four heads at PLACES_DEG with a single lane; ``changes`` replace fields of
    the mean."""
    counts = SETTINGS.counts_per_rev
    offsets = tuple(round(place / 360.0 * counts * 16) for place in PLACES_DEG)
    mean = MeanSet((14634, 16406, 18396, 16100), offsets)
    lanes = Coefficients.from_harmonics([2], [0.1], [0.0], counts, 4)
    return replace(lanes, extension=Extension(mean=replace(mean, **changes)))


@pytest.mark.large
def test_a_mean_of_other_heads_is_refused(device: HeadsDevice) -> None:
    """The firmware refuses at once a set for three heads, a set with other delays and a set without
    the frame of head 3. After a turn it refuses a set in which one head's angle is wrong by
    0.1°."""
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


@pytest.mark.large
def test_faults_of_head_4_are_reported(device: HeadsDevice) -> None:
    """An illegal transition of head 4 raises the counter on the console and, if selected, switches
    the line drivers off."""
    device.firmware.send("set release_sources 128")
    device.turn_before(*AXIS)
    device.accepted_turn()
    assert "head4_illegals 0" in device.firmware.send("status")
    # An edge of the table within the filter's length can hide a pulse; therefore the test makes
    # five pulses instead of one.
    begin = device.instrument.clock + 100
    pulses = (PinFault(begin + 311 * n, 40, invert=HEAD4_A | HEAD4_B) for n in range(5))
    device.instrument.disturb(*pulses)
    device.firmware.run(clocks=2000)
    assert "head4_illegals 0" not in device.firmware.send("status")
    assert "head3_illegals 0" in device.firmware.send("status")
    assert "released head4" in device.firmware.send("status")
    assert "ok" in device.firmware.send("clear_output")
    device.firmware.send("set release_sources 0")


@pytest.mark.large
def test_a_dead_head_does_not_stop_the_calibration(device: HeadsDevice) -> None:
    """A head dies after the device has calibrated the mean; after ``rearm`` the device calibrates
    head 1, although the mean used the dead head."""
    device.calibrate_alone()
    device.firmware.send("forget")
    device.turn_before(*AXIS)
    assert device.accepted_turn()["mean_of_heads"] == 4
    turn_clocks = round(SETTINGS.counts_per_rev * 1.15)
    begin = device.instrument.clock + 100
    device.instrument.disturb(PinFault(begin, 40 * turn_clocks, low=HEAD3_A | HEAD3_B | HEAD3_Z))
    assert device.firmware.send("rearm").startswith("ok")
    first = len(device.firmware.telemetry)
    # One turn for the index of head 1, one for the wait for head 3, and one to two for the capture.
    device.firmware.run(clocks=5 * turn_clocks)
    lines = device.firmware.telemetry[first:]
    device.instrument.disturb()
    device.calibrate_alone(on=False)
    device.firmware.send("forget")
    assert [line for line in lines if "stuck_capture" in line["alarms"]] == []
    applied = [line for line in lines if line["result"] == "applied"]
    assert applied, lines
    assert "mean_of_heads" not in applied[0]
    assert "no_mean" in applied[0], "the reason why no mean is calibrated"


@pytest.mark.large
@pytest.mark.parametrize(
    ("name", "micrometres"),
    [
        ("bearing_ball_pass", 0.25),
        ("thermal_eccentricity", 2.0),
    ],
)
def test_hidden_with_four_heads(name: str, micrometres: float, tmp_path: Path) -> None:
    """With ``arctrue hidden EFFECT --heads 4``, head 1 shows the whole effect and the mean of the
    heads less than 0.25″."""
    file = tmp_path / "found.json"
    size = ["--lines", "1024", "--interpolation", "256", "--samples", "1600", "--lanes", "4"]
    done = CliRunner().invoke(main, ["hidden", name, "--heads", "4", *size, "--json", str(file)])
    assert done.exit_code == 0, done.output
    found = json.loads(file.read_text(encoding="utf-8"))
    expected = np.degrees(micrometres * 1e-6 / DISC_RADIUS_M) * 3600.0
    assert found["head1_arcsec"] == pytest.approx(expected, abs=LINE_ARCSEC)
    assert found["mean_arcsec"] < LINE_ARCSEC


def test_hidden_refuses_what_needs_other_heads() -> None:
    done = CliRunner().invoke(main, ["hidden", "bearing_ball_pass"])
    assert done.exit_code == 2
    assert "--heads 4" in done.output
    done = CliRunner().invoke(main, ["hidden", "hysteresis", "--heads", "4"])
    assert done.exit_code == 2
    assert "bearing_ball_pass, thermal_eccentricity" in done.output
