"""Four runs of two heads with two causes at once; half of the sets also have a polygon."""

from __future__ import annotations

import numpy as np

from arctrue.studies.benchmark.independent.causes.cause import Cause
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

CONTENTS = ("hidden",)
FACES = 24


def draw(random: np.random.Generator, hidden: bool, rows: int) -> Scene:
    """Draw a scene of this world."""
    runs = four_runs(rows)
    with_polygon = random.random() < 0.5
    stations = polygon(4, True, FACES, runs[-1].end_s + 300.0) if with_polygon else None
    length_s = float(np.ptp(stations.at.time_s)) if stations is not None else 1000.0
    causes: list[Cause] = [capture_cause(random, runs)]
    while len(causes) < 2:
        other = (
            reference_cause(random, FACES, length_s)
            if with_polygon and random.random() < 0.5
            else capture_cause(random, runs)
        )
        if other.name != causes[0].name:
            causes.append(other)
    sigma = float(random.uniform(0.05, 0.25))
    return Scene(
        any_disc(random),
        causes=causes,
        runs=runs,
        stations=stations,
        head_noise=head_noise(random, runs),
        reference_noise=any_noise(random, sigma, length_s, 8.0),
        index_counts=int(random.integers(2)),
        reference={"faces": FACES, "standard_uncertainty_arcsec": round(sigma, 3)}
        if with_polygon
        else {},
    )
