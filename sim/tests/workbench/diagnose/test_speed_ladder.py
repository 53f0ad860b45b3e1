"""Tests that a delay is named only if the offsets of the runs grow in proportion to the speed."""

from __future__ import annotations

import re
from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import NDArray

from arctrue.measurement import MeasurementSet, Reference, Table
from arctrue.workbench.diagnose.diagnosis import Diagnosis
from arctrue.workbench.diagnose.speed_ladder import departs_from_a_line
from arctrue.workbench.inference.forward.speed_levels import SpeedLevels, speed_levels
from arctrue.workbench.observations.build import observations_of
from tests.workbench.base_diagnosis import diagnosis_of

Float = NDArray[np.float64]
SPEEDS_DEG_S = (4.0, 8.0, 16.0, 24.0, 32.0)
NOISE, STEP_S = 0.3, 0.6


def _ladder(
    of_speed: Callable[[float], float], seed: int, zeros: float = 0.0, standing: int = 0
) -> Diagnosis:
    """Diagnose a reference with two runs of one turn at each of five speeds in each direction.

    The offset of a run is a function of its speed plus a random zero with the standard deviation
    ``zeros``. ``standing``: number of readings of a further run at standstill.
    """
    random = np.random.default_rng(seed)
    pieces, start_s, start_deg = [], 0.0, 0.0
    speeds = [sign * speed for _ in range(2) for speed in SPEEDS_DEG_S for sign in (1.0, -1.0)]
    for number, speed in enumerate(speeds):
        since = np.arange(int(360.0 / abs(speed) / STEP_S)) * STEP_S
        offset = of_speed(speed) + zeros * random.normal()
        pieces.append(
            np.column_stack(
                [
                    np.full(since.size, number),
                    start_s + since,
                    start_deg + speed * since,
                    np.full(since.size, np.sign(speed)),
                    np.full(since.size, offset),
                ]
            )
        )
        start_s += float(since[-1]) + 5.2
        start_deg += speed * float(since[-1])
    if standing:
        times = start_s + STEP_S * np.arange(standing)
        pieces.append(
            np.column_stack([
                np.full(standing, len(speeds)), times, np.full(standing, start_deg),
                np.full(standing, 1.0), np.zeros(standing),
            ])
        )  # fmt: skip
    run, time_s, target, direction, offset = np.vstack(pieces).T
    angle = np.radians(target)
    error = 8.0 * np.cos(angle + 0.3) + 2.0 * np.cos(2.0 * angle) + offset
    reference = Reference(
        target,
        error + random.normal(0.0, NOISE, run.size),
        run=run.astype(np.int64),
        time_s=time_s,
        direction=direction,
    )
    return diagnosis_of(MeasurementSet(Table(), None, reference))


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_a_reversal_above_a_speed_is_no_delay(seed: int) -> None:
    found = _ladder(lambda speed: 2.0 * np.sign(speed) * (abs(speed) > 20.0), seed)
    assert found.verdict == "unknown"
    assert found.named is None
    assert found.decision.resembles is not None
    assert found.decision.resembles.name == "latency"
    assert "do not grow in proportion to the speed" in (found.decision.unlike or "")
    said = " ".join(found.detections.sentences())
    assert "its own zero" not in said
    # The offsets at the speeds 24 and 32°/s are 2″; the mean of 50 readings with
    # 0.3″ of noise has u = 0.04″.
    values = re.search(r"±\((.*)\) at 4, 8, 16, 24, 32°/s", found.decision.unlike or "")
    assert values is not None
    offsets = [float(one.strip("″").replace("−", "-")) for one in values[1].split(", ")]
    assert offsets == pytest.approx([0.0, 0.0, 0.0, 2.0, 2.0], abs=0.15)


def test_a_run_at_standstill_does_not_make_a_delay_of_it() -> None:
    found = _ladder(lambda speed: 2.0 * np.sign(speed) * (abs(speed) > 20.0), 1, standing=50)
    assert found.named is None
    assert "do not grow in proportion to the speed" in (found.decision.unlike or "")


