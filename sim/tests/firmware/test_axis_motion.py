"""Tests of the motion of the axis that does not repeat from turn to turn: the C code against numpy
(``arctrue.calibration.axis_asynchronous``), and both against a simulated axis.

The readings come from the simulation of test_heads.py, with turns that follow each other.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import pytest
from numpy.typing import NDArray
from sim.tests.firmware.calibrator import verify
from sim.tests.firmware.library import firmware
from sim.tests.firmware.test_heads import COUNTS, World, settings_in_c
from sim.tests.firmware.test_own_sets import WORLD, started

from arctrue.calibration.axis_asynchronous import KEEP, Asynchronous, AxisMean, add_turn
from arctrue.calibration.heads_on_device import heads_on_device

Float = NDArray[np.float64]
ORDERS = 32
SYNCHRONOUS = ((1, 0.0, 0.3 + 0.1j), (2, 0.4, 0.2j), (3, 0.1, 0.3), (7, 0.0, 0.15))
BALL_PASS = (4.37, 0.7, 0.2j)
"""Order, forward circle and backward circle; the RMS over both directions is √(0.7² + 0.2²)″."""
CAGE = (0.41, 0.3, 0.0)


@dataclass(frozen=True)
class Turning(World):
    """A table that keeps turning; the axis motion continues from turn to turn."""

    turn: int = 0

    def theta(self) -> Float:
        return super().theta() + 2.0 * np.pi * self.turn


def turned(world: Turning, turns: int) -> list[Turning]:
    return [replace(world, turn=turn, seed=100 * world.seed + turn) for turn in range(turns)]


@dataclass(frozen=True)
class InC:
    """Result of the C code for one turn."""

    stated: bool
    arcsec: float
    u_arcsec: float


def in_c(worlds: list[Turning], orders: int = ORDERS) -> list[InC]:
    """Return the C code's results, one per turn."""
    ffi, library = firmware()
    mean, results = ffi.new("struct axis_mean *"), []
    workspace = ffi.new("struct heads_workspace *")
    for world in worlds:
        capture = world.capture()
        reason, turn, _ = verify(capture, orders)
        assert reason == "none", reason
        settings = settings_in_c(world, orders)
        settings.axis = mean
        found, estimate = ffi.new("struct heads_found *"), ffi.new("struct estimate *")
        code = library.heads_estimate(workspace, capture.capture, turn, settings, found, estimate)
        assert code == 0, code
        of_turn = found.asynchronous
        # Copies: the memory of the structure is free after this pass of the loop.
        results.append(InC(bool(of_turn.stated), of_turn.arcsec, of_turn.u_arcsec))
    return results


def in_numpy(worlds: list[Turning], orders: int = ORDERS) -> list[Asynchronous | None]:
    mean: AxisMean | None = None
    results = []
    for world in worlds:
        found = heads_on_device(world.turns(), COUNTS, world.nominal_rad, orders)
        assert found.axis is not None
        mean, result = add_turn(found.axis, mean)
        results.append(result)
    return results


@pytest.mark.parametrize(
    "world",
    [
        pytest.param(Turning(samples=1000, axis=SYNCHRONOUS), id="repeats"),
        pytest.param(
            Turning(
                samples=1000,
                noise_arcsec=0.2,
                swing=0.05,
                ratios=(1.0, 1.001, 0.999, 1.0005),
                axis=(*SYNCHRONOUS, BALL_PASS, CAGE),
            ),
            id="noise-swing",
        ),
    ],
)
def test_c_equals_numpy(world: Turning) -> None:
    """The results agree to 1e-9 of the disc's largest value, 144″. A result near 0 is compared by
    its square, because it is the square root of a difference."""
    worlds = turned(world, 4)
    for c, numpy in zip(in_c(worlds), in_numpy(worlds), strict=True):
        assert c.stated == (numpy is not None)
        if numpy is not None:
            assert c.arcsec**2 == pytest.approx(numpy.arcsec**2, abs=144e-9)
            assert c.u_arcsec == pytest.approx(numpy.u_arcsec, rel=1e-3)


