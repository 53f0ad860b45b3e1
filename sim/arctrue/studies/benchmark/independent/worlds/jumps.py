"""A reference log or stations in which the reading of head 1 or the reference jumps once.

Either the counter of head 1 slips by one to three counts, or the stand of the reference is knocked,
by 3 to 30 times the noise.
"""

from __future__ import annotations

import numpy as np

from arctrue.studies.benchmark.independent.causes.cause import Cause
from arctrue.studies.benchmark.independent.causes.heads import Slip
from arctrue.studies.benchmark.independent.causes.strangers import ReferenceJump
from arctrue.studies.benchmark.independent.conditions import Sweep, stations
from arctrue.studies.benchmark.independent.geometry import any_disc
from arctrue.studies.benchmark.independent.noise import any_noise
from arctrue.studies.benchmark.independent.scene import Accepted, Scene

COARSE = 1 << 16
"""Counts per turn, 19.8″ each; with such coarse counts the size of a jump distinguishes a slip from
a knock."""


def draw(random: np.random.Generator, hidden: bool, rows: int) -> Scene:
    """Draw a scene of this world."""
    sigma = float(random.uniform(0.1, 0.5))
    moving = bool(random.random() < 0.5)
    slipped = bool(random.random() < 0.4)
    passes, at = [], None
    if moving:
        time_s = np.arange(min(rows, 1800)) * 2.0
        speed = 2 * 2 * np.pi / float(time_s[-1])
        passes = [Sweep(0, 0.0, 0.0, speed, time_s)]
    else:
        at = stations(np.arange(36) * (2 * np.pi / 36), 4, False, 6.0)
    times = passes[0].time_s if moving else (at.at.time_s if at is not None else np.zeros(2))
    length_s = float(times[-1])
    instant_s = length_s * random.uniform(0.2, 0.8)
    run = 0 if moving else int(instant_s // (36 * 6.0))
    cause: Cause
    if slipped:
        cause = Slip(int(random.integers(1, 4)), 1, run, instant_s)
    else:
        size = sigma * float(np.exp(random.uniform(np.log(3), np.log(30))))
        cause = ReferenceJump(size * float(random.choice([-1, 1])), instant_s)
    return Scene(
        any_disc(random, COARSE),
        causes=[cause] if hidden else [],
        passes=passes,
        stations=at,
        reference_noise=any_noise(random, sigma, length_s, float(times[1])),
        table={"counts_per_rev": COARSE},
        temperature=False,
        accepted=Accepted(verdicts=("unknown",)),
    )
