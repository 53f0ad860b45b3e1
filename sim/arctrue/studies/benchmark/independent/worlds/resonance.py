"""Noise with a resonance (a damped oscillator that noise drives), without a line or another cause.

The oscillator is a cause that the catalogue does not have: `unknown` is right if the answer states
its frequency. The sets are logs and single runs; the quality factor is 3 to 60, and the coherence
time is at most a twentieth of the record.
"""

from __future__ import annotations

import numpy as np

from arctrue.studies.benchmark.independent.causes.cause import log_uniform
from arctrue.studies.benchmark.independent.conditions import Sweep, sweeps
from arctrue.studies.benchmark.independent.designs import SLOW_RAD_S
from arctrue.studies.benchmark.independent.geometry import Disc, any_disc
from arctrue.studies.benchmark.independent.noise import DrivenOscillator, StateNoise
from arctrue.studies.benchmark.independent.scene import Scene
from arctrue.studies.benchmark.independent.worlds.mount_log import SIDEREAL_RAD_S, log_time_s

CONTENTS = ("hidden",)
COHERENT_SHARE = 0.05
"""Largest coherence time 1/γ, as a share of the record's length."""


def draw(random: np.random.Generator, hidden: bool, rows: int) -> Scene:
    """Draw a scene of this world."""
    sigma = log_uniform(random, 0.05, 0.5)
    if random.random() < 0.5:
        time_s = log_time_s(random, rows)
        noise = _noise(random, sigma, time_s)
        return Scene(
            Disc(),
            passes=[Sweep(0, 0.0, 0.3, SIDEREAL_RAD_S, time_s)],
            reference_noise=noise,
            temperature=False,
            columns=("run", "time_s", "direction"),
            adverse_conditions=("resonance",),
        )
    runs = sweeps([SLOW_RAD_S], 2 * rows, 6.0)
    noise = _noise(random, sigma, runs[0].time_s)
    return Scene(any_disc(random), runs=runs, head_noise=noise, adverse_conditions=("resonance",))


def _noise(random: np.random.Generator, sigma: float, time_s: np.ndarray) -> StateNoise:
    length_s, step_s = float(np.ptp(time_s)), float(time_s[1])
    quality = log_uniform(random, 3.0, 60.0)
    # The coherence time 1/γ = Q/(π·f) is limited to COHERENT_SHARE of the record's length.
    lowest = quality / (np.pi * COHERENT_SHARE * length_s)
    hz = log_uniform(random, lowest, max(0.15 / step_s, 1.01 * lowest))
    return StateNoise(sigma, (DrivenOscillator(sigma * random.uniform(0.5, 2.0), hz, quality),))
