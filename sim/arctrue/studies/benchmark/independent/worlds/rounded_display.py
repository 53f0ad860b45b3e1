"""A polygon read on a display whose step is 0.5 to 5 times the noise."""

from __future__ import annotations

import numpy as np

from arctrue.studies.benchmark.independent.causes.disc import Backlash
from arctrue.studies.benchmark.independent.causes.reference import Creep
from arctrue.studies.benchmark.independent.conditions import stations
from arctrue.studies.benchmark.independent.geometry import any_disc
from arctrue.studies.benchmark.independent.noise import StateNoise
from arctrue.studies.benchmark.independent.scene import Scene


def draw(random: np.random.Generator, hidden: bool, rows: int) -> Scene:
    """Draw a scene of this world: a reversal error, a creep, or nothing."""
    number = int(random.choice([24, 36]))
    at = stations(np.arange(number) * (2 * np.pi / number), int(random.integers(3, 9)), True, 8.0)
    sigma = float(random.uniform(0.03, 0.2))
    step = float(random.choice([0.1, 0.2, 0.5, 1.0]))
    step = min(step, round(5 * sigma, 2))
    length_s = float(np.ptp(at.at.time_s))
    cause = Backlash.drawn(random) if random.random() < 0.6 else Creep.drawn(random, length_s)
    return Scene(
        any_disc(random),
        causes=[cause] if hidden else [],
        stations=at,
        reference_noise=StateNoise(sigma),
        display_arcsec=step,
        table={"counts_per_rev": 1 << 24, "grating_lines": 16_384},
        reference={"standard_uncertainty_arcsec": round(float(np.hypot(sigma, step / 3.46)), 3)},
        adverse_conditions=("display",),
    )
