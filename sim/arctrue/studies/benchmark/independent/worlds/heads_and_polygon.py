"""Four runs of two heads and five cycles over a polygon, both ways, with one cause."""

from __future__ import annotations

import numpy as np

from arctrue.studies.benchmark.independent.designs import (
    capture_cause,
    four_runs,
    head_noise,
    polygon,
    reference_cause,
)
from arctrue.studies.benchmark.independent.geometry import any_disc
from arctrue.studies.benchmark.independent.noise import any_noise
from arctrue.studies.benchmark.independent.scene import Scene

FACES = 24


def draw(random: np.random.Generator, hidden: bool, rows: int) -> Scene:
    """Draw a scene of this world: two thirds of the causes act on the reference."""
    runs = four_runs(rows)
    stations = polygon(5, both_ways=True, faces=FACES, begin_s=runs[-1].end_s + 600.0)
    length_s = float(np.ptp(stations.at.time_s))
    of_reference = random.random() < 2 / 3
    cause = (
        reference_cause(random, FACES, length_s) if of_reference else capture_cause(random, runs)
    )
    sigma = float(random.uniform(0.05, 0.25))
    return Scene(
        any_disc(random),
        causes=[cause] if hidden else [],
        runs=runs,
        stations=stations,
        head_noise=head_noise(random, runs),
        reference_noise=any_noise(random, sigma, length_s, 8.0),
        index_counts=int(random.integers(2)),
        reference={
            "instrument": "polygon and autocollimator",
            "faces": FACES,
            "standard_uncertainty_arcsec": round(sigma, 3),
        },
    )
