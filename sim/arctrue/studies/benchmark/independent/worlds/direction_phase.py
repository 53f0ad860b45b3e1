"""A drive with a periodic error whose phase depends on the direction, because of stiction or
because the other flank of a tooth is in contact."""

from __future__ import annotations

import numpy as np

from arctrue.studies.benchmark.independent.causes.cause import log_uniform
from arctrue.studies.benchmark.independent.causes.reference import AngleLine
from arctrue.studies.benchmark.independent.conditions import sweeps
from arctrue.studies.benchmark.independent.geometry import any_disc
from arctrue.studies.benchmark.independent.noise import any_noise
from arctrue.studies.benchmark.independent.scene import Accepted, Scene


def draw(random: np.random.Generator, hidden: bool, rows: int) -> Scene:
    """Draw a scene of this world: a log of two turns up and two turns down, in alternation."""
    speed = float(np.radians(1.0))
    passes = sweeps([speed, -speed, speed, -speed], rows, 1.0)
    order = int(random.integers(30, 140))
    sigma = float(random.uniform(0.1, 1.0))
    forth = random.uniform(0, 2 * np.pi)
    back = forth + random.uniform(0.3, np.pi) * float(random.choice([-1, 1]))
    stated = bool(random.random() < 0.5)
    cause = AngleLine(sigma * log_uniform(random, 1.0, 20.0), float(order), forth, back)
    step_s = float(passes[0].time_s[1])
    return Scene(
        any_disc(random),
        causes=[cause] if hidden else [],
        passes=passes,
        reference_noise=any_noise(random, sigma, passes[-1].end_s, step_s),
        table={"drive_gear_teeth": float(order)} if stated else {},
        temperature=False,
        columns=("run", "time_s", "direction"),
        accepted=Accepted(
            # The catalogue contains a line at this order, but no line whose phase depends on
            # direction.
            names=("drive_gear_error", "high_order_graduation")
            if stated
            else ("high_order_graduation",),
            verdicts=("unknown",),
        ),
    )
