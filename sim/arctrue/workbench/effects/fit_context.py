"""Defines the parts of the fitted model that effects may use."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from arctrue.base.units import RAD_PER_ARCSEC


@dataclass(frozen=True)
class FitContext:
    """The fitted error function and coefficients, for effects whose columns depend on them.

    The error function ε is the error of the graduation, equation (9): arcseconds as a function of
    the disc angle in radians.
    """

    cosine_arcsec: NDArray[np.float64] = field(default_factory=lambda: np.zeros(0))
    sine_arcsec: NDArray[np.float64] = field(default_factory=lambda: np.zeros(0))
    orders: NDArray[np.int64] = field(default_factory=lambda: np.zeros(0, dtype=np.int64))
    at_angle: NDArray[np.bool_] = field(default_factory=lambda: np.zeros(0, dtype=np.bool_))
    """True for each order whose columns are evaluated at the true angle, which does not contain the
    lag of the reading. Columns that are evaluated at the reading already contain the lag."""
    coefficients: Mapping[str, NDArray[np.float64]] = field(default_factory=dict)
    """Fitted coefficients of the effects that depend on the model, by name."""

    def shifted_arcsec(
        self, disc_rad: NDArray[np.float64], shift_rad: NDArray[np.float64]
    ) -> NDArray[np.float64]:
        """Return ε(ψ + shift) − ε(ψ) in arcseconds, for the orders at the true angle; shapes
        (rows,)."""
        total = np.zeros_like(disc_rad, dtype=np.float64)
        for order, cosine, sine, there in zip(
            self.orders, self.cosine_arcsec, self.sine_arcsec, self.at_angle, strict=True
        ):
            if there:
                # cos(a + s) − cos a = −2 sin(a + s/2) sin(s/2) avoids the difference of nearly
                # equal numbers.
                middle, half = order * (disc_rad + 0.5 * shift_rad), 0.5 * order * shift_rad
                total += 2.0 * np.sin(half) * (sine * np.cos(middle) - cosine * np.sin(middle))
        return total

    def error_arcsec(self, disc_rad: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return ε(ψ) in arcseconds, in the shape of ``disc_rad``."""
        total = np.zeros_like(disc_rad, dtype=np.float64)
        for order, cosine, sine in zip(
            self.orders, self.cosine_arcsec, self.sine_arcsec, strict=True
        ):
            phase = order * disc_rad
            total += cosine * np.cos(phase) + sine * np.sin(phase)
        return total

    def error_slope(self, disc_rad: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return dε/dψ in arcseconds per arcsecond, in the shape of ``disc_rad``."""
        total = np.zeros_like(disc_rad, dtype=np.float64)
        for order, cosine, sine in zip(
            self.orders, self.cosine_arcsec, self.sine_arcsec, strict=True
        ):
            phase = order * disc_rad
            total += order * (sine * np.cos(phase) - cosine * np.sin(phase))
        return total * RAD_PER_ARCSEC
