"""Measures how far the peak of an oscillation stands out of the density of the other noise."""

from __future__ import annotations

import numpy as np

from arctrue.workbench.noise.kernel import KernelNoise, Part

PROMINENT = 10.0
"""Smallest ratio of an oscillation's power spectral density at its frequency to that of the other
noise, 10 dB, at which the oscillation may have a small share of the whole mean square."""
NARROW = 4.0
"""Smallest quality of such an oscillation. The density of a moving mean of N rows, which no sum of
kernels follows, has side lobes near (k + ½)/N with the half-power width 0.89/N: the first three
have qualities of 1.7, 2.8 and 3.9, the others less than 1 % of the density of the main lobe."""


def is_prominent(noise: KernelNoise, part: Part, step: float) -> bool:
    """Tell whether ``part`` is a narrow peak far above the other noise at its frequency, as in slow
    noise with a much larger mean square.

    ``step``: interval of single readings, in the unit of the clock.
    """
    others = sum(density(one, part.frequency) for one in noise.parts if one is not part)
    white = noise.white * step
    quality = np.pi * part.frequency * part.decay
    return quality >= NARROW and density(part, part.frequency) > PROMINENT * (others + white)


def density(part: Part, frequency: float) -> float:
    """Return the two-sided power spectral density of a part of the noise: its integral over all
    frequencies is the variance.

    It is the Fourier transform of the covariance in :mod:`arctrue.workbench.noise.kernel`.
    """
    square, decay = (2.0 * np.pi * frequency) ** 2, 1.0 / part.decay
    if part.kind == "exponential":
        return float(2.0 * part.variance * decay / (decay**2 + square))
    natural = decay**2 + (2.0 * np.pi * part.frequency) ** 2
    # A smooth part is a critically damped oscillator: its frequency is 0.
    bend = (natural - square) ** 2 + 4.0 * decay**2 * square
    return float(4.0 * part.variance * decay * natural / bend)
