"""A reference run without stops, in both directions at two speeds: it can show latency, reversal,
and lines in angle or time."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from arctrue.studies.benchmark.independent.causes.cause import Cause, log_uniform
from arctrue.studies.benchmark.independent.causes.disc import Backlash
from arctrue.studies.benchmark.independent.causes.heads import OldReading
from arctrue.studies.benchmark.independent.causes.reference import AngleLine, Line
from arctrue.studies.benchmark.independent.conditions import sweeps
from arctrue.studies.benchmark.independent.geometry import any_disc
from arctrue.studies.benchmark.independent.noise import any_noise
from arctrue.studies.benchmark.independent.scene import Accepted, Scene


def draw(random: np.random.Generator, hidden: bool, rows: int) -> Scene:
    """Draw a scene of this world, with two turns in each pass."""
    slow = float(np.radians(3.0))
    passes = sweeps([slow, -slow, 3 * slow, -3 * slow], rows, 2.0)
    step_s = float(passes[0].time_s[1])
    length_s = passes[-1].end_s
    sigma = log_uniform(random, 0.1, 0.5)
    phase = random.uniform(0, 2 * np.pi)
    amplitude = sigma * log_uniform(random, 0.3, 5.0)
    order = float(random.integers(21, 80)) + random.uniform(0.2, 0.8)
    slowest_hz = 20 / float(passes[2].time_s[-1])
    hz = log_uniform(random, slowest_hz, max(0.2 / step_s, 1.01 * slowest_hz))
    draws: list[Callable[[], Cause]] = [
        lambda: OldReading.drawn(random),
        lambda: Backlash.drawn(random),
        lambda: AngleLine(amplitude, order, phase),
        lambda: Line(amplitude, hz, phase),
    ]
    cause = draws[int(random.integers(len(draws)))]()
    return Scene(
        any_disc(random),
        causes=[cause] if hidden else [],
        passes=passes,
        reference_noise=any_noise(random, sigma, length_s, step_s),
        temperature=False,
        columns=("run", "time_s", "direction"),
        accepted=Accepted(
            # Vibration of the stand also causes a line in time that keeps its phase; a bearing also
            # causes an order that is not an integer.
            names=("vibration",)
            if isinstance(cause, Line)
            else ("bearing_ball_pass",)
            if isinstance(cause, AngleLine)
            else ()
        ),
    )
