"""Five to twelve stations of a reference; the number of grating lines is stated, and the rows have
no counts."""

from __future__ import annotations

import numpy as np

from arctrue.studies.benchmark.independent.causes.disc import Backlash
from arctrue.studies.benchmark.independent.conditions import stations
from arctrue.studies.benchmark.independent.geometry import any_disc
from arctrue.studies.benchmark.independent.noise import StateNoise
from arctrue.studies.benchmark.independent.scene import Scene


def draw(random: np.random.Generator, hidden: bool, rows: int) -> Scene:
    """Draw a scene of this world: a reversal error, or nothing."""
    number = int(random.integers(5, 13))
    both = hidden or random.random() < 0.5
    at = stations(
        np.arange(number) * (2 * np.pi / number), int(random.integers(1, 5)), bool(both), 10.0
    )
    sigma = float(random.uniform(0.05, 0.4))
    return Scene(
        any_disc(random),
        causes=[Backlash.drawn(random)] if hidden else [],
        stations=at,
        reference_noise=StateNoise(sigma),
        table={"grating_lines": 16_384, "counts_per_rev": 1 << 24},
        reference={"standard_uncertainty_arcsec": round(sigma, 3)},
        temperature=bool(random.random() < 0.5),
    )