@pytest.mark.parametrize(("power", "seed"), [(2.0, 1), (0.5, 2)])
def test_a_power_of_the_speed_is_no_delay(power: float, seed: int) -> None:
    """The offset is 5″ at 32°/s. If a straight line and a step are fitted, 0.39″ RMS remain of an
    offset with the square of the speed, and 0.15″ RMS of an offset with its root."""
    found = _ladder(lambda speed: 5.0 * np.sign(speed) * (abs(speed) / 32.0) ** power, seed)
    assert found.verdict == "unknown"
    assert found.named is None
    values = re.search(r"±\((.*)\) at 4, 8, 16, 24, 32°/s", found.decision.unlike or "")
    assert values is not None
    offsets = [float(one.strip("″").replace("−", "-")) for one in values[1].split(", ")]
    expected = [5.0 * (speed / 32.0) ** power for speed in SPEEDS_DEG_S]
    assert offsets == pytest.approx(expected, abs=0.15)
    assert "A reversal error" not in " ".join(found.detections.sentences())


@pytest.mark.parametrize("zeros", [0.02, 0.1, 0.3])
@pytest.mark.parametrize("speeds", [(1, 2, 4, 8), (4, 8, 16, 24, 32), (1, 3, 10, 30, 100)])
def test_the_runs_of_a_delay_follow_a_straight_line(
    speeds: tuple[float, ...], zeros: float
) -> None:
    """The rule refuses at most the share SURE_P of true delays: none or one of 1,000 (P(two or
    more) < 0.005)."""
    random = np.random.default_rng(7)
    speed = np.repeat(np.array(speeds, dtype=float), 4) * np.tile([1.0, -1.0], 2 * len(speeds))
    level = np.searchsorted(np.array(speeds), np.abs(speed))
    refused = 0
    for _ in range(1000):
        means = 2.3 * speed / max(speeds) + random.normal(0.0, zeros, speed.size)
        levels = SpeedLevels(speed, means, level, np.ones(speed.size, dtype=bool))
        refused += departs_from_a_line(levels, 0.0)
    assert refused <= 1


@pytest.mark.parametrize(("seed", "zeros"), [(1, 0.0), (2, 0.3)])
def test_a_delay_keeps_its_name(seed: int, zeros: float) -> None:
    """A delay of 20 µs causes 2.3″ at 32°/s."""
    found = _ladder(lambda speed: -speed * 3600.0 * 20e-6, seed, zeros)
    assert found.named is not None
    assert found.named.name == "latency"


def test_a_delay_and_a_reversal_error_are_both_named() -> None:
    found = _ladder(lambda speed: -speed * 3600.0 * 20e-6 + 0.7 * np.sign(speed), 1)
    assert found.named is not None
    assert {found.named.name, *(item.name for item in found.further)} >= {"latency", "hysteresis"}


def test_zeros_of_runs_at_speeds_of_one_direction_follow_no_speed() -> None:
    """If a speed has only one run, any zero of this run agrees with an error of this speed. Such
    runs are therefore no evidence of an error that follows the speed."""
    zeros = {2.0: 40.0, 3.0: -7.0, 4.0: 4.0, 5.0: 19.0}
    speeds = [1.0, -1.0] * 3 + list(zeros)
    rows = 60
    run = np.repeat(np.arange(len(speeds)), rows)
    since = np.tile(0.6 * np.arange(rows), len(speeds))
    target = np.repeat(speeds, rows) * since
    noise = np.random.default_rng(1).normal(0.0, NOISE, run.size)
    offset = np.repeat([zeros.get(speed, 0.0) for speed in speeds], rows)
    reference = Reference(
        target,
        offset + noise,
        run=run,
        time_s=since + 100.0 * run,
        direction=np.repeat(np.sign(speeds), rows),
    )
    found = observations_of(MeasurementSet(Table(), None, reference)).reference
    assert found is not None
    assert found.speed_rad_s is not None
    assert speed_levels(found, offset + noise) is None
