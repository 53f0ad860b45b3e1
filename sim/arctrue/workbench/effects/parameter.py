"""Defines a fitted quantity with its standard uncertainty."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, slots=True)
class Parameter:
    """A fitted quantity that reports show: value, standard uncertainty, unit."""

    value: float
    sigma: float
    unit: str


def amplitude_and_phase(
    cosine: float, sine: float, covariance: NDArray[np.float64], prefix: str, unit: str = "arcsec"
) -> dict[str, Parameter]:
    """Convert c·cos x + s·sin x to amplitude·cos(x + phase), with standard uncertainties.

    ``covariance`` is the 2 × 2 block of (c, s). The uncertainty of the phase is at most the
    standard deviation of a uniform distribution (180°/√3).
    """
    amplitude = float(np.hypot(cosine, sine))
    direction = np.array([cosine, sine]) / amplitude if amplitude > 0.0 else np.array([1.0, 0.0])
    across = np.array([-direction[1], direction[0]])
    along_sigma = float(np.sqrt(max(float(direction @ covariance @ direction), 0.0)))
    across_sigma = float(np.sqrt(max(float(across @ covariance @ across), 0.0)))
    limit = float(180.0 / np.sqrt(3.0))
    phase_sigma = (
        min(float(np.degrees(across_sigma / amplitude)), float(limit)) if amplitude > 0.0 else limit
    )
    return {
        f"{prefix}amplitude": Parameter(amplitude, along_sigma, unit),
        f"{prefix}phase": Parameter(
            float(np.degrees(np.arctan2(-sine, cosine))), phase_sigma, "deg"
        ),
    }
