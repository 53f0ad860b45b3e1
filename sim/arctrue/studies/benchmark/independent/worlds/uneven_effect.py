"""One cause of the catalogue whose size varies by ± 20 % over the turn."""

from __future__ import annotations

import numpy as np

from arctrue.studies.benchmark.independent.causes.cause import log_uniform
from arctrue.studies.benchmark.independent.causes.disc import Backlash
from arctrue.studies.benchmark.independent.causes.heads import SubdivisionError
from arctrue.studies.benchmark.independent.conditions import stations
from arctrue.studies.benchmark.independent.designs import four_runs, head_noise
from arctrue.studies.benchmark.independent.geometry import any_disc
from arctrue.studies.benchmark.independent.noise import StateNoise
from arctrue.studies.benchmark.independent.scene import Scene

UNEVEN = 0.2


def draw(random: np.random.Generator, hidden: bool, rows: int) -> Scene:
    """Draw a scene of this world: a reversal error at stations, or a subdivision error."""
    if random.random() < 0.6:
        number = int(random.choice([24, 36, 72]))
        at = stations(np.arange(number) * (2 * np.pi / number), 5, True, 6.0)
        sigma = float(random.uniform(0.02, 0.2))
        phase = random.uniform(0, 2 * np.pi)
        cause = Backlash(log_uniform(random, 1.0, 50.0), UNEVEN, phase)
        return Scene(
            any_disc(random),
            causes=[cause] if hidden else [],
            stations=at,
            reference_noise=StateNoise(sigma),
            temperature=False,
            adverse_conditions=("uneven",),
        )
    runs = four_runs(rows)
    uneven = SubdivisionError.drawn(random, UNEVEN)
    return Scene(
        any_disc(random),
        causes=[uneven] if hidden else [],
        runs=runs,
        head_noise=head_noise(random, runs),
        index_counts=1,
        adverse_conditions=("uneven",),
    )
