"""Sets with noise only (heavy tails, 1/f, relaxations, random walks): a log, stations, one or four
runs.
"""

from __future__ import annotations

import numpy as np

from arctrue.studies.benchmark.independent.causes.cause import log_uniform
from arctrue.studies.benchmark.independent.conditions import Sweep, stations, sweeps
from arctrue.studies.benchmark.independent.designs import SLOW_RAD_S, four_runs
from arctrue.studies.benchmark.independent.geometry import Disc, any_disc
from arctrue.studies.benchmark.independent.scene import Scene
from arctrue.studies.benchmark.independent.worlds.mount_log import (
    SIDEREAL_RAD_S,
    log_noise,
    log_time_s,
)

CONTENTS = ("nothing",)


def draw(random: np.random.Generator, hidden: bool, rows: int) -> Scene:
    """Draw a scene of this world: a log, stations, one run, or four runs."""
    kind = int(random.integers(4))
    sigma = log_uniform(random, 0.03, 0.5)
    if kind == 0:
        time_s = log_time_s(random, rows)
        return Scene(
            Disc(),
            passes=[Sweep(0, 0.0, 0.3, SIDEREAL_RAD_S, time_s)],
            reference_noise=log_noise(random, sigma, time_s),
            temperature=False,
            columns=("run", "time_s", "direction"),
        )
    if kind == 1:
        at = stations(np.arange(36) * (2 * np.pi / 36), 4, bool(random.random() < 0.5), 6.0)
        return Scene(
            any_disc(random),
            stations=at,
            reference_noise=log_noise(random, sigma, at.at.time_s),
            table={"grating_lines": 16_384, "counts_per_rev": 1 << 24, "drive_gear_teeth": 60.0},
            reference={"standard_uncertainty_arcsec": round(sigma, 3)},
        )
    runs = sweeps([SLOW_RAD_S], 2 * rows, 4.0) if kind == 2 else four_runs(rows)
    return Scene(
        any_disc(random),
        runs=runs,
        head_noise=log_noise(random, sigma, runs[0].time_s),
        index_counts=int(random.integers(2)),
        table={"drive_gear_teeth": 60.0} if random.random() < 0.5 else {},
    )
