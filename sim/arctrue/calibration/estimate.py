"""Describes the error that a calibration found, with its covariance."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from arctrue.calibration.harmonics import error_arcsec
from arctrue.calibration.head_separation import Choice

Float = NDArray[np.float64]


@dataclass(frozen=True)
class RunFit:
    """Result of one run alone: ``values`` (2·orders,) in arcseconds, cosines before sines."""

    run: int
    turns: int
    samples: int
    residual_rms_arcsec: float
    head_separation_rad: float
    values: Float


@dataclass(frozen=True)
class Estimate:
    """The error ε = Σ cosine·cos(n·x) + sine·sin(n·x), x the reading or the true angle.

    An order that the heads' difference does not determine has value 0 and infinite variance.

    Parameters
    ----------
    function_of : {"reading", "angle"}
        Meaning of x.
    orders : ndarray of int, shape (orders,)
        The orders n.
    values : ndarray, shape (2·orders,)
        Amplitudes in arcseconds; the cosines of all orders before the sines.
    covariance : ndarray, shape (2·orders, 2·orders)
        Covariance of the values in arcseconds²; it contains the noise found in the data, the
        disagreement of the runs and the uncertainty of α.
    noise_gain : ndarray, shape (orders,)
        |TF| of every order.
    disagreement : ndarray, shape (orders,)
        χ² per degree of freedom between the runs; 1 where chance explains it, and for one run.
    residual_rms_arcsec : float
        RMS of the residual, arcseconds.
    u_measured_separation_rad : float
        Standard uncertainty of the measured separation, radians.
    runs : tuple of RunFit
        The fit of each run.
    iterations : int
        Number of iterations until the fit converged.
    """

    function_of: Literal["reading", "angle"]
    orders: NDArray[np.int64]
    values: Float
    covariance: Float
    noise_gain: Float
    """Noise gain |TF| of every order, (N,)."""
    disagreement: Float
    """χ² per degree of freedom between the runs at every order, (N,); 1 if chance explains it."""
    residual_rms_arcsec: float
    residual_peaks: tuple[tuple[float, float], ...]
    """Lines that stand out in the residual: (order, amplitude in arcseconds), largest first."""
    head_separation_rad: float
    """The α that was used."""
    u_head_separation_rad: float
    """Standard uncertainty of the α that was used; the covariance includes the effect of this
    uncertainty on every order."""
    separation_choice: Choice
    """Source of the α that was used."""
    measured_separation_rad: float
    """Mean of R₂ − R₁ over uniform true angle: the α that the index marks give."""
    u_measured_separation_rad: float
    runs: tuple[RunFit, ...]
    iterations: int

    @property
    def amplitude_arcsec(self) -> Float:
        """Amplitude of the cosine, 2·A_n of equation (9), (N,)."""
        cosine, sine = np.split(self.values, 2)
        return np.hypot(cosine, sine)

    @property
    def phase_rad(self) -> Float:
        """Φ_n of equation (9), (N,), in (−π, π]."""
        cosine, sine = np.split(self.values, 2)
        return np.arctan2(-sine, cosine)

    @property
    def u_amplitude_arcsec(self) -> Float:
        """Standard uncertainty of the amplitude, (N,)."""
        return self._along(0.0)

    @property
    def u_phase_rad(self) -> Float:
        """Standard uncertainty of the phase, (N,); inf for amplitude 0."""
        with np.errstate(divide="ignore", invalid="ignore"):
            u = self._along(np.pi / 2.0) / self.amplitude_arcsec
        return np.asarray(np.where(np.isnan(u), np.inf, u))

    @property
    def u_component_arcsec(self) -> Float:
        """Standard uncertainty of a component, root of the mean of both variances, (N,)."""
        variance = np.diag(self.covariance).reshape(2, -1)
        return np.asarray(np.sqrt(variance.mean(axis=0)))

    def error_arcsec(self, x_rad: Float) -> Float:
        """Calculate the error ε at the angles ``x_rad``.

        Parameters
        ----------
        x_rad : ndarray, shape (points,)
            Reading or true angle, as ``function_of`` states, radians.

        Returns
        -------
        ndarray, shape (points,)
            ε, arcseconds.
        """
        return error_arcsec(self.orders, self.values, x_rad)

    def u_error_arcsec(self, x_rad: Float, applied: NDArray[np.bool_] | None = None) -> Float:
        """Calculate the standard uncertainty of the error with the full covariance.

        The square of this uncertainty is j(x)ᵀ C j(x), where j are the cosines and sines of the
        orders that the heads' difference determines. It contains the noise of each order and the
        common effect of α on all orders.

        Parameters
        ----------
        x_rad : ndarray, shape (points,)
            Reading or true angle, radians.
        applied : ndarray of bool, shape (orders,), optional
            Only these orders are included; default: all.

        Returns
        -------
        ndarray, shape (points,)
            Arcseconds.
        """
        number = self.orders.size
        visible = np.isfinite(np.diag(self.covariance)[:number])
        seen = np.flatnonzero(visible if applied is None else visible & applied)
        kept = np.concatenate((seen, seen + number))
        phase = np.multiply.outer(np.ravel(x_rad), self.orders[seen].astype(np.float64))
        columns = np.hstack((np.cos(phase), np.sin(phase)))
        spread = columns @ self.covariance[np.ix_(kept, kept)]
        return np.asarray(np.sqrt(np.einsum("ij,ij->i", spread, columns)))

    def _along(self, turned: float) -> Float:
        number = self.orders.size
        angle = turned - self.phase_rad
        c, s = np.cos(angle), np.sin(angle)
        index = np.arange(number)
        cc = self.covariance[index, index]
        ss = self.covariance[index + number, index + number]
        cs = self.covariance[index, index + number]
        seen = np.isfinite(cc) & np.isfinite(ss)
        variance = np.full(number, np.inf)
        cc, ss, cs, c, s = (part[seen] for part in (cc, ss, cs, c, s))
        variance[seen] = c**2 * cc + s**2 * ss + 2.0 * c * s * cs
        return np.asarray(np.sqrt(variance))
