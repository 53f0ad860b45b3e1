"""Estimates the noise of each head of a capture with three or four heads, without a model.

The white noise of the differences Rᵢ − R₁ has a covariance matrix: if the heads have independent
noise, it is σ₁² + σᵢ² on the diagonal and σ₁² elsewhere. Smooth errors, lines and drifts occupy few
frequencies of a run, white noise occupies all of them. The covariance is therefore the mean cross
spectrum of the differences, without the frequencies that stand out.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import uniform_filter1d
from scipy.special import chdtrc

from arctrue.base.runs import run_spans
from arctrue.workbench.observations.contrasts import contrast_weights, offset_weights

Float = NDArray[np.float64]
Integer = NDArray[np.int64]

UNEQUAL_P = 1e-4
"""Largest p at which the heads count as unequally noisy; p is the probability that equally noisy
heads show such a difference. It equals the limit for the scatter of runs."""
ORDERS = 20
"""Orders of a turn that are fitted and removed before the spectrum: those of the paper's model."""
SIGNAL_ORDERS = (1, 2, 4)
"""Orders of the signal period that are fitted and removed: those of ``subdivision_error``."""
ROWS_A_COLUMN = 4
"""Smallest number of rows of a run for each fitted column; with fewer rows, the fit would remove
too much of the noise."""
MOST_ROWS = 50_000
"""Largest number of samples, of all runs together: they determine σ within 0.4 %, √(35/18)
times 1/√(2·rows)."""
LEAST_PART_ROWS = 1000
"""Smallest number of samples that are taken from a run of this length or more: with fewer samples,
the fitted columns, up to 66, would remove too much of the noise."""
CLIPPED = 5.0
"""Limit of a deviation, in standard deviations (1.4826 times the median absolute deviation). Single
wrong rows have a white spectrum. One normal deviation in two million exceeds the limit."""
CLIPPING_ROUNDS = 3
"""Number of rounds of fitting and clipping: a wrong row takes part in the first fit only."""
STANDS_OUT = 8.0
"""A frequency is left out if the power of a difference exceeds this multiple of its median. White
noise exceeds it with the probability 2⁻⁸ = 0.4 %."""
NEIGHBOURS = 9
"""Number of neighbouring frequencies whose mean power is compared with the median of such means:
the skirts of a line or of a step stand out together, but not each alone."""
STANDS_OUT_TOGETHER = 2.5
"""Limit of such a mean as a multiple of the median. It has 2·9/(35/18) = 9 degrees of freedom, so
that white noise exceeds 2.5 times its median with a probability of 1 %."""
WINDOW_ROWS = 35.0 / 18.0
"""Number of neighbouring frequencies that share one independent value of a spectrum with a Hann
window: 1 + 2·(2/3)² + 2·(1/6)² (Harris, Proc. IEEE 66 (1978) 51, gives the correlations 2/3 and
1/6 of neighbours)."""
LEAST_CORRELATION = 0.1
"""Smallest correlation of two Helmert contrasts that matters: a smaller one makes the variance of a
sum of three contrasts wrong by at most a fifth."""
STATED_RATIO = 1.5
"""Smallest ratio of the noise of two heads that a report states: with one head 1.5 times as noisy
as two others, their mean has 7 % more noise than with the best weights."""
SMALLEST_SHARE = 1e-4
"""Smallest variance of a head, as a share of the largest: a head that is a hundred times as noisy
hides the noise of a quieter head."""
ROUNDS = 20
"""Number of scoring steps to the heads' variances; each step is linear least squares."""


@dataclass(frozen=True, eq=False)
class HeadNoise:
    """White noise of the heads, if they differ significantly."""

    covariance: Float
    """Covariance of Rᵢ − R₁, i = 2 … H, arcsec², shape (H − 1, H − 1)."""
    sigmas_arcsec: tuple[float, ...]
    """Standard deviation of each head, from head 1 on; empty if no independent noise of the heads
    explains the covariance."""
    weights: Float = field(init=False, repr=False)
    """Weights of the differences Rᵢ − R₁ in each channel, shape (H − 1, H − 1)."""
    offset_weights: Float = field(init=False, repr=False)
    """Weights of the offsets of a run's channels in each channel, shape (H − 1, H − 1)."""

    def __post_init__(self) -> None:
        """Compute the weights once, because many effects use them."""
        heads = self.covariance.shape[0] + 1
        object.__setattr__(self, "weights", contrast_weights(heads, self.covariance))
        object.__setattr__(self, "offset_weights", offset_weights(heads, self.covariance))

    @property
    def differ(self) -> bool:
        """True if the noise of each head is known, and one is STATED_RATIO times as noisy as
        another."""
        sigmas = self.sigmas_arcsec
        return bool(sigmas) and max(sigmas) >= STATED_RATIO * min(sigmas)

    def sentence(self) -> str:
        """Return the noise of each head as a sentence; empty if it is not known."""
        if not self.differ:
            return ""
        sizes = [f"{sigma:.2g}″" for sigma in self.sigmas_arcsec]
        noisy = 1 + int(np.argmax(self.sigmas_arcsec))
        words = (
            f"The heads are not equally noisy: head {noisy} is the noisiest (white noise of heads "
            f"1 to {len(sizes)}: {', '.join(sizes)})."
        )
        if len(sizes) == 3:
            # Three variances fit any three covariances.
            words += f" A fast motion of the axis along the disc under head {noisy} looks the same."
        return words


