"""Tests that a calibrated device with four heads leaves out a head that fails while the table
turns.

Table, firmware and gateware are those of test_four_heads.py; the core is built with FAILOVER.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest
from sim.tests.instrument.test_four_heads import AXIS, LINE_ARCSEC, SETTINGS

from arctrue.calibration.heads_calibration import MeanSettings, calibrate_mean
from arctrue.instrument import HEAD3_A, HEAD3_B, HEAD3_Z, PinFault
from arctrue.studies.heads.device import HeadsDevice
from arctrue.studies.heads.shown import BALLS

HEAD = 3
SLIP_COUNTS = 4000
STEP_COUNTS = 200
"""Limit in counts above which a step is detected, for a table that makes 0.43 of a turn in the 2¹⁷
clocks of a comparison.

Eccentricity of 142″ then changes the difference of two heads by 58 counts in either direction. The
preset of 32 counts is for 90°/s at 100 MHz.
"""
CLOCKS_A_SLIPPED_COUNT = 4
"""Clocks per count of the added edges, which are slower than the edges of the table. Added edges
that coincide with edges of the table are illegal transitions."""


@pytest.fixture(scope="module")
def device() -> Iterator[HeadsDevice]:
    with HeadsDevice(SETTINGS, failover=True) as made:
        made.firmware.send(f"set failover_step_counts {STEP_COUNTS}")
        made.turn_before(*AXIS)
        made.accepted_turn()
        settings = MeanSettings(most_order=8, lanes=SETTINGS.lanes, motion=(1, 2, 3))
        found = calibrate_mean(made.dumped(), settings)
        assert made.load(found.coefficients) == "load active"
        made.run_until(lambda: "failover on" in made.firmware.send("status"), "the swap")
        yield made


def alarm_of(device: HeadsDevice, first: int) -> dict[str, Any]:
    """Return the first line of telemetry, among those from ``first`` on, that has the alarm of a
    head."""
    return next(
        line for line in device.firmware.telemetry[first:] if "head_left_out" in line["alarms"]
    )


def left_out(device: HeadsDevice, first: int) -> bool:
    return any("head_left_out" in line["alarms"] for line in device.firmware.telemetry[first:])


def back_in(device: HeadsDevice) -> None:
    assert device.firmware.send(f"come_back {HEAD}").startswith("ok")
    device.run_until(lambda: not device.instrument.read("heads_status.left_out"), "the index")
    assert device.instrument.read("heads_status.set") == 0


@pytest.mark.large
def test_a_dead_head_is_left_out_and_comes_back(device: HeadsDevice) -> None:
    """The firmware leaves out head 3 while its pins are low for five turns; the output then follows
    the mean of the other heads, without ball motion."""
    firmware, instrument = device.firmware, device.instrument
    first = len(firmware.telemetry)
    turn_clocks = round(SETTINGS.counts_per_rev * 1.15)
    instrument.disturb(
        PinFault(instrument.clock + 100, 5 * turn_clocks, low=HEAD3_A | HEAD3_B | HEAD3_Z)
    )
    device.run_until(lambda: left_out(device, first), "the failure")
    telemetry = alarm_of(device, first)
    assert telemetry["left_out"] == [HEAD]
    status = instrument.read_fields("heads_status")
    assert (status["left_out"], status["set"]) == (1 << HEAD - 1, HEAD)
    assert f"left_out {HEAD}" in firmware.send("status")
    output, head1 = device.record()
    balls_arcsec = abs(head1.line(BALLS.order))
    assert abs(output.line(BALLS.order)) < LINE_ARCSEC < 0.5 * balls_arcsec

    instrument.disturb()
    back_in(device)
    output, _ = device.record()
    assert abs(output.line(BALLS.order)) < LINE_ARCSEC


@pytest.mark.large
def test_a_head_that_slips_by_4000_counts_is_left_out(device: HeadsDevice) -> None:
    """The firmware leaves out head 3, which counts 4,000 counts too many because of added pulses,
    and later uses it again."""
    firmware, instrument = device.firmware, device.instrument
    first = len(firmware.telemetry)
    begin = instrument.clock + 100
    period = 4 * CLOCKS_A_SLIPPED_COUNT
    cycles = range(SLIP_COUNTS // 4)
    pulses = [PinFault(begin + period * n, period // 2, invert=HEAD3_A) for n in cycles]
    pulses += [
        PinFault(begin + period * n + period // 4, period // 2, invert=HEAD3_B) for n in cycles
    ]
    instrument.disturb(*pulses)
    device.run_until(lambda: left_out(device, first), "the failure")
    assert alarm_of(device, first)["left_out"] == [HEAD]
    instrument.disturb()
    output, _ = device.record()
    assert np.abs(output.error_arcsec).max() < 4 * LINE_ARCSEC + 3 * 4.94
    back_in(device)


@pytest.mark.large
def test_the_device_makes_its_own_sets() -> None:
    """The device calibrates four heads without a loaded file; then head 3 fails while the table
    turns.

    Afterwards the mean of three heads removes the ball motion and the disc's orders from the
    output. With the weights w of three heads √Σw² is 0.82 instead of 0.5, so that the tolerance of
    an amplitude is 0.82/0.5 times as large.
    """
    three = LINE_ARCSEC * 0.82 / 0.5
    with HeadsDevice(SETTINGS, failover=True) as device:
        device.firmware.send(f"set failover_step_counts {STEP_COUNTS}")
        device.calibrate_alone()
        device.turn_before(*AXIS)
        assert device.accepted_turn()["mean_of_heads"] == 4
        device.run_until(lambda: "failover on" in device.firmware.send("status"), "the swap")
        status = device.firmware.send("status")
        assert [line for line in status.splitlines() if "set_without_head" in line] == [
            f"set_without_head {head}" for head in range(1, 5)
        ]
        before, _ = device.record()
        first = len(device.firmware.telemetry)
        five_turns = 5 * round(SETTINGS.counts_per_rev * 1.15)
        dead = HEAD3_A | HEAD3_B | HEAD3_Z
        device.instrument.disturb(PinFault(device.instrument.clock + 100, five_turns, low=dead))
        device.run_until(lambda: left_out(device, first), "the failure")
        assert alarm_of(device, first)["left_out"] == [HEAD]
        assert device.instrument.read_fields("heads_status")["set"] == HEAD
        output, head1 = device.record()
        assert abs(head1.line(1)) > 100.0
        assert abs(output.line(BALLS.order)) < three < 0.5 * abs(head1.line(BALLS.order))
        for order in range(1, 9):
            assert abs(output.line(order) - before.line(order)) < three, order
