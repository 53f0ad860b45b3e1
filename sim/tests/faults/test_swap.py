"""Tests swaps of the banks at the worst moments: where the correction or its slope is largest, at
the index, and during a ramp."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from sim.tests.faults.conftest import MakeScene
from sim.tests.faults.scene import MEAN_ERROR, Scene
from sim.tests.faults.setting import (
    COUNTS,
    RAMP_RATE,
    TURN_CLOCKS,
    TURN_RAD,
    true_error_counts,
)

from arctrue.gateware.coefficients import Coefficients
from arctrue.gateware.correction_ramp import ramp_arcsec_s

PIPELINE_CLOCKS = 40
"""Clocks from a swap of the banks to the start of the ramp."""
_ANGLE = np.linspace(0.0, TURN_RAD, 4096, endpoint=False)
_ERROR = true_error_counts(_ANGLE) - MEAN_ERROR
PLACES = {
    "largest": float(_ANGLE[np.argmax(np.abs(_ERROR))]),
    "steepest": float(_ANGLE[np.argmax(np.abs(np.gradient(_ERROR)))]),
    "index": 0.0,
}


def nothing(active: Coefficients) -> Coefficients:
    return replace(active, amplitudes=np.zeros_like(active.amplitudes))


def swap(scene: Scene, bank: Coefficients) -> None:
    """Swap the banks by a command to the gateware, without the firmware's knowledge."""
    scene.instrument.write_coefficients(bank)
    scene.instrument.command("swap")


@pytest.mark.parametrize("slower", [1, pytest.param(6, marks=pytest.mark.large)])
@pytest.mark.parametrize(
    "place", ["largest", pytest.param("steepest", marks=pytest.mark.large), "index"]
)
def test_swap_of_all_or_nothing(make_scene: MakeScene, place: str, slower: int) -> None:
    """After a swap to a bank with zero amplitudes, and after the swap back, the correction is
    right. The test runs with two ramp rates: one is faster than the change of the table's error,
    the other is slower."""
    scene = make_scene(None, {"ramp_arcsec_s": ramp_arcsec_s(RAMP_RATE / slower, COUNTS)})
    scene.calibrate()
    assert (scene.ramp_lag > 0) == (slower > 1)
    good = scene.coefficients
    instrument = scene.instrument
    for bank in (nothing(good), good):
        instrument.write_coefficients(bank)
        turns = np.floor(instrument.true_angle_rad / TURN_RAD) + 1
        instrument.run_until(true_angle_rad=float(turns * TURN_RAD + PLACES[place]))
        scene.record()
        count = instrument.read("swap_count")
        instrument.command("swap")
        instrument.run(TURN_CLOCKS)
        assert instrument.read("swap_count") == count + 1
        assert instrument.read("status.ramp_busy") == 0
        swapped = scene.compare()
        assert swapped.illegal == 0
        # A step of the output beyond the following limit would set a flag.
        assert not scene.faults()
        assert swapped.worse < scene.clean_bound + scene.ramp_lag
    scene.recovers()


def test_swaps_in_the_ramp(scene: Scene) -> None:
    """The correction stays between zero and its full value during 150 swaps between the right
    amplitudes and zero amplitudes; each swap occurs before the ramp of the previous swap ends."""
    good = scene.coefficients
    instrument = scene.instrument
    for number in range(150):
        swap(scene, nothing(good) if number % 2 == 0 else good)
        instrument.run(PIPELINE_CLOCKS)
        assert instrument.read("status.ramp_busy") == 1
    instrument.run(TURN_CLOCKS // 2)
    hammered = scene.compare()
    assert hammered.illegal == 0
    assert not scene.faults()
    # The correction stays between zero and the full correction.
    assert hammered.worse < scene.clean_bound + scene.ramp_lag
    assert instrument.read("status.ramp_busy") == 0
    scene.recovers()


def test_half_a_bank_does_nothing(scene: Scene) -> None:
    """If the processor hangs after it has written half a bank, no swap follows, so the written
    words take no effect."""
    good = scene.coefficients
    wrong = replace(good, amplitudes=-good.amplitudes)
    half = wrong.amplitudes.size // 2
    scene.instrument.write_coefficients(
        replace(wrong, amplitudes=np.r_[wrong.amplitudes[:half], good.amplitudes[half:]])
    )
    scene.instrument.run(TURN_CLOCKS)
    scene.is_clean()
    scene.recovers()


def test_a_wrong_bank_is_seen(scene: Scene) -> None:
    """The comparison detects a wrong bank: a correction with the opposite sign doubles the
    error."""
    good = scene.coefficients
    swap(scene, replace(good, amplitudes=-good.amplitudes))
    scene.instrument.run(TURN_CLOCKS)
    scene.record()
    scene.instrument.run(TURN_CLOCKS)
    doubled = scene.compare()
    most = float(np.abs(_ERROR).max())
    assert abs(doubled.worse - most) < scene.clean_bound
    assert abs(doubled.most - 2 * most) < scene.clean_bound
