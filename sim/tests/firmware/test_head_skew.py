"""Tests of the delays of the heads that the firmware finds from two turns at different speeds,
against numpy (``arctrue.calibration.commissioning``) and against the simulated delays."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from sim.tests.firmware.library import firmware
from sim.tests.firmware.test_heads import ARCSEC, World, in_c, in_numpy
from sim.tests.firmware.test_own_sets import WORLD, started

from arctrue.calibration.commissioning import skew_of

Float = NDArray[np.float64]
LATE_NS = (0.0, 40.0, -25.0, 90.0)
SPEED = np.pi / 2
"""90°/s."""
CLOCK_HZ = 100e6


@dataclass(frozen=True)
class Late(World):
    """A head with the delay τ reads θ(t − τ)."""

    speed: float = SPEED

    @property
    def true_rad(self) -> Float:
        late = np.array(LATE_NS[: self.heads]) * 1e-9
        return super().true_rad - self.speed * late

    def theta(self) -> Float:
        return super().theta() if self.speed > 0.0 else -super().theta()


def add(skew: Any, world: Late) -> None:
    """Add a turn as calibrate_mean.c does."""
    ffi, library = firmware()
    found = in_c(world)
    turn = ffi.new("struct skew_turn *")
    turn.speed = world.speed
    turn.variance = 2.0 * (found.estimate.noise_arcsec * ARCSEC) ** 2 / world.samples
    for head in range(world.heads):
        turn.offset_rad[head] = found.found.geometry.offset_rad[head]
    library.head_skew_add(skew, turn)


@pytest.mark.parametrize("heads", [3, 4])
def test_c_equals_numpy_and_the_true_delays(heads: int) -> None:
    """From a forward and a backward turn, the delays equal those of numpy to 1e-4 ns and the true
    ones within 4u; u equals that of numpy. The bound of 1e-4 ns is the rounding of an offset of 4
    rad, 1e-15 rad, divided by 3 rad/s, with a margin."""
    ffi, _ = firmware()
    forward = Late(heads=heads, noise_arcsec=0.1)
    backward = replace(forward, speed=-SPEED, seed=2)
    skew = ffi.new("struct head_skew *")
    add(skew, forward)
    assert not skew.found
    add(skew, backward)
    assert skew.found
    numpy = skew_of(
        in_numpy(forward),
        in_numpy(backward),
        (SPEED, -SPEED),
        (forward.samples, backward.samples),
        CLOCK_HZ,
        (0,) * heads,
    )
    late = np.array([skew.late_ns[head] for head in range(heads)])
    assert late == pytest.approx(numpy.late_ns, abs=1e-4)
    assert skew.u_ns == pytest.approx(numpy.u_ns[1], rel=1e-6)
    assert np.abs(late - LATE_NS[:heads]).max() < 4.0 * skew.u_ns


def test_turns_at_one_speed_show_no_delay() -> None:
    """The delays do not change after a turn of unknown speed, or if the speeds of two turns differ
    by 20 % or less."""
    ffi, library = firmware()
    skew, turn = ffi.new("struct head_skew *"), ffi.new("struct skew_turn *")
    for speed, found in ((1.0, False), (1.19, False), (0.0, False), (2.0, False), (1.0, True)):
        turn.speed = speed
        turn.offset_rad[1] = 2.0 - 1e-6 * speed
        library.head_skew_add(skew, turn)
        assert skew.found == found, speed
    assert skew.late_ns[1] == pytest.approx(1000.0, rel=1e-6)
    library.head_skew_add(skew, turn)
    assert skew.late_ns[1] == pytest.approx(1000.0, rel=1e-6)


def test_console_and_telemetry_state_the_delays() -> None:
    """The second turn has half as many samples in the same period, so it is twice as fast."""
    made = started(WORLD)
    period = made.application.parameters.sample_period
    slow = 2.0 * np.pi / (WORLD.samples * period / CLOCK_HZ)
    fast = replace(
        WORLD,
        samples=WORLD.samples // 2,
        off_arcsec=tuple(
            off - slow * late * 1e-9 / ARCSEC
            for off, late in zip(WORLD.off_arcsec, LATE_NS, strict=True)
        ),
        seed=2,
    )
    assert "late_ns" not in made.turn(WORLD.counts())
    assert "late_ns" not in made.send("status")
    telemetry = made.turn(fast.counts())
    late, u = np.array(telemetry["late_ns"]), telemetry["u_late_ns"]
    assert np.abs(late - LATE_NS).max() < 4.0 * u + 1e-3
    words = dict(line.split(" ", 1) for line in made.send("status").splitlines() if " " in line)
    assert float(words["head4_late_ns"]) == pytest.approx(late[3], abs=1e-6)
    assert float(words["u_late_ns"]) == pytest.approx(u, abs=1e-9)
    made.send("rearm")
    assert "late_ns" not in made.send("status")
