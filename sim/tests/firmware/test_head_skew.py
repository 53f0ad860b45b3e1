"""Tests of the delays of the heads that the firmware finds from two turns at different speeds,
against numpy (``arctrue.calibration.commissioning``) and against the simulated delays."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from sim.tests.firmware.calibrator import BOTH_INDICES_SEEN, verify
from sim.tests.firmware.library import firmware
from sim.tests.firmware.model_core import Firmware, ModelCore
from sim.tests.firmware.test_heads import ARCSEC, COUNTS, World, in_c, in_numpy
from sim.tests.firmware.test_own_sets import WORLD, FourHeadsCore, started

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
    """Add a turn with the offsets of the fit."""
    ffi, library = firmware()
    found = in_c(world)
    turn = ffi.new("struct skew_turn *")
    turn.speed, turn.heads = world.speed, world.heads
    turn.variance = 2.0 * (found.estimate.noise_arcsec * ARCSEC) ** 2 / world.samples
    for head in range(world.heads):
        turn.offset_rad[head] = found.found.geometry.offset_rad[head]
    library.head_skew_add(skew, turn)


@pytest.mark.parametrize("heads", [3, 4])
def test_c_equals_numpy_and_the_true_delays(heads: int) -> None:
    """From a forward and a backward turn, the delays equal those of numpy to 1e-4 ns and the true
    ones within 4u; u equals that of numpy and is below 10 ns (the limit of the device, with 0.1″ of
    noise and 3,000 samples at 90°/s). The bound of 1e-4 ns is the rounding of an offset of 4
    rad, 1e-15 rad, divided by 3 rad/s, with a margin."""
    ffi, _ = firmware()
    forward = Late(heads=heads, noise_arcsec=0.1)
    backward = replace(forward, speed=-SPEED, seed=2)
    skew = ffi.new("struct head_skew *")
    add(skew, forward)
    assert skew.heads == 0
    add(skew, backward)
    assert skew.heads == heads
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
    assert skew.u_ns < 10.0


def test_turns_at_one_speed_show_no_delay() -> None:
    """The delays do not change after a turn of unknown speed, or if the speeds of two turns differ
    by 20 % or less."""
    ffi, library = firmware()
    skew, turn = ffi.new("struct head_skew *"), ffi.new("struct skew_turn *")
    turn.heads = 2
    for speed, found in ((1.0, False), (1.19, False), (0.0, False), (2.0, False), (1.0, True)):
        turn.speed = speed
        turn.offset_rad[1] = 2.0 - 1e-6 * speed
        library.head_skew_add(skew, turn)
        assert skew.heads == (2 if found else 0), speed
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


@pytest.mark.parametrize("heads", [2, 3, 4])
@pytest.mark.parametrize("direction", [1, -1])
def test_offsets_are_means_over_the_reading(heads: int, direction: int) -> None:
    """The offsets equal the integral of each difference over head 1's reading, by linear
    interpolation on 40 times finer steps, to 0.002 arcsec. A mean over the samples differs by 0.5″
    or more, because the speed swings by 5 %.

    The bound is the rounding of a count in the 3,000 samples of both heads, 0.077″ · √(2/12/3000) =
    0.0006″, times three.
    """
    ffi, library = firmware()
    world = Late(heads=heads, swing=0.05, speed=direction * SPEED)
    made, counts = world.capture(), world.counts()
    _, turn, _ = verify(made)
    found = ffi.new("double[4]")
    library.capture_offsets(made.capture, turn, heads, found)
    one = counts[0].astype(float)
    apart = (counts - counts[0]).astype(float)
    order = np.argsort(one)
    periodic = np.concatenate((one[order] - COUNTS, one[order], one[order] + COUNTS))
    even = one.min() + np.arange(40 * one.size) * (COUNTS / 40 / one.size)
    expected = [
        np.interp(even, periodic, np.tile(row[order], 3)).mean() * 2.0 * np.pi / COUNTS
        for row in apart
    ]
    off = np.angle(np.exp(1j * (np.array(list(found)[:heads]) - expected))) / ARCSEC
    assert np.abs(off).max() < 0.002
    plain = (apart.mean(axis=1) * 2.0 * np.pi / COUNTS - expected) / ARCSEC
    assert np.abs(plain).max() > 0.5


def sent(running: Firmware, world: Late) -> dict[str, Any]:
    running.send("telemetry on")
    return running.turn(world.counts(), BOTH_INDICES_SEEN)


@pytest.mark.parametrize("method", [0, 1])
def test_two_heads_show_the_delay_of_head_2(method: int) -> None:
    """A core with two heads: a turn in each direction shows the delay of head 2 within 4u, by both
    methods of calibration and although the speed swings differently in the two directions."""
    running = Firmware(ModelCore())
    running.library.application_start(running.application)
    running.core.see_index()
    running.send("set orders 32")
    running.send(f"set method {method}")
    running.core.see_index()
    running.step()
    period = running.application.parameters.sample_period
    speed = 2.0 * np.pi / (3000 * period / CLOCK_HZ)
    world = Late(heads=2, noise_arcsec=0.1, speed=speed, swing=0.002)
    assert "late_ns" not in sent(running, world)
    telemetry = sent(running, replace(world, speed=-speed, swing=-0.001, seed=2))
    assert telemetry["reason"] in ("none", "not_better"), telemetry
    late, u = telemetry["late_ns"], telemetry["u_late_ns"]
    assert len(late) == 2
    assert 0.0 < u < 20.0
    assert abs(late[1] - LATE_NS[1]) < 4.0 * u
    assert float(running.status("head2_late_ns")[0]) == pytest.approx(late[1], abs=1e-6)


@pytest.mark.parametrize("works", [4, 2])
def test_the_delays_are_found_where_head_1_is_the_output(works: int) -> None:
    """A core with four heads whose places are not set corrects head 1, and still shows the delays.
    If head 3 stands still, only the delay of head 2 is stated."""
    running = Firmware(FourHeadsCore())
    running.library.application_start(running.application)
    running.core.see_index()
    running.send("set orders 32")
    running.send("set separation_deg 64.3")
    running.core.see_index()
    running.step()
    period = running.application.parameters.sample_period
    speed = 2.0 * np.pi / (3000 * period / CLOCK_HZ)
    world = Late(noise_arcsec=0.1, speed=speed)

    def turn(one: Late) -> dict[str, Any]:
        counts = one.counts()
        if works == 2:
            counts[2] = counts[2, 0]
        return running.turn(counts)

    running.send("telemetry on")
    turn(world)
    telemetry = turn(replace(world, speed=-speed, seed=2))
    assert "mean_of_heads" not in telemetry
    late, u = np.array(telemetry["late_ns"]), telemetry["u_late_ns"]
    assert late.size == works
    assert np.abs(late - LATE_NS[:works]).max() < 4.0 * u


@dataclass(frozen=True)
class Coloured(Late):
    """Each sample of the noise is the sum of two white ones, divided by √2. The variance of a
    sample stays the same, that of a mean over many samples doubles."""

    def noise_rad(self, random: np.random.Generator, samples: int) -> Float:
        white = super().noise_rad(random, samples + 1)
        return (white[1:] + white[:-1]) / np.sqrt(2.0)


@pytest.mark.parametrize(("kind", "colour"), [(Late, 1.0), (Coloured, 2.0)])
@pytest.mark.parametrize("of_mean", [True, False])
def test_u_of_a_delay_follows_from_the_noise_of_two_heads(
    kind: type[Late], colour: float, of_mean: bool
) -> None:
    """u is √(2σ²c/n₁ + 2σ²c/n₂)/|ω₁ − ω₂|, where σ is the noise of a head, c its colour, and the
    turns have n samples and the speed ω, with and without a mean of the heads.

    The bound of 10 %: the firmware takes σ²c of a turn from 96 Fourier lines, so that σ√c scatters
    by 5 %, u by 4 %; a wrong factor of 2 under the root changes u by 29 % or more."""
    noise = 0.1
    world = kind(noise_arcsec=noise, late_arcsec=(0.0,) * 4)
    running = started(world)
    if not of_mean:
        running.send("set head3_deg 0")
        running.core.see_index()
        running.step()
    period = running.application.parameters.sample_period
    slow = 2.0 * np.pi / (world.samples * period / CLOCK_HZ)
    fast = replace(world, samples=world.samples // 2, speed=-2.0 * slow, seed=2)
    running.turn(replace(world, speed=slow).counts())
    telemetry = running.turn(fast.counts())
    assert ("mean_of_heads" in telemetry) == of_mean
    variance = 2.0 * colour * (noise * ARCSEC) ** 2 * (1.0 / world.samples + 1.0 / fast.samples)
    expected = np.sqrt(variance) / (3.0 * slow) * 1e9
    assert telemetry["u_late_ns"] == pytest.approx(expected, rel=0.1)
