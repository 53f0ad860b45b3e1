"""Tests whether whitened residuals are white, as the diagnosis assumes for its σ and p values."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.special import chdtrc, ndtr, ndtri

from arctrue.workbench.noise.law import NoiseLaw
from arctrue.workbench.noise.noise import Noise

Float = NDArray[np.float64]

LAGS = 20
"""Number of lags, a choice: the test shows correlation over up to 20 rows. More lags would reduce
the weight of the first lags in χ²."""
LEAST_ROWS = 8
"""Smallest number of rows, and of degrees of freedom plus one. Two lags and the mean leave five
free rows; with fewer rows the statistic has no χ² distribution."""
MOST_EXACT_ROWS = 4_000
"""Largest number of rows for the exact covariances of the autocorrelations; it only limits cost.
With more rows the covariances of white noise are used: a model of 41 columns changes these
covariances by a hundredth."""


@dataclass(frozen=True)
class Whiteness:
    """p values of the tests. If one of them is small, the σ and p of the diagnosis may be too
    small."""

    autocorrelation_p: float
    """p of Ljung and Box, Biometrika 65 (1978) 297, over LAGS lags, or fewer lags for few rows."""
    successive_differences_p: float
    """p of von Neumann, Ann. Math. Stat. 12 (1941) 367: mean square of the difference of neighbours
    divided by the variance."""
    normality_p: float
    """p of Jarque and Bera, Economics Letters 6 (1980) 255: skewness and kurtosis."""
    colour: float
    """Sum of the squares of the autocorrelations, without the autocorrelations that the model
    causes."""

    def data(self) -> dict[str, float]:
        """Return the p values as JSON."""
        found = asdict(self)
        del found["colour"]
        return found


def whiteness(whitened: Float, model: Float | None = None) -> Whiteness | None:
    """Test whitened residuals, shape (rows,); return None for too few rows.

    ``model``: the whitened columns (rows, k) that were fitted to the rows. A fit removes the noise
    at its own frequencies from the residuals, which are then correlated although the noise is
    white: on one turn of 120 rows, twenty orders remove a third of the spectrum. With M = I − QQᵀ
    for the orthonormal columns Q, A_k the mean of the shifts by ±k rows, and m = tr M degrees of
    freedom, the autocorrelations r_k of white noise have the exact moments

    E r_k = tr(MA_k)/m,  cov(r_j, r_k) = (2 tr(MA_jMA_k) − 2 tr(MA_j) tr(MA_k)/m)/(m(m + 2)).

    These moments hold for normal noise. Wild rows, whose values are improbable in normal noise, are
    left out of the tests of correlation: each such row gets a column of its own in the model.
    """
    rows = whitened.size
    values = whitened - whitened.mean() if rows else whitened
    square = float(values @ values)
    normal_p = _normal_p(values) if square > 0.0 else 1.0
    own = _orthonormal(rows, model)
    if rows <= MOST_EXACT_ROWS and own.shape[1] <= LARGEST_SHARE * rows:
        values, own = _without_wild_rows(values, own)
    free = rows - own.shape[1]
    if free < LEAST_ROWS - 1 or rows < LEAST_ROWS or square <= 0.0:
        return None
    lags = min(LAGS, max(free // 4, 2))
    mean, covariance = _moments(own, lags)
    away = autocorrelations(values, lags) - mean
    # The lags are correlated: the sum is replaced by a scaled χ² of the same mean and variance
    # (Satterthwaite).
    sigma = np.sqrt(np.diag(covariance))
    statistic = float(np.sum((away / sigma) ** 2))
    spread = float(np.sum((covariance / np.outer(sigma, sigma)) ** 2)) / lags
    return Whiteness(
        float(chdtrc(lags / spread, statistic / spread)),
        _von_neumann_p(values, own),
        normal_p,
        float(away @ away),
    )


def _without_wild_rows(values: Float, own: Float) -> tuple[Float, Float]:
    """Return residuals and orthonormal columns of the model; each wild row gets a column of its
    own.

    A row is wild if its residual, divided by its standard deviation, is so large that only one of a
    hundred sets of normal noise contains such a row. The row with the largest residual is treated
    first, because it also changes the residuals of its neighbours.
    """
    limit = float(-ndtri(0.5 * WILD / values.size)) if values.size else 0.0
    for _ in range(int(MOST_WILD * values.size)):
        share = 1.0 - np.sum(own**2, axis=1)
        ratio = np.abs(values) / np.sqrt(np.maximum(share, SAME_COLUMNS))
        ratio[share < SAME_COLUMNS] = 0.0  # no other row determines the fit here
        row = int(np.argmax(ratio))
        others = np.delete(ratio, row)
        if ratio[row] <= limit * float(np.sqrt(np.mean(others**2))):
            break
        column = -own @ own[row]
        column[row] += 1.0
        column /= np.linalg.norm(column)
        values = values - column * float(column @ values)
        own = np.column_stack([own, column])
    return values, own


WILD = 0.01
"""Probability that a set of normal noise contains a row that counts as wild."""
LARGEST_SHARE = 1.0 / 3.0
"""Wild rows are searched for only if the ratio of columns to rows is at most this value. A model
with more columns distributes the error of a wild row over the residuals of the other rows."""
MOST_WILD = 0.02
"""Largest share of wild rows; a larger share counts as tails of the noise."""


def _orthonormal(rows: int, model: Float | None) -> Float:
    """Return orthonormal columns that span a constant and the model, shape (rows, k).

    The eigenvectors of the Gram matrix give the directions; the Cholesky factor of the Gram matrix
    of these directions then removes their rounding errors. For many rows this takes a fifth of the
    time of a singular value decomposition.
    """
    ones = np.full((rows, 1), 1.0 / np.sqrt(max(rows, 1)))
    if model is None or model.shape[1] == 0 or rows == 0:
        return ones
    mean = model.mean(axis=0)
    left = model - mean
    gram = left.T @ left
    squares = np.diag(gram)
    norms = np.sqrt(squares)
    alive = norms > SAME_COLUMNS * np.sqrt(squares + rows * mean**2)
    if not np.any(alive):
        return ones
    gram = gram[np.ix_(alive, alive)] / np.outer(norms[alive], norms[alive])
    squares, vectors = np.linalg.eigh(gram)
    kept = squares > SAME_COLUMNS**2 * max(float(squares[-1]), 1.0)
    basis = np.zeros((model.shape[1], int(np.count_nonzero(kept))))
    basis[alive] = vectors[:, kept] / np.sqrt(squares[kept]) / norms[alive, np.newaxis]
    own = left @ basis
    factor = np.linalg.cholesky(own.T @ own)
    return np.hstack([ones, own @ np.linalg.inv(factor).T])


SAME_COLUMNS = 1e-6
"""A direction adds nothing to the model if its singular value is a smaller share than this of the
largest one."""


def _moments(own: Float, lags: int) -> tuple[Float, Float]:
    """Return mean (lags,) and covariance (lags, lags) of the autocorrelations of white noise in
    residuals."""
    rows, free = own.shape[0], own.shape[0] - own.shape[1]
    shifted = np.arange(1, lags + 1)
    exact = rows <= MOST_EXACT_ROWS
    traces = np.empty(lags)
    moved: list[Float] = []
    for lag in range(1, lags + 1):
        traces[lag - 1] = -float(np.vdot(own[lag:], own[:-lag]))
        if exact:
            both = np.zeros_like(own)
            both[lag:] += 0.5 * own[:-lag]
            both[:-lag] += 0.5 * own[lag:]
            moved.append(both)
    products = np.diag(0.5 * (rows - shifted))
    if exact:
        inside = np.array([own.T @ both for both in moved])
        flat = np.array(moved).reshape(lags, -1)
        products = products - 2.0 * flat @ flat.T
        products += inside.reshape(lags, -1) @ inside.reshape(lags, -1).T
    covariance = 2.0 * (products - np.outer(traces, traces) / free) / (free * (free + 2.0))
    return traces / free, covariance


def autocorrelations(whitened: Float, lags: int) -> Float:
    """Return the autocorrelation of whitened residuals (rows,) at lags 1 to ``lags``, shape
    (lags,)."""
    values = whitened - whitened.mean()
    products = [values[lag:] @ values[:-lag] for lag in range(1, lags + 1)]
    return np.asarray(np.array(products) / float(values @ values))


def _von_neumann_p(values: Float, own: Float) -> float:
    """Return the two-sided p of the ratio of the squared successive differences to the sum of
    squares.

    With N = DᵀD for the differences D, mean and variance of the ratio are tr(MN)/m and (2 tr(MNMN)
    − 2 tr(MN)²/m)/(m(m + 2)), as for an autocorrelation.
    """
    rows = values.size
    free = rows - own.shape[1]
    ratio = float(np.sum(np.diff(values) ** 2)) / float(values @ values)
    steps = np.diff(own, axis=0)
    inside = steps.T @ steps
    twice = np.diff(steps, axis=0, prepend=0.0, append=0.0)
    trace = 2.0 * (rows - 1.0) - float(np.trace(inside))
    square = 6.0 * rows - 8.0 - 2.0 * float(np.vdot(twice, twice)) + float(np.sum(inside**2))
    variance = 2.0 * (square - trace**2 / free) / (free * (free + 2.0))
    return 2.0 * float(ndtr(-abs(ratio - trace / free) / np.sqrt(variance)))


def _normal_p(values: Float) -> float:
    """Return p of skewness and kurtosis (Jarque and Bera, Econ. Lett. 6 (1980) 255)."""
    centred = values - np.mean(values)
    square = float(np.mean(centred**2))
    if square**2 == 0.0:  # the residual is zero in float64
        return 1.0
    skewness = float(np.mean(centred**3)) / square**1.5
    kurtosis = float(np.mean(centred**4)) / square**2
    statistic = values.size / 6.0 * (skewness**2 + 0.25 * (kurtosis - 3.0) ** 2)
    return float(chdtrc(2, statistic))


def noise_data(noise: Noise, tests: tuple[Whiteness | None, Whiteness | None]) -> dict[str, Any]:
    """Return, as JSON, white and coloured parts of both channels, arcseconds, and the tests of
    both."""
    found: dict[str, Any] = {}
    for channel, law, of_rows, tested in (
        ("capture", noise.capture_law, noise.capture, tests[0]),
        ("reference", noise.reference_law, noise.reference, tests[1]),
    ):
        if law is None or of_rows is None or of_rows.weightless:
            continue
        found[channel] = {**_parts(law), "tests": None if tested is None else tested.data()}
    if noise.capture is not None:
        found["index_arcsec"] = float(np.sqrt(noise.index_variance))
    return found


def _parts(law: NoiseLaw) -> dict[str, Any]:
    """Return root mean squares of white and coloured parts over the runs, and each coloured part of
    the first run."""
    runs = max(len(law.spectra), 1)
    scale = law.run_scale**2
    white = sum(item.white * factor for item, factor in zip(law.spectra, scale, strict=True))
    slow = sum(
        float(item.variances.sum()) * factor
        for item, factor in zip(law.spectra, scale, strict=True)
    )
    first = law.spectra[0]
    return {
        "white_arcsec": float(np.sqrt(white / runs)),
        "coloured_arcsec": float(np.sqrt(slow / runs)),
        "coloured_parts": [
            {"time_constant": float(constant), "arcsec": float(np.sqrt(variance))}
            for constant, variance in zip(first.constants, first.variances, strict=True)
        ],
    }
