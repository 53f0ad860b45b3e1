"""One run of two heads at one speed and one temperature, one to four turns."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from arctrue.studies.benchmark.independent.causes.cause import Cause
from arctrue.studies.benchmark.independent.causes.disc import Defect, HighOrder
from arctrue.studies.benchmark.independent.causes.heads import Shaking, SubdivisionError
from arctrue.studies.benchmark.independent.conditions import sweeps
from arctrue.studies.benchmark.independent.designs import SLOW_RAD_S, head_noise, slip
from arctrue.studies.benchmark.independent.geometry import any_disc
from arctrue.studies.benchmark.independent.scene import Accepted, Scene


def draw(random: np.random.Generator, hidden: bool, rows: int) -> Scene:
    """Draw a scene with causes that one run can show.

    Axis motion is not among these causes, because one run cannot separate it from the disc's
    orders.
    """
    turns = float(random.integers(1, 5))
    runs = sweeps([SLOW_RAD_S * float(random.choice([-1, 1]))], 2 * rows, turns)
    step_s = float(runs[0].time_s[1])
    draws: list[Callable[[], Cause]] = [
        lambda: HighOrder.drawn(random),
        lambda: SubdivisionError.drawn(random),
        lambda: Shaking.drawn(random, 1, step_s, float(runs[0].time_s[-1])),
        lambda: slip(random, runs),
        lambda: Defect.drawn(random),
    ]
    cause = draws[int(random.integers(len(draws)))]()
    # At one speed a line in time equals a line in angle, so that the cause of a line cannot be
    # identified.
    line = isinstance(cause, Shaking)
    return Scene(
        any_disc(random),
        causes=[cause] if hidden else [],
        runs=runs,
        head_noise=head_noise(random, runs),
        accepted=Accepted(
            names=("periodic_error",) if line else (),
            alike=("bearing_ball_pass",) if line else (),
            verdicts=("ambiguous",) if line or turns == 1 else (),
        ),
        temperature=bool(random.random() < 0.5),
    )
