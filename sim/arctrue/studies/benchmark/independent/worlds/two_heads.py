"""Four runs of two heads (up, down, fast, warm), with one cause of the catalogue or nothing."""

from __future__ import annotations

import numpy as np

from arctrue.studies.benchmark.independent.designs import capture_cause, four_runs, head_noise
from arctrue.studies.benchmark.independent.geometry import any_disc
from arctrue.studies.benchmark.independent.scene import Scene


def draw(random: np.random.Generator, hidden: bool, rows: int) -> Scene:
    """Draw a scene of this world."""
    runs = four_runs(rows)
    return Scene(
        any_disc(random),
        causes=[capture_cause(random, runs)] if hidden else [],
        runs=runs,
        head_noise=head_noise(random, runs),
        index_counts=int(random.integers(2)),
        lost=float(random.choice([0.0, 0.01])),
    )