def of_phases(turns: int) -> float:
    """Return the expected square of the result, after ``turns`` former turns, divided by the true
    square."""
    former = np.arange(1, turns + 1)
    weights = KEEP**former / np.sum(KEEP**former)
    kept = np.sum(weights * np.exp(2j * np.pi * BALL_PASS[0] * former))
    return float(abs(1.0 - kept) ** 2 / (1.0 + np.sum(weights**2)))


def test_ball_pass_has_its_true_size() -> None:
    """The result for a ball pass of known size is right, with motion that repeats, noise of 0.2″
    and an uneven speed.

    In every turn the ball pass is multiplied by the same phase factor z. The mean over former
    turns, with the weights w, therefore contains m = Σ w·z^k times the ball pass. The result has
    the expected square true²·|1 − m|²/(1 + Σ w²), on average 1.026·true². The mean of 20 results
    agrees within 4 standard deviations of this mean. 2u covers 95 % of the errors: at least 15 of
    20 results are covered, except with a probability of 3 in 1000 (binomial).
    """
    axis = (*SYNCHRONOUS, BALL_PASS)
    world = Turning(samples=1000, noise_arcsec=0.2, swing=0.05, axis=axis, seed=5)
    true = np.hypot(0.7, 0.2)
    results = in_c(turned(world, 40))[20:]
    found = np.array([result.arcsec for result in results])
    u = np.array([result.u_arcsec for result in results])
    expected = true**2 * np.mean([of_phases(turns) for turns in range(20, 40)])
    spread = np.std(found**2) / np.sqrt(found.size)
    assert spread < 0.01 * true**2
    assert abs(np.mean(found**2) - expected) < 4.0 * spread
    assert np.sum(np.abs(found - true) < 2.0 * u) >= 15


def test_motion_that_repeats_is_not_counted() -> None:
    """The axis has 0.6″ of motion that repeats.

    The square of the true value is 0. From the second turn on, x² is less than twice its
    uncertainty (x + u)² − x² in at least 15 of 19 turns (binomial with 97.5 %: fewer in 1 of 10,000
    tests). The bound of u is the expected 0.05″ at 0.2″ of noise, doubled for the second turn,
    whose mean is one turn.
    """
    world = Turning(samples=1000, noise_arcsec=0.2, axis=SYNCHRONOUS, seed=7)
    results = in_c(turned(world, 20))
    assert not results[0].stated, "the first turn has no former turn"
    found = np.array([one.arcsec for one in results[1:]])
    u = np.array([one.u_arcsec for one in results[1:]])
    assert np.all(u < 0.11)
    assert np.sum(found**2 < 2.0 * ((found + u) ** 2 - found**2)) >= 15


@pytest.mark.parametrize("heads", [2, 3])
def test_fewer_heads_state_none(heads: int) -> None:
    """With fewer than four heads the result is not stated: three heads leave no equation for the
    noise, and two heads do not show the motion."""
    world = Turning(heads=heads, samples=1000, noise_arcsec=0.2, axis=(BALL_PASS,))
    assert not any(result.stated for result in in_c(turned(world, 3)))


def test_telemetry_states_it_from_the_second_turn_on() -> None:
    """The line of each turn has value and u. After `forget` or a changed place the mean begins
    anew, because the former turns no longer count."""
    made = started(WORLD)
    keys = {"axis_asynchronous_arcsec", "u_axis_asynchronous_arcsec"}

    def stated(turn: int) -> set[str]:
        return keys & made.turn(replace(WORLD, seed=turn).counts()).keys()

    assert (stated(1), stated(2)) == (set(), keys)
    made.send("forget")
    assert (stated(3), stated(4)) == (set(), keys)
    made.send(f"set head3_deg {np.degrees(WORLD.nominal_rad[2]) + 0.001:.6f}")
    assert (stated(5), stated(6)) == (set(), keys)
