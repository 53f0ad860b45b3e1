"""Causes that the catalogue does not have, in a log or in four runs (one of the causes with a
polygon).
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from arctrue.studies.benchmark.independent.causes.cause import Cause, log_uniform
from arctrue.studies.benchmark.independent.causes.strangers import (
    AirDrag,
    BentScale,
    Chirp,
    FastLobes,
    LooseBracket,
    Sectors,
    SettlingBracket,
    WarmOval,
    WobblingRoller,
)
from arctrue.studies.benchmark.independent.conditions import Sweep
from arctrue.studies.benchmark.independent.designs import four_runs, head_noise, polygon
from arctrue.studies.benchmark.independent.geometry import Disc, any_disc
from arctrue.studies.benchmark.independent.noise import StateNoise
from arctrue.studies.benchmark.independent.scene import Accepted, Scene
from arctrue.studies.benchmark.independent.worlds.mount_log import (
    SIDEREAL_RAD_S,
    log_noise,
    log_time_s,
)

CONTENTS = ("hidden",)
FACES = 24


def draw(random: np.random.Generator, hidden: bool, rows: int) -> Scene:
    """Draw a scene of this world."""
    if random.random() < 0.2:
        time_s = log_time_s(random, rows)
        sigma = log_uniform(random, 0.1, 0.5)
        return Scene(
            Disc(),
            causes=[Chirp.drawn(random, float(np.ptp(time_s)), sigma)],
            passes=[Sweep(0, 0.0, 0.3, SIDEREAL_RAD_S, time_s)],
            reference_noise=log_noise(random, sigma, time_s),
            temperature=False,
            columns=("run", "time_s", "direction"),
        )
    runs = four_runs(rows)
    length_s = runs[-1].end_s
    draws: list[Callable[[], Cause]] = [
        lambda: WarmOval.drawn(random),
        lambda: FastLobes.drawn(random),
        lambda: SettlingBracket.drawn(random, float(runs[0].time_s[-1])),
        lambda: AirDrag.drawn(random),
        lambda: Sectors.drawn(random),
        lambda: LooseBracket.drawn(random, length_s),
        lambda: WobblingRoller.drawn(random, length_s),
        lambda: BentScale.drawn(random),
    ]
    cause = draws[int(random.integers(len(draws)))]()
    bent = isinstance(cause, BentScale)
    # The harmonics of a square wave on the disc are high orders, so the name of a high order
    # describes a part of the hidden cause.
    alike = ("high_order_graduation",) if isinstance(cause, Sectors) else ()
    return Scene(
        any_disc(random),
        causes=[cause],
        runs=runs,
        stations=polygon(4, True, FACES, length_s + 300.0) if bent else None,
        head_noise=head_noise(random, runs),
        reference_noise=StateNoise(0.1),
        index_counts=int(random.integers(2)),
        reference={"faces": FACES, "standard_uncertainty_arcsec": 0.1} if bent else {},
        accepted=Accepted(alike=alike),
    )
