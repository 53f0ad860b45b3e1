"""Tests that turns are right when 32-bit positions wrap, although 2³² is not a multiple of the
counts per turn."""

from __future__ import annotations

import io
from typing import Any

import numpy as np
import pytest
from sim.tests.calibration.synthetic import Disc
from sim.tests.firmware.model_core import Firmware, ModelCore
from sim.tests.firmware.test_application import active_coefficients
from sim.tests.firmware.test_estimates import counts_of

ORDERS = {1: (150.0, 0.4), 2: (6.0, 4.2), 3: (1.2, 2.9)}
SAMPLES = 600
STEP_TURNS = 1.0 / SAMPLES
WRAP = 1 << 31
"""First count that a signed 32-bit word cannot hold."""
NUMBER_OF_WRAPS = [0, 1, 5]
"""Numbers of complete wraps before the wrap that is tested."""
WRAPS_AT_TURNS = {
    "before the bank": -0.01,
    "in its first step": 0.5 * STEP_TURNS,
    "in the middle": 0.5,
    "after the bank, before the firmware reads it": 1.2,
    "not yet": 1.6,
}
"""Travel in turns from the first sample to the wrap of the position word."""
LOOKED_AT_TURNS = 1.4
NOISE_ARCSEC = 0.1
LEFT_ARCSEC = 1.0
"""Largest error in arcseconds. Noise of 0.1″ leaves 0.3″ at gains below 20; a wrong turn would
leave 13″ or more."""
COUNTS_PER_REV = [10_000_000, 3_600_000]


def started(counts_per_rev: int, method: int) -> Firmware:
    firmware = Firmware(ModelCore())
    firmware.library.application_start(firmware.application)
    firmware.send(f"set counts_per_rev {counts_per_rev}")
    firmware.send(f"set method {method}")
    firmware.core.see_index()
    firmware.step()
    assert firmware.phase == "capture"
    return firmware


def turn_at_wrap(disc: Disc, direction: int, wrap_at_turns: float, wraps: int) -> Any:
    """Return counts (2, n) of a turn near the count at which the word of head 1 wraps.

    Head 1 reaches this count ``wrap_at_turns`` turns after the first sample; it is wrap number
    ``wraps`` + 1 in ``direction``.
    """
    turn = disc.counts_per_rev
    # ``first`` is the count that the first sample must have; ``start`` is nearly its true angle.
    first = direction * (WRAP * (1 + 2 * wraps) - round(wrap_at_turns * turn))
    start = 2.0 * np.pi * (first % turn) / turn
    counts = counts_of(disc, NOISE_ARCSEC, 1, samples=SAMPLES, direction=direction, start=start)
    return counts + (first - first % turn)


def left_arcsec(firmware: Firmware, disc: Disc) -> float:
    """Return the largest error that the active coefficients leave, in arcseconds."""
    turn = disc.counts_per_rev
    reading = np.arange(0, turn, turn // 997)
    angle = reading * (2.0 * np.pi / turn)
    wrong = np.rad2deg(angle - disc.true_angle(angle)) * 3600.0
    applied = active_coefficients(firmware.core, turn).error_counts(reading) * (1_296_000 / turn)
    return float(np.abs(wrong - applied).max())


@pytest.mark.parametrize("wraps", NUMBER_OF_WRAPS)
@pytest.mark.parametrize("where", WRAPS_AT_TURNS)
@pytest.mark.parametrize("direction", [1, -1])
@pytest.mark.parametrize("counts_per_rev", COUNTS_PER_REV)
def test_a_turn_at_a_wrap_is_applied_at_its_place(
    counts_per_rev: int, direction: int, where: str, wraps: int
) -> None:
    disc = Disc(ORDERS, counts_per_rev=counts_per_rev)
    firmware = started(counts_per_rev, method=wraps % 2)
    counts = turn_at_wrap(disc, direction, WRAPS_AT_TURNS[where], wraps)
    travel = direction * round((LOOKED_AT_TURNS - 1.0) * counts_per_rev)
    firmware.core.hand_over(counts, travel=travel)
    firmware.step(3)
    assert firmware.application.report.result == firmware.library.TURN_APPLIED
    assert left_arcsec(firmware, disc) < LEFT_ARCSEC


@pytest.mark.parametrize("wraps", NUMBER_OF_WRAPS)
@pytest.mark.parametrize("where", WRAPS_AT_TURNS)
@pytest.mark.parametrize("direction", [1, -1])
@pytest.mark.parametrize("counts_per_rev", COUNTS_PER_REV)
def test_a_dump_at_a_wrap_has_angles(
    counts_per_rev: int, direction: int, where: str, wraps: int
) -> None:
    """The dump continues counting across the wrap; modulo the turn it shows the angle of both
    heads."""
    disc = Disc(ORDERS, counts_per_rev=counts_per_rev)
    firmware = started(counts_per_rev, method=1)
    firmware.send("dump")
    counts = turn_at_wrap(disc, direction, WRAPS_AT_TURNS[where], wraps)
    firmware.core.hand_over(counts, travel=direction * counts_per_rev // 3)
    said = firmware.step(3 + counts.shape[1] // 8).splitlines()
    rows = said[said.index("row,head1_counts,head2_counts,crc") + 1 : said.index("end of dump")]
    dumped = np.loadtxt(io.StringIO("\n".join(rows)), delimiter=",", usecols=(1, 2)).T
    np.testing.assert_array_equal(dumped - dumped[0, 0], counts - counts[0, 0])
    assert (dumped[0, 0] - counts[0, 0]) % counts_per_rev == 0
