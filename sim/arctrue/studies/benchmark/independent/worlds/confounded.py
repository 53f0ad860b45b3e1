"""One run in which the temperature rises in proportion to time, so that an effect of temperature
and an effect of time look the same.

Half of the hidden causes follow the temperature; these are in the catalogue. The other half follow
time, and are not in the catalogue. No data of this design can distinguish the two halves.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from arctrue.studies.benchmark.independent.causes.cause import Cause
from arctrue.studies.benchmark.independent.causes.heads import WarmBracket
from arctrue.studies.benchmark.independent.causes.strangers import TimeDrift
from arctrue.studies.benchmark.independent.conditions import sweeps
from arctrue.studies.benchmark.independent.designs import SLOW_RAD_S
from arctrue.studies.benchmark.independent.geometry import any_disc
from arctrue.studies.benchmark.independent.noise import StateNoise
from arctrue.studies.benchmark.independent.scene import Accepted, Scene


def draw(random: np.random.Generator, hidden: bool, rows: int) -> Scene:
    """Draw a scene of this world: ten turns, 1 to 4 K warmer at the end."""
    warming_k = float(random.uniform(1.0, 4.0))
    run = sweeps([SLOW_RAD_S], 2 * rows, 10.0)[0]
    run = replace(run, warming_k_s=warming_k / float(run.time_s[-1]))
    warm = WarmBracket.drawn(random)
    cause: Cause = warm
    if random.random() < 0.5:
        cause = TimeDrift(warm.size * run.warming_k_s * 3600)
    return Scene(
        any_disc(random),
        causes=[cause] if hidden else [],
        runs=[run],
        head_noise=StateNoise(float(random.uniform(0.03, 0.2))),
        index_counts=1,
        accepted=Accepted(verdicts=("ambiguous", "unknown", "cannot_tell")),
        adverse_conditions=("temperature in proportion to time",),
    )
