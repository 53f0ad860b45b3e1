"""The measurement sets of the blind test: which causes, how large, which experiment, which seed."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from arctrue.studies.simulate.experiment import EXPERIMENTS, Experiment
from arctrue.table.causes.registry import RECIPES

LEVELS = {"small": 0.15, "middle": 0.5, "large": 0.9}
"""Place of the size within the logarithm of its range."""
FIRST_SEED = 20_000
NONE_SETS = 100
"""Adequate sets; their false names are counted in percent."""
PAIRS = (
    ("subdivision_error", "thermal_eccentricity"),
    ("hysteresis", "count_slip"),
    ("bearing_ball_pass", "polygon_face_error"),
    ("vibration", "thermal_head_drift"),
    ("high_order_graduation", "autocollimator_gain"),
    ("warm_ovality", "thermal_eccentricity"),
)
QUICK = (
    ((), "full", "middle", 1),
    ((), "full", "middle", 2),
    (("subdivision_error",), "full", "middle", 2),
    (("thermal_eccentricity",), "full", "middle", 3),
    (("bearing_ball_pass",), "full", "large", 4),
    (("hysteresis",), "full", "middle", 5),
    (("timing_skew",), "full", "middle", 5),
    (("warm_ovality",), "full", "large", 6),
    (("half_order",), "full", "large", 8),
    ((), "lean", "middle", 7),
)
QUICK_SAMPLES, QUICK_CYCLES = 1500, 5


@dataclass(frozen=True)
class Case:
    """One set."""

    names: tuple[str, ...]
    experiment: str
    level: str
    seed: int
    samples: int | None = None
    """Samples a run, if not as many as the experiment has."""
    cycles: int | None = None

    @property
    def label(self) -> str:
        """What is in it: names joined, or none."""
        return "+".join(self.names) or "none"

    def sizes(self) -> list[float]:
        """Size of each cause at this level."""
        share = LEVELS[self.level]
        ranges = [(RECIPES[name].low, RECIPES[name].high) for name in self.names]
        return [float(np.exp(np.interp(share, (0, 1), np.log(ends)))) for ends in ranges]

    def planned(self) -> Experiment:
        """The experiment, made smaller where that is asked for."""
        experiment = EXPERIMENTS[self.experiment]()
        if self.samples is None or self.cycles is None:
            return experiment
        return experiment.smaller(self.samples, self.cycles)


def all_cases(seeds: int = 2, first_seed: int = FIRST_SEED) -> Iterator[Case]:
    """Every cause at every level, none, pairs, and each cause on a lean set."""
    number = itertools.count(first_seed)
    for name in RECIPES:
        for level in LEVELS:
            for _ in range(seeds):
                yield Case((name,), "full", level, next(number))
    for pair in PAIRS:
        for _ in range(seeds):
            yield Case(pair, "full", "middle", next(number))
    for name in ("", *RECIPES):
        for _ in range(seeds):
            yield Case((name,) if name else (), "lean", "middle", next(number))
    for _ in range(NONE_SETS):
        yield Case((), "full", "middle", next(number))


def quick_cases() -> list[Case]:
    """A small fixed part, on small sets."""
    return [
        Case(names, experiment, level, seed, QUICK_SAMPLES, QUICK_CYCLES)
        for names, experiment, level, seed in QUICK
    ]
