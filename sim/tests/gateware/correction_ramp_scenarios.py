"""Defines inputs of the correction ramp in each clock, for the tests of its model and its VHDL."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from arctrue.generated.number_formats import CORRECTION_FRACTION, PAIR_FRACTION

COUNT = 1 << PAIR_FRACTION
UNIT = 1 << (PAIR_FRACTION - CORRECTION_FRACTION)
RATE_ONE = 1 << 24
RATE_MAX = 2**32 - 1


@dataclass(frozen=True)
class RampScenario:
    """Inputs of the ramp: ``correction`` (2⁻ᶠ count, F = 27) and ``marker`` have a value per clock;
    ``limit`` is in counts."""

    name: str
    correction: NDArray[np.int64]
    marker: NDArray[np.bool_]
    limit: int
    ramp_rate: int
    inserted: NDArray[np.int64] = field(default_factory=lambda: np.zeros(0, dtype=np.int64))
    """Counts by which the reading jumps in each clock with a marker, shape (clocks,); empty if the
    reading never jumps."""
    ramp_acceleration: int = 0
    """Largest acceleration of the ramp in 2⁻⁵⁹ count per clock²; 0 means no limit."""

    def __str__(self) -> str:
        return self.name


def _markers(clocks: int, *at: int) -> NDArray[np.bool_]:
    marker = np.zeros(clocks, dtype=np.bool_)
    marker[list(at)] = True
    return marker


def _steps(*parts: tuple[int, int]) -> NDArray[np.int64]:
    """Return a correction per clock from pairs of a level in 2⁻ᶠ count and the number of clocks for
    which it lasts."""
    return np.concatenate([np.full(clocks, level, dtype=np.int64) for level, clocks in parts])


def _sine(clocks: int, amplitude_counts: float, period: float) -> NDArray[np.int64]:
    phase = 2.0 * np.pi * np.arange(clocks) / period
    return np.rint(amplitude_counts * COUNT * np.sin(phase)).astype(np.int64)


def _smooth(
    name: str, counts: float, ticks: int, rate: int, acceleration: int, *at: int
) -> RampScenario:
    """Return a scenario with limited acceleration and a step by ``counts``. A tick has 256 clocks;
    at each of the ticks ``at`` the correction steps to another level, with a marker."""
    clocks = 256 * ticks
    level = np.zeros(clocks, dtype=np.int64)
    level[10:] = round(counts * COUNT)
    markers = [10]
    for number, tick in enumerate(at):
        level[256 * tick :] = round(counts * COUNT * (-0.3, 0.9, 0.05)[number % 3])
        markers.append(256 * tick)
    return RampScenario(
        name,
        level,
        _markers(clocks, *markers),
        2**19 - 1,
        rate,
        ramp_acceleration=acceleration,
    )


def _marked_every_tick(counts: float, first: int, phase: int) -> RampScenario:
    """Return a scenario with one step of ε. From tick ``first`` on, clock ``phase`` of each 256
    clocks has a marker without a change of ε, except in the last 40 ticks."""
    clocks = 256 * 120
    level = np.zeros(clocks, dtype=np.int64)
    level[10:] = round(counts * COUNT)
    return RampScenario(
        f"smooth, {counts} counts, a marker in clock {phase} of each 256",
        level,
        _markers(clocks, 10, *range(256 * first + phase, clocks - 256 * 40, 256)),
        2**19 - 1,
        RATE_MAX,
        ramp_acceleration=2**32 - 1,
    )


def _insertions(seed: int, clocks: int, most: int) -> RampScenario:
    rng = np.random.default_rng(seed)
    return RampScenario(
        f"inserted counts, up to {most}",
        _sine(clocks, 50.0, 710.0),
        rng.random(clocks) < 0.01,
        2**19 - 1,
        RATE_MAX,
        rng.integers(-most, most + 1, clocks),
    )


def _healed_again_and_again(sense: int) -> RampScenario:
    """Return a scenario in which counts are put back faster than the ramp removes them, until the
    total would leave its range."""
    clocks, period = 3000, 40
    marker = np.arange(clocks) % period == 7
    return RampScenario(
        f"healed again and again, {sense}",
        _sine(clocks, 50.0, 710.0),
        marker,
        2**19 - 1,
        RATE_ONE,
        np.where(marker, sense * (2**14 - 1), 0),
    )


def _random(seed: int, clocks: int, marker_rate: float, limit: int, rate: int) -> RampScenario:
    rng = np.random.default_rng(seed)
    level = rng.integers(-limit, limit + 1, clocks)
    correction = level * COUNT // 2 + rng.integers(-COUNT, COUNT, clocks)
    return RampScenario(
        f"random {seed}, markers {marker_rate}, limit {limit}, rate {rate}",
        correction.astype(np.int64),
        rng.random(clocks) < marker_rate,
        limit,
        rate,
    )


# LARGEST is the largest sum of 64 lanes and the offset, if each cosine is larger than 1 by 2⁻¹⁴.
LARGEST = 64 * (8192 * COUNT + COUNT // 2) + 8192 * COUNT

SCENARIOS = [
    RampScenario(
        "one step up", _steps((0, 3), (2 * COUNT, 200)), _markers(203, 3), 1000, 32 * RATE_ONE
    ),
    RampScenario(
        "one step down", _steps((COUNT, 3), (-COUNT, 200)), _markers(203, 3), 1000, 32 * RATE_ONE
    ),
    RampScenario(
        "no whole number of units", _steps((0, 2), (7 * UNIT + 1, 60)), _markers(62, 2), 9, RATE_ONE
    ),
    RampScenario("slow", _steps((0, 1), (5 * UNIT, 90)), _markers(91, 1), 9, RATE_ONE // 10 + 1),
    RampScenario("rate 0 keeps r", _steps((0, 1), (COUNT, 40)), _markers(41, 1), 9, 0),
    RampScenario("fastest", _steps((0, 1), (900 * UNIT, 20)), _markers(21, 1), 9, RATE_MAX),
    RampScenario("no marker, no ramp", _sine(64, 50.0, 17.0), _markers(64), 1000, RATE_ONE),
    RampScenario(
        "moving", _sine(300, 50.0, 71.0), _markers(300, 0, 40, 41, 42, 100, 299), 1000, 9 * RATE_ONE
    ),
    RampScenario("marker in every clock", _sine(40, 50.0, 17.0), ~_markers(40), 1000, RATE_ONE),
    RampScenario(
        "clipped by itself", _sine(200, 12.0, 40.0), _markers(200, 15, 77), 5, 16 * RATE_ONE
    ),
    RampScenario("smallest turn", _sine(200, 3.0, 40.0), _markers(200, 15, 77), 1, 16 * RATE_ONE),
    RampScenario(
        "largest sums",
        np.where(np.arange(400) % 7 < 3, LARGEST, -LARGEST).astype(np.int64),
        _markers(400, *range(3, 400, 5)),
        2**19 - 1,
        RATE_MAX,
    ),
    RampScenario(
        "at the limit",
        _steps((4 * COUNT, 5), (4 * COUNT + 1, 5), (-4 * COUNT, 5), (-4 * COUNT - 1, 5)),
        _markers(20),
        4,
        0,
    ),
    _smooth("smooth", -3.0, 60, 3_000_000, 16_000_000_000 >> 2),
    _smooth("smooth, without reaching the rate", 0.5, 50, 2**31, 2**32 - 1),
    _smooth("smooth, slow", 2e-5, 40, 900, 2_000_000),
    _smooth("smooth, less than a step", 1e-6, 20, RATE_MAX, 2**32 - 1),
    _smooth("smooth, one unit up", 1.0 / COUNT, 40, 1_500_000, 17_100),
    _smooth("smooth, one unit down", -1.0 / COUNT, 40, 1_500_000, 17_100),
    _smooth("smooth, markers on the way", 0.8, 200, 9_000_000, 2**32 - 1, 7, 25, 40, 41, 70),
    *(_marked_every_tick(0.9, 40, phase) for phase in (100, 239, 247, 254)),
    _insertions(5, 3000, 8),
    *(_healed_again_and_again(sense) for sense in (1, -1)),
    _insertions(6, 3000, 2**15 - 1),
    _random(1, 3000, 0.02, 1000, 200 * RATE_ONE + 12345),
    _random(2, 3000, 0.3, 100, RATE_MAX),
    _random(3, 3000, 0.01, 4, 3 * RATE_ONE // 7),
    _random(4, 2000, 0.02, 2**19 - 1, RATE_MAX),
]
