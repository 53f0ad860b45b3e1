"""Holds the size of an effect over time, with one point per measurement set."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from arctrue.workbench.effects.base import Parameter

Float = NDArray[np.float64]

AMPLITUDE, PHASE = "amplitude", "phase"


@dataclass(frozen=True, eq=False)
class Series:
    """One parameter of the model over time; an amplitude and its phase form one point of a plane.

    In the plane a change of only the phase also moves the point, and the noise of a small amplitude
    has mean 0.
    """

    name: str
    """Name of effect and parameter, such as ``hysteresis.reversal_error``."""
    unit: str
    days: Float
    """Times of the sets, (sets,), days since 1970, ascending."""
    values: Float
    """Values, (sets, 1); for an amplitude A with a phase φ the components A cos φ and −A sin φ,
    (sets, 2)."""
    u: Float
    """Standard uncertainty of each component, (sets,), from the fit of the set."""

    @property
    def size(self) -> Float:
        """Absolute value (or amplitude) of each point, (sets,)."""
        return np.asarray(np.linalg.norm(self.values, axis=1))

    def until(self, sets: int) -> Series:
        """Return the series of the first ``sets`` points."""
        return replace(self, days=self.days[:sets], values=self.values[:sets], u=self.u[:sets])


def series_of(days: Float, found: Sequence[Mapping[str, Parameter]]) -> list[Series]:
    """Return the series of every parameter that all sets determine.

    ``days`` (sets,) ascend; ``found`` contains the parameters of each set by name. A phase is used
    only together with its amplitude. A parameter has a series only if every set states a finite
    value and a positive uncertainty.
    """
    made: list[Series] = []
    for name in found[0] if found else ():
        if not all(name in of_set for of_set in found):
            continue
        items = [of_set[name] for of_set in found]
        phase_name = f"{name.removesuffix(AMPLITUDE)}{PHASE}"
        if name.endswith(AMPLITUDE) and all(phase_name in of_set for of_set in found):
            values, u = _plane(items, [of_set[phase_name] for of_set in found])
        elif name.endswith(PHASE):
            continue
        else:
            values = np.array([[item.value] for item in items])
            u = np.array([item.sigma for item in items])
        if np.isfinite(values).all() and np.isfinite(u).all() and (u > 0.0).all():
            made.append(Series(name, items[0].unit, days, values, u))
    return made


def _plane(amplitudes: Sequence[Parameter], phases: Sequence[Parameter]) -> tuple[Float, Float]:
    """Return the points (A cos φ, −A sin φ), (sets, 2), and the root mean square of the
    uncertainties of a point's two components, (sets,).

    Along the amplitude A the uncertainty is u(A); at right angles to it the uncertainty is A ·
    u(φ). The fit limits u(φ) to the standard deviation of a uniformly distributed phase. For an
    amplitude of at most u(A), A · u(φ) would therefore be too small; u(A) is then used in both
    directions.
    """
    size = np.array([item.value for item in amplitudes])
    angle = np.radians([item.value for item in phases])
    along = np.array([item.sigma for item in amplitudes])
    across = size * np.radians([item.sigma for item in phases])
    across = np.where(size > along, across, along)
    values = np.stack([size * np.cos(angle), -size * np.sin(angle)], axis=1)
    return values, np.sqrt(0.5 * (along**2 + across**2))
