"""Defines a fitted quantity with its standard uncertainty."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

import numpy as np
from numpy.typing import NDArray

Kind = Literal["value", "amplitude", "phase"]
"""Kind of a parameter: an amplitude is not negative, a phase in degrees is the same after a whole
turn."""


@dataclass(frozen=True, slots=True)
class Parameter:
    """A fitted quantity that reports show: value, standard uncertainty, unit."""

    value: float
    sigma: float
    unit: str
    kind: Kind | None = field(default=None, compare=False)
    """Kind that the effect declares; None: the end of the name states it (:func:`kind_of`)."""


def kind_of(name: str, parameter: Parameter) -> Kind:
    """Return the kind of a parameter.

    A file of an own effect, or of a model, may declare no kind: a name that ends in ``amplitude``
    is then an amplitude, a name that ends in ``phase`` with the unit ``deg`` is a phase.
    """
    if parameter.kind is not None:
        return parameter.kind
    if name.endswith("amplitude"):
        return "amplitude"
    return "phase" if name.endswith("phase") and parameter.unit == "deg" else "value"


def phases_among(parameters: Mapping[str, Parameter]) -> frozenset[str]:
    """Return the names of the parameters that are phases."""
    return frozenset(name for name, item in parameters.items() if kind_of(name, item) == "phase")


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
        f"{prefix}amplitude": Parameter(amplitude, along_sigma, unit, "amplitude"),
        f"{prefix}phase": Parameter(
            float(np.degrees(np.arctan2(-sine, cosine))), phase_sigma, "deg", "phase"
        ),
    }
