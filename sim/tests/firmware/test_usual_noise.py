"""Tests that earlier turns affect a new turn as specified, through the usual noise and through the
running average."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from sim.tests.firmware.model_core import Firmware
from sim.tests.firmware.test_application import turn

NOISE_ARCSEC = 0.2
NOISY = 5.0
"""Noise of a bad turn as a multiple of the usual noise; the limit is 3."""
NOISY_TURNS_MOST = 5


def reason(running: Firmware, seed: int, noise: float) -> Any:
    return running.turn(turn(seed=seed, noise=noise))["reason"]


def test_noise_that_rises_slowly_becomes_the_usual_one(running: Firmware) -> None:
    """The usual noise, in which each turn has a weight of one fifth, follows noise that rises
    slowly. If the noise grows in steps of 1.6, no turn reaches 3 times the usual noise."""
    noise = NOISE_ARCSEC
    for seed in range(4):
        reason(running, seed, noise)
    for step in range(4):
        noise *= 1.6
        found = [reason(running, 10 * step + seed + 10, noise) for seed in range(8)]
        assert "noise" not in found, f"at {noise:.2f}″"
    assert noise > 6 * NOISE_ARCSEC
    # When the noise falls, the usual noise falls too.
    for seed in range(25):
        assert reason(running, 100 + seed, NOISE_ARCSEC) != "noise"
    assert reason(running, 200, NOISY * NOISE_ARCSEC) == "noise"


def test_only_noisy_turns_in_a_row_become_usual(running: Firmware) -> None:
    for seed in range(3):
        reason(running, seed, NOISE_ARCSEC)
    for seed in range(2 * NOISY_TURNS_MOST):
        assert reason(running, 10 + seed, NOISY * NOISE_ARCSEC) == "noise"
        assert reason(running, 50 + seed, NOISE_ARCSEC) != "noise"
    for seed in range(NOISY_TURNS_MOST - 1):
        assert reason(running, 100 + seed, NOISY * NOISE_ARCSEC) == "noise"
    assert reason(running, 110, NOISY * NOISE_ARCSEC) != "noise", (
        "the fifth noisy turn in a row is used"
    )


def test_the_average_is_quieter_than_a_turn(running: Firmware) -> None:
    """The mean of n turns with equal weights has 1/n of the variance of a turn; the uncertainty in
    the telemetry is smaller by the factor √n."""
    scatter = {}
    for keep in (0, 1):
        running.send(f"set keep {keep}")
        running.send("forget")
        for seed in range(16):
            telemetry = running.turn(turn(seed=300 + seed, noise=NOISE_ARCSEC))
        (order3,) = [item for item in telemetry["harmonics"] if item[0] == 3]
        scatter[keep] = order3[3]
        components = [item[1] for item in telemetry["harmonics"] if item[0] in (4, 5, 6)]
        scatter[keep, "found"] = float(np.sqrt(np.mean(np.square(components))))
    # The part of the uncertainty that the separation causes is not noise, so that averaging does
    # not reduce this part. Order 3 has no such part here.
    assert scatter[1] == pytest.approx(scatter[0] / 4, rel=0.1)
    assert scatter[1, "found"] < 0.6 * scatter[0, "found"]
