"""Only a reference at 24 to 72 stations; the cause is a reversal error, creep, or a drive whose
tooth count is known."""

from __future__ import annotations

import numpy as np

from arctrue.studies.benchmark.independent.causes.cause import Cause, log_uniform
from arctrue.studies.benchmark.independent.causes.disc import Backlash
from arctrue.studies.benchmark.independent.causes.reference import Creep, GearError
from arctrue.studies.benchmark.independent.conditions import stations
from arctrue.studies.benchmark.independent.geometry import any_disc
from arctrue.studies.benchmark.independent.noise import any_noise
from arctrue.studies.benchmark.independent.scene import Accepted, Scene


def draw(random: np.random.Generator, hidden: bool, rows: int) -> Scene:
    """Draw a scene of this world."""
    number = int(random.choice([24, 36, 48, 72]))
    teeth = int(random.integers(25, 90))
    # A gear needs unevenly spaced stations; otherwise the order of its teeth is an alias of a low
    # order.
    uneven = random.random() < 0.5
    places = np.arange(number) + (random.uniform(-0.3, 0.3, number) if uneven else 0.0)
    at = stations(places * (2 * np.pi / number), int(random.integers(3, 7)), True, 6.0)
    length_s = float(np.ptp(at.at.time_s))
    sigma = float(random.uniform(0.05, 0.4))
    kind = int(random.integers(3 if uneven and number > 48 else 2))
    cause: Cause
    if kind == 0:
        cause = Backlash.drawn(random)
    elif kind == 1:
        cause = Creep.drawn(random, length_s)
    else:
        phases = (random.uniform(0, 2 * np.pi), random.uniform(0, 2 * np.pi))
        cause = GearError(log_uniform(random, 0.5, 5.0), float(teeth), phases)
    return Scene(
        any_disc(random),
        causes=[cause] if hidden else [],
        stations=at,
        reference_noise=any_noise(random, sigma, length_s, 6.0),
        table={"drive_gear_teeth": float(teeth), "grating_lines": 16_384},
        reference={"standard_uncertainty_arcsec": round(sigma, 3)},
        accepted=Accepted(names=("periodic_error",) if kind == 2 else ()),
    )