def samples_for_noise(run: NDArray[np.integer]) -> Integer:
    """Return the numbers of about MOST_ROWS samples: the first of every run, or of some runs if
    there are too many."""
    spans = run_spans(run)
    every = -(-len(spans) * LEAST_PART_ROWS // MOST_ROWS)
    spans = spans[:: max(every, 1)]
    share = max(MOST_ROWS // max(len(spans), 1), 1)
    kept = [np.arange(start, min(end, start + share)) for start, end in spans]
    return np.concatenate(kept) if kept else np.zeros(0, dtype=np.int64)


def head_noise(
    differences_arcsec: Float,
    run: NDArray[np.integer],
    angle_rad: Float,
    time_s: Float,
    signal_rad: Float | None = None,
) -> HeadNoise | None:
    """Return the noise of the heads; None if they do not differ, or if no run has enough rows.

    ``differences_arcsec``: Rᵢ − R₁ of every sample, (H − 1, samples); ``signal_rad``: phases of the
    signal period of every head, (H, samples). The heads count as different only if they differ both
    with and without the orders of the signal period among the fitted columns: these orders remove
    an interpolation error, but also pieces of a line that lies near them.
    """
    found = _noise_of(differences_arcsec, run, angle_rad, time_s, None)
    if found is None or signal_rad is None:
        return found
    other = _noise_of(differences_arcsec, run, angle_rad, time_s, signal_rad)
    if other is None or np.trace(other.covariance) < np.trace(found.covariance):
        return other
    return found


def _noise_of(
    differences_arcsec: Float,
    run: NDArray[np.integer],
    angle_rad: Float,
    time_s: Float,
    signal_rad: Float | None,
) -> HeadNoise | None:
    total, level, rows = np.zeros((differences_arcsec.shape[0],) * 2), 0.0, 0
    equal = np.linalg.inv(_of_heads(np.ones(differences_arcsec.shape[0] + 1)))
    for start, end in run_spans(run):
        part = slice(start, end)
        columns = _columns(
            angle_rad[part], time_s[part], None if signal_rad is None else signal_rad[:, part]
        )
        if columns.shape[0] < ROWS_A_COLUMN * columns.shape[1]:
            continue
        found, used = _cross_spectrum(differences_arcsec[:, part], columns)
        own = float(np.trace(equal @ found)) / found.shape[0]
        if used == 0 or own <= 0.0:
            continue
        # Runs may have different levels, for example if the noise grows with the speed.
        total, level, rows = total + used * found / own, level + used * own, rows + used
    if not rows:
        return None
    return _unless_equal(total / rows, rows / WINDOW_ROWS, level / rows)


def _columns(angle_rad: Float, time_s: Float, signal_rad: Float | None) -> Float:
    """Return the columns that are removed from a run: constant, straight line in time, orders of
    the turn, and orders of the signal period of each head."""
    since = time_s - time_s.mean()
    columns = [np.ones(angle_rad.size), since / max(float(np.abs(since).max()), 1e-300)]
    phases = [order * angle_rad for order in range(1, ORDERS + 1)]
    if signal_rad is not None:
        phases += [order * of_head for of_head in signal_rad for order in SIGNAL_ORDERS]
    columns += [wave(phase) for phase in phases for wave in (np.cos, np.sin)]
    return np.stack(columns, axis=1)


def _cross_spectrum(differences: Float, columns: Float) -> tuple[Float, int]:
    """Return the covariance of the white noise of a run, and the number of frequencies used."""
    size = columns.shape[0]
    window = 0.5 - 0.5 * np.cos(2.0 * np.pi * (np.arange(size) + 0.5) / size)
    # The fit has the weights of the window, so that a line far from the orders does not change it.
    weighted = window[:, np.newaxis]
    basis, sizes, _ = np.linalg.svd(weighted * columns, full_matrices=False)
    basis = basis[:, sizes > 1e-9 * sizes[0]]
    values = weighted * differences.T
    # Each round clips the deviations of wrong rows from the fit of the previous round.
    for _ in range(CLIPPING_ROUNDS):
        left = (values - basis @ (basis.T @ values)) / weighted
        limit = CLIPPED * 1.4826 * np.median(np.abs(left), axis=0)
        beyond = left - np.clip(left, -limit, limit)
        values = values - weighted * beyond
    spectra = np.fft.rfft(values - basis @ (basis.T @ values), axis=0)[1 : (size + 1) // 2]
    # Sum of the squares that white noise of variance 1 has after the fit.
    spectra /= np.sqrt(float(window @ window) - float(np.sum((weighted * basis) ** 2)))
    # Power of Rᵢ − Rⱼ of every pair of heads.
    heads = np.hstack([np.zeros((spectra.shape[0], 1)), spectra])
    first, second = np.triu_indices(heads.shape[1], 1)
    power = np.abs(heads[:, first] - heads[:, second]) ** 2
    kept = np.all(power <= STANDS_OUT * np.median(power, axis=0), axis=1)
    around = uniform_filter1d(power, NEIGHBOURS, axis=0, mode="nearest")
    kept &= np.all(around <= STANDS_OUT_TOGETHER * np.median(around, axis=0), axis=1)
    inside = spectra[kept]
    return np.real(inside.T @ inside.conj()) / max(int(kept.sum()), 1), int(kept.sum())


def _unless_equal(covariance: Float, rows: float, level: float) -> HeadNoise | None:
    """Return the noise unless equal noise of all heads explains the covariance (likelihood ratio
    with ``rows`` independent complex values); ``level`` gives the covariance its size."""
    heads = covariance.shape[0] + 1
    equal = np.linalg.inv(_of_heads(np.ones(heads))) @ covariance
    sign, log_determinant = np.linalg.slogdet(equal)
    if sign <= 0:
        return None
    mean = float(np.trace(equal)) / (heads - 1)
    ratio = 2.0 * rows * ((heads - 1) * float(np.log(mean)) - float(log_determinant))
    if chdtrc(heads * (heads - 1) // 2 - 1, max(ratio, 0.0)) > UNEQUAL_P:
        return None
    weights = contrast_weights(heads)
    together = weights @ covariance @ weights.T
    scatter = np.sqrt(np.diag(together))
    correlation = together / np.outer(scatter, scatter) - np.eye(heads - 1)
    uneven = float(scatter.max() / scatter.min()) ** 2 - 1.0
    if max(float(np.abs(correlation).max()), uneven) < LEAST_CORRELATION:
        return None
    variances = _variances(covariance)
    of_heads = _of_heads(variances)
    ratio = rows * (
        float(np.linalg.slogdet(of_heads)[1] - np.linalg.slogdet(covariance)[1])
        + float(np.trace(np.linalg.solve(of_heads, covariance)))
        - (heads - 1)
    )
    free = heads * (heads - 1) // 2 - heads
    floor = float(variances.min()) <= SMALLEST_SHARE * float(variances.max())
    explained = not floor and (free == 0 or chdtrc(free, max(2.0 * ratio, 0.0)) > UNEQUAL_P)
    sigmas = np.sqrt(variances * level) if explained else ()
    return HeadNoise(covariance * level, tuple(float(sigma) for sigma in sigmas))


def _variances(covariance: Float) -> Float:
    """Return the variance of each head with the largest likelihood, by scoring."""
    heads = covariance.shape[0] + 1
    seen = np.hstack([-np.ones((heads - 1, 1)), np.eye(heads - 1)])
    found = np.full(heads, float(np.trace(covariance)) / (2.0 * (heads - 1)))
    for _ in range(ROUNDS):
        inverse = np.linalg.inv(_of_heads(found))
        normal = (seen.T @ inverse @ seen) ** 2
        moment = np.diag(seen.T @ inverse @ covariance @ inverse @ seen)
        found = np.linalg.lstsq(normal, moment, rcond=1e-12)[0]
        found = np.maximum(found, 0.5 * SMALLEST_SHARE * float(np.max(found)))
    return np.asarray(found)


def _of_heads(variances: Float) -> Float:
    """Return the covariance of Rᵢ − R₁ for independent noise of the heads."""
    return np.asarray(np.diag(variances[1:]) + variances[0])


__all__ = ["HeadNoise", "head_noise", "samples_for_noise"]
