"""Fits the error by the Fourier method of the paper, equations (1)–(7).

The method assumes K samples at equal steps of the true angle over whole turns. Samples at equal
*times* and uneven speed violate this assumption; ``least_squares`` does not need it.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from arctrue.base.units import ARCSEC_PER_RAD, ARCSEC_PER_TURN, arcsec_per_count
from arctrue.calibration import head_separation
from arctrue.calibration.capture_check import WholeTurns
from arctrue.calibration.combine import combined_estimate, noise_by_run
from arctrue.calibration.estimate import Estimate
from arctrue.calibration.transfer_function import noise_gain, transfer_function

Float = NDArray[np.float64]


def fourier(
    turns: Sequence[WholeTurns],
    counts_per_rev: int,
    nominal_separation_rad: float,
    orders: Sequence[int] | NDArray[np.int64],
    separation: head_separation.Choice | None = None,
    *,
    index_detection_arcsec: float = 0.0,
    index_repeatability_counts: float | None = None,
    by_harmonics: head_separation.Separation | None = None,
) -> tuple[Estimate, list[str]]:
    """Fit ε(θ) with one Fourier transform per run; runs are weighted by their samples and noise.

    ``whole_turns`` has checked that neighbouring samples differ by one step.

    Parameters
    ----------
    turns : sequence of WholeTurns
        Samples of the runs.
    counts_per_rev : int
        Counts of one turn.
    nominal_separation_rad : float
        Nominal angle α from head 1 to head 2, radians.
    orders : array_like of int, shape (orders,)
        Orders that are fitted.
    separation : str, optional
        Source of the α that sets the zero of head 2; default: the measured separation if the index
        is plausible and not less certain than the nominal value, otherwise the nominal value;
        ``harmonics`` needs ``by_harmonics``.
    index_detection_arcsec : float, optional
        Standard uncertainty of the distance between the places where the heads detect the index
        mark, arcseconds.
    index_repeatability_counts : float, optional
        Standard deviation of one head's index from run to run, counts.
    by_harmonics : Separation, optional
        Separation that was estimated from the harmonics.

    Returns
    -------
    estimate : Estimate
        The error with every order and its covariance.
    warnings : list of str
        Warnings for the user, one sentence each.

    Raises
    ------
    ValueError
        Samples of a run are masked (a transform needs every sample), or ``harmonics`` is requested
        and ``by_harmonics`` has no value.
    """
    for part in turns:
        if part.masked:
            raise ValueError(
                f"run {part.run}: {part.masked} samples are masked, and a transform needs every "
                "one; least_squares does not"
            )
    orders = np.asarray(orders, dtype=np.int64)
    unit = arcsec_per_count(counts_per_rev)
    spectra, means, starts = [], [], []
    differences = []
    for part in turns:
        difference: Float = np.asarray((part.head2_counts - part.head1_counts) * unit)
        mean = float(difference.mean())
        mean -= (
            round((mean - nominal_separation_rad * ARCSEC_PER_RAD) / ARCSEC_PER_TURN)
            * ARCSEC_PER_TURN
        )
        difference -= difference.mean()
        differences.append(difference)
        means.append(mean)
        starts.append(_start_rad(part, counts_per_rev))
        spectra.append(_coefficients(difference, part, orders, starts[-1]))
    samples = np.array([part.samples for part in turns], dtype=np.float64)
    measured = float(np.average(means, weights=samples)) / ARCSEC_PER_RAD
    choice, warnings = head_separation.judge(
        nominal_separation_rad,
        [mean / ARCSEC_PER_RAD for mean in means],
        # The uncertainty of each run's mean is neglected: the mean of a harmonic over equal steps
        # is 0, and the noise of the mean is far below a count.
        [0.0] * len(turns),
        measured,
        counts_per_rev,
        separation,
        index_detection_arcsec,
        index_repeatability_counts,
    )
    u_index = head_separation.u_index_rad(
        counts_per_rev, index_detection_arcsec, index_repeatability_counts
    )
    alpha = head_separation.chosen(
        choice,
        nominal_separation_rad,
        head_separation.Separation(measured, u_index),
        by_harmonics,
    )
    used = alpha.value_rad
    gain = noise_gain(orders, used)
    visible = np.isfinite(gain)
    seen = orders[visible]
    transfer = transfer_function(seen, used)
    by_run = [_values(spectrum[visible] * transfer) for spectrum in spectra]
    own_residuals = [
        difference - _synthesis(spectrum[visible], part, seen, start)
        for difference, spectrum, part, start in zip(
            differences, spectra, turns, starts, strict=True
        )
    ]
    weights = samples / noise_by_run(own_residuals, 2 * seen.size + 1) ** 2
    values = np.average(by_run, axis=0, weights=weights)
    common = (values[: seen.size] - 1j * values[seen.size :]) / 2.0 / transfer
    residual_rms = [
        # By Parseval's theorem the mean squares of the two residuals differ by the squared
        # differences of the coefficients.
        float(np.sqrt(np.mean(own**2) + 2.0 * np.sum(np.abs(spectrum[visible] - common) ** 2)))
        for own, spectrum in zip(own_residuals, spectra, strict=True)
    ]
    # White noise of variance s² in δ₂₁ gives a cosine of ε the variance 2|TF|²·s²/K.
    informations = [
        np.diag(np.tile(part.samples / (2.0 * np.abs(transfer) ** 2), 2)) for part in turns
    ]
    estimate = combined_estimate(
        function_of="angle",
        turns=turns,
        orders=orders,
        seen=seen,
        values=values,
        information=informations,
        by_run=by_run,
        own_residuals=own_residuals,
        residual_rms_by_run=residual_rms,
        used_separation_rad=used,
        measured_separation_rad=measured,
        separation_by_run_rad=[mean / ARCSEC_PER_RAD for mean in means],
        separation_choice=choice,
        u_used_separation_rad=alpha.u_rad,
        u_index_rad=u_index,
        iterations=1,
    )
    return estimate, warnings


def _steps(part: WholeTurns) -> Float:
    """Return θ − θ₀ of the samples, with the assumption of equal steps."""
    sign = 1.0 if part.step_counts > 0 else -1.0
    step = sign * 2.0 * np.pi * part.turns / part.samples
    return np.asarray(step * np.arange(part.samples))


def _start_rad(part: WholeTurns, counts_per_rev: int) -> float:
    """Return the true angle of the first sample from the mean of all readings, because the mean of
    ε over equal steps is 0."""
    relative = (part.head1_counts - part.head1_counts[0]) * (2.0 * np.pi / counts_per_rev)
    first = int(part.head1_counts[0]) % counts_per_rev * (2.0 * np.pi / counts_per_rev)
    return first + float(np.mean(relative - _steps(part)))


def _coefficients(
    difference: Float, part: WholeTurns, orders: NDArray[np.int64], start_rad: float
) -> NDArray[np.complex128]:
    """Return D₂₁[n] at θ = 0, from the transform whose zero is the first sample."""
    spectrum = np.fft.fft(difference) / part.samples
    sign = 1 if part.step_counts > 0 else -1
    lines = (sign * orders * part.turns) % part.samples
    return np.asarray(spectrum[lines] * np.exp(-1j * orders * start_rad))


def _synthesis(
    coefficients: NDArray[np.complex128],
    part: WholeTurns,
    orders: NDArray[np.int64],
    start_rad: float,
) -> Float:
    spectrum = np.zeros(part.samples, dtype=np.complex128)
    sign = 1 if part.step_counts > 0 else -1
    turned = coefficients * np.exp(1j * orders * start_rad)
    spectrum[(sign * orders * part.turns) % part.samples] = turned
    return np.asarray(2.0 * (np.fft.ifft(spectrum) * part.samples).real)


def _values(coefficients: NDArray[np.complex128]) -> Float:
    """Return the cosine amplitudes of all orders, then the sine amplitudes, from E_n in ε = 2·Re Σ
    E_n e^{jnθ}."""
    return np.concatenate((2.0 * coefficients.real, -2.0 * coefficients.imag))
