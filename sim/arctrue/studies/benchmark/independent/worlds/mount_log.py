"""A log of a driven axis, up to an hour long, at up to 100 Hz: one to five lines, noise of any
kind.

The axis turns evenly; the log states its distance from the target. In half of the sets the
description states the number of teeth of the worm wheel, and one of the lines is the worm's; every
other line has a random period from 8 rows to a fifth of the log.
"""

from __future__ import annotations

import numpy as np

from arctrue.studies.benchmark.independent.causes.cause import Cause, log_uniform
from arctrue.studies.benchmark.independent.causes.reference import GearError, Line
from arctrue.studies.benchmark.independent.conditions import Sweep
from arctrue.studies.benchmark.independent.geometry import Disc
from arctrue.studies.benchmark.independent.noise import FlickerNoise, NoiseProcess, any_noise
from arctrue.studies.benchmark.independent.scene import Accepted, Scene

HOUR_S = 3600.0
SIDEREAL_RAD_S = float(np.radians(360.0 / 86_164.1))
RATES_HZ = (1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0)
FEWEST_PERIODS = 5.0


def log_time_s(random: np.random.Generator, rows: int) -> np.ndarray:
    """Return the times of a log: one hour at one of the rates. If an hour would give too many rows,
    the log is shorter, but at least five minutes long; if five minutes also give too many rows, the
    rate is lower.

    A log may have up to 4·``rows`` rows, as many as four runs have.
    """
    rows *= 4
    rate = float(random.choice(RATES_HZ))
    length_s = HOUR_S if HOUR_S * rate <= rows else max(rows / rate, HOUR_S / 12)
    rate = min(rate, rows / length_s)
    return np.round(np.arange(int(length_s * rate)) / rate, 6)


def log_noise(random: np.random.Generator, sigma: float, time_s: np.ndarray) -> NoiseProcess:
    """Draw 1/f noise, or noise of one of the five kinds of any_noise."""
    if random.random() < 0.2:
        return FlickerNoise(sigma, float(random.uniform(0.5, 1.0)))
    return any_noise(random, sigma, float(np.ptp(time_s)), float(time_s[1]))


def any_line(
    random: np.random.Generator, sigma: float, time_s: np.ndarray, slowest_s: float
) -> Line:
    """Draw a line with amplitude 0.3 to 10 σ and a period from 8 rows to ``slowest_s``."""
    period_s = log_uniform(random, 8 * float(time_s[1]), slowest_s)
    return Line(sigma * log_uniform(random, 0.3, 10.0), 1 / period_s, random.uniform(0, 2 * np.pi))


def draw(random: np.random.Generator, hidden: bool, rows: int) -> Scene:
    """Draw a scene of this world."""
    time_s = log_time_s(random, rows)
    length_s = float(np.ptp(time_s))
    sigma = log_uniform(random, 0.1, 1.0)
    teeth = float(random.integers(100, 400))
    speed = SIDEREAL_RAD_S
    # The worm must turn at least FEWEST_PERIODS times in the log, so the speed of a slow axis is
    # raised.
    speed *= max(1.0, FEWEST_PERIODS * 2 * np.pi / (teeth * speed * length_s))
    causes: list[Cause] = []
    stated = bool(random.random() < 0.5)
    number = int(random.integers(1, 6))
    if stated:
        phases = (random.uniform(0, 2 * np.pi), random.uniform(0, 2 * np.pi))
        causes.append(GearError(sigma * log_uniform(random, 0.5, 20.0), teeth, phases))
    while len(causes) < number:
        line = any_line(random, sigma, time_s, length_s / FEWEST_PERIODS)
        known = [float(item.hz) for item in causes if isinstance(item, Line)]
        known += [speed * teeth * k / (2 * np.pi) for k in (1, 2) if stated]
        # Two lines nearer than three times the resolution of the log look like one line with a
        # beat.
        if all(abs(line.hz - hz) > 3 / length_s for hz in known):
            causes.append(line)
    return Scene(
        Disc(),
        causes=causes if hidden else [],
        passes=[Sweep(0, 0.0, 0.3, speed, time_s)],
        reference_noise=log_noise(random, sigma, time_s),
        table={"drive_gear_teeth": teeth} if stated else {},
        temperature=False,
        columns=("run", "time_s", "direction"),
        # Vibration of the stand also causes a line in time, so its name is accepted too. On a short
        # arc, an integer order cannot be distinguished from its neighbours.
        accepted=Accepted(
            names=("periodic_error", "vibration") if hidden else (),
            alike=("high_order_graduation", "bearing_ball_pass") if hidden else (),
        ),
    )
