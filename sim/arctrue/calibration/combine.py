"""Combines the values and information of the runs into an estimate with its covariance."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy.special import chdtri

from arctrue.base.units import RAD_PER_ARCSEC
from arctrue.calibration import head_separation
from arctrue.calibration.capture_check import WholeTurns
from arctrue.calibration.estimate import Estimate, RunFit
from arctrue.calibration.noise import ResidualSpectrum
from arctrue.calibration.transfer_function import noise_gain, separation_slope

Float = NDArray[np.float64]

DISAGREEMENT_FALSE_ALARM = 1e-3
LEAST_LINE_ARCSEC = 0.03
"""Smallest amplitude of a spectral line of the residual that is reported."""


def combined_estimate(
    *,
    function_of: Literal["reading", "angle"],
    turns: Sequence[WholeTurns],
    orders: NDArray[np.int64],
    seen: NDArray[np.int64],
    values: Float,
    information: Sequence[Float],
    by_run: Sequence[Float],
    own_residuals: Sequence[Float],
    residual_rms_by_run: Sequence[float],
    used_separation_rad: float,
    measured_separation_rad: float,
    separation_by_run_rad: Sequence[float],
    separation_choice: head_separation.Choice,
    u_used_separation_rad: float,
    u_index_rad: float,
    iterations: int,
) -> Estimate:
    """Combine the runs into an estimate with its covariance.

    ``seen``: the orders that the heads' difference determines; ``values`` and every entry of
    ``by_run``: (2·seen,); ``information``: XᵀX of each run for noise of variance 1;
    ``own_residuals``: residuals of each run after a fit of this run alone, so that different
    values of a run do not appear as noise; ``residual_rms_by_run``: RMS of the residuals with the
    common values.

    The covariance is first computed for white noise with each run's own variance. At each order it
    is then multiplied by two factors. The first is the residual's power near this order divided by
    the mean power, because the noise need not be white. The second is the disagreement between the
    runs, if chance does not explain the disagreement. Finally the contribution of α is added.
    """
    sigmas = noise_by_run(own_residuals, 2 * seen.size + 1)
    covariance = np.linalg.inv(_sum(information, sigmas))
    spectrum = ResidualSpectrum(
        turns, [r / s for r, s in zip(own_residuals, sigmas, strict=True)], sigmas, seen
    )
    colour = spectrum.at(seen)
    disagreement = _disagreement(values, by_run, information, sigmas, colour)
    stretch = np.tile(np.sqrt(colour * disagreement), 2)
    covariance *= np.outer(stretch, stretch)
    covariance += _by_separation(values, seen, used_separation_rad, u_used_separation_rad)

    number = orders.size
    place = np.flatnonzero(np.isin(orders, seen))
    both = np.concatenate((place, place + number))
    full_values, full = np.zeros(2 * number), np.diag(np.full(2 * number, np.inf))
    full_values[both] = values
    full[np.ix_(both, both)] = covariance
    disagree = np.ones(number)
    disagree[place] = disagreement
    statistical = 1.0 / np.sqrt(sum(p.samples / s**2 for p, s in zip(turns, sigmas, strict=True)))
    colour_of_mean = float(spectrum.at(np.array([0]))[0])
    rms = float(
        np.sqrt(np.average(np.square(residual_rms_by_run), weights=[p.samples for p in turns]))
    )
    return Estimate(
        function_of=function_of,
        orders=orders,
        values=full_values,
        covariance=full,
        noise_gain=np.where(np.isin(orders, seen), noise_gain(orders, used_separation_rad), np.inf),
        disagreement=disagree,
        residual_rms_arcsec=rms,
        residual_peaks=tuple(
            sorted(
                (line for line in spectrum.peaks() if line[1] > LEAST_LINE_ARCSEC),
                key=lambda line: -line[1],
            )
        ),
        head_separation_rad=used_separation_rad,
        u_head_separation_rad=u_used_separation_rad,
        separation_choice=separation_choice,
        measured_separation_rad=measured_separation_rad,
        u_measured_separation_rad=float(
            np.hypot(statistical * np.sqrt(colour_of_mean) * RAD_PER_ARCSEC, u_index_rad)
        ),
        runs=tuple(
            RunFit(part.run, part.turns, part.samples, r, a, v)
            for part, r, a, v in zip(
                turns,
                residual_rms_by_run,
                separation_by_run_rad,
                (_spread(v, both, number) for v in by_run),
                strict=True,
            )
        ),
        iterations=iterations,
    )


def noise_by_run(own_residuals: Sequence[Float], parameters: int) -> Float:
    """Return the standard deviation of each run's noise, from the residual after a fit of
    ``parameters`` values to this run alone."""
    return np.array(
        # The lower limit prevents a division by zero if the residual is exactly zero.
        [np.sqrt(max(float(r @ r) / max(r.size - parameters, 1), 1e-18)) for r in own_residuals]
    )


def _spread(values: Float, both: NDArray[np.int64], number: int) -> Float:
    full = np.zeros(2 * number)
    full[both] = values
    return full


def _sum(information: Sequence[Float], sigmas: Float) -> Float:
    total = np.zeros_like(information[0])
    for matrix, sigma in zip(information, sigmas, strict=True):
        total += matrix / sigma**2
    return total


def _by_separation(
    values: Float, orders: NDArray[np.int64], separation_rad: float, u_rad: float
) -> Float:
    """Return the covariance of all orders that the uncertainty of α causes."""
    slope = separation_slope(orders, values, separation_rad)
    direction = np.concatenate((slope.real, -slope.imag)) * u_rad
    return np.outer(direction, direction)


def _disagreement(
    values: Float,
    by_run: Sequence[Float],
    information: Sequence[Float],
    sigmas: Float,
    colour: Float,
) -> Float:
    """Return χ² per degree of freedom of the runs' values at every order; 1 where χ² does not
    exceed its limit for chance."""
    number = colour.size
    if len(by_run) < 2:
        return np.ones(number)
    square = np.zeros(number)
    for own, matrix, sigma in zip(by_run, information, sigmas, strict=True):
        apart = own - values
        covariance = np.linalg.inv(matrix) * sigma**2
        variance = np.diag(covariance) * np.tile(colour, 2)
        square += (apart**2 / variance).reshape(2, number).sum(axis=0)
    freedom = 2 * (len(by_run) - 1)
    limit = chdtri(freedom, DISAGREEMENT_FALSE_ALARM / number)
    return np.where(square > limit, square / freedom, 1.0)
