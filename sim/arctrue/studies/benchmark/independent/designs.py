"""Makes the designs of experiments that several worlds share, and draws one cause of the catalogue
for a design."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from arctrue.studies.benchmark.independent.causes.cause import Cause
from arctrue.studies.benchmark.independent.causes.disc import (
    AxisMotion,
    Backlash,
    BallPass,
    Defect,
    HighOrder,
    WarmCentre,
)
from arctrue.studies.benchmark.independent.causes.heads import (
    HeadStandsOff,
    LateHead,
    Shaking,
    Slip,
    SubdivisionError,
    WarmBracket,
)
from arctrue.studies.benchmark.independent.causes.reference import (
    Creep,
    Faces,
    FirstOrderOfReference,
    GainOfReference,
)
from arctrue.studies.benchmark.independent.conditions import Stations, Sweep, stations, sweeps
from arctrue.studies.benchmark.independent.noise import StateNoise, any_noise

Random = np.random.Generator
SLOW_RAD_S, FAST_RAD_S = float(np.radians(30.0)), float(np.radians(90.0))
WARM_K = 4.0
TURNS = 3.0


def four_runs(rows: int) -> list[Sweep]:
    """Make four runs of three turns each: up, down, three times as fast, and warm."""
    speeds = [SLOW_RAD_S, -SLOW_RAD_S, FAST_RAD_S, SLOW_RAD_S]
    return sweeps(speeds, rows, TURNS, [0.0, 0.0, 0.0, WARM_K])


def head_noise(random: Random, runs: list[Sweep]) -> StateNoise:
    """Draw noise of any kind; its white part has a standard deviation of 0.03 to 0.2″ in each
    head."""
    length_s = runs[-1].end_s
    step_s = float(runs[0].time_s[1] - runs[0].time_s[0])
    return any_noise(random, float(np.exp(random.uniform(np.log(0.03), np.log(0.2)))),
                     length_s, step_s)  # fmt: skip


def polygon(cycles: int, both_ways: bool, faces: int = 24, begin_s: float = 0.0) -> Stations:
    """Make visits of every face in every cycle."""
    targets = np.arange(faces) * (2 * np.pi / faces)
    return stations(targets, cycles, both_ways, 8.0, begin_s)


def capture_cause(random: Random, runs: list[Sweep]) -> Cause:
    """Draw, with equal probabilities, one of the catalogue's causes that four runs of two heads can
    show."""
    first = runs[0]
    step_s = max(float(run.time_s[1] - run.time_s[0]) for run in runs)
    run_s = float(first.time_s[-1])
    draws: list[Callable[[], Cause]] = [
        lambda: HighOrder.drawn(random),
        lambda: HeadStandsOff.drawn(random),
        lambda: SubdivisionError.drawn(random),
        lambda: AxisMotion.drawn(random),
        lambda: BallPass.drawn(random),
        lambda: Shaking.drawn(random, len(runs), step_s, run_s),
        lambda: LateHead.drawn(random),
        lambda: WarmBracket.drawn(random),
        lambda: WarmCentre.drawn(random),
        lambda: slip(random, runs),
        lambda: Defect.drawn(random),
    ]
    return draws[int(random.integers(len(draws)))]()


def slip(random: Random, runs: list[Sweep]) -> Slip:
    """Draw a slip of 4 to 60 counts, of either sign, in the middle 60 % of a run."""
    run = runs[int(random.integers(len(runs)))]
    size = int(random.integers(4, 61)) * int(random.choice([-1, 1]))
    instant_s = run.begin_s + float(run.time_s[-1]) * random.uniform(0.2, 0.8)
    return Slip(size, int(random.integers(1, 3)), run.number, instant_s)


def reference_cause(random: Random, faces: int, length_s: float) -> Cause:
    """Draw, with equal probabilities, one of the catalogue's causes that a polygon together with a
    capture can show."""
    draws: list[Callable[[], Cause]] = [
        lambda: Faces.drawn(random, faces),
        lambda: FirstOrderOfReference.drawn(random),
        lambda: GainOfReference.drawn(random),
        lambda: Creep.drawn(random, length_s),
        lambda: Backlash.drawn(random),
    ]
    return draws[int(random.integers(len(draws)))]()
