"""Tests whether whitened residuals are white, which σ and p rely on."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.special import chdtrc, ndtr

from arctrue.workbench.noise.law import NoiseLaw
from arctrue.workbench.noise.noise import Noise

Float = NDArray[np.float64]

LAGS = 20
"""Number of lags (chosen): the test shows correlation over up to 20 rows; more lags would reduce
the weight of the first ones in χ²."""
LEAST_ROWS = 8
"""Least number of rows. Two lags and the mean leave five free rows: with fewer the statistic has no
χ² distribution."""


@dataclass(frozen=True)
class Whiteness:
    """p values; a small one means that σ and p of the diagnosis may be too small."""

    autocorrelation_p: float
    """Ljung and Box, Biometrika 65 (1978) 297, over LAGS rows, fewer where rows are few."""
    successive_differences_p: float
    """Von Neumann, Ann. Math. Stat. 12 (1941) 367: mean square of the difference of neighbours over
    the variance."""
    normality_p: float
    """Jarque and Bera, Economics Letters 6 (1980) 255: skewness and kurtosis."""


def whiteness(whitened: Float) -> Whiteness | None:
    """Test whitened residuals, shape (rows,); return None for too few."""
    rows = whitened.size
    values = whitened - whitened.mean() if rows else whitened
    square = float(values @ values)
    if rows < LEAST_ROWS or square <= 0.0:
        return None
    lags = min(LAGS, rows // 4)
    correlation = autocorrelations(whitened, lags)
    weights = 1.0 / (rows - np.arange(1, lags + 1))
    statistic = rows * (rows + 2.0) * float(weights @ correlation**2)
    return Whiteness(float(chdtrc(lags, statistic)), _von_neumann_p(values), _normal_p(values))


def autocorrelations(whitened: Float, lags: int) -> Float:
    """Return the autocorrelation of whitened residuals (rows,) at lags 1 to ``lags``, shape
    (lags,)."""
    values = whitened - whitened.mean()
    products = [values[lag:] @ values[:-lag] for lag in range(1, lags + 1)]
    return np.asarray(np.array(products) / float(values @ values))


def _von_neumann_p(values: Float) -> float:
    """Return the two-sided p of the ratio, of mean 2 and variance 4(n − 2)/(n² − 1)."""
    rows = values.size
    ratio = float(np.sum(np.diff(values) ** 2)) / float(values @ values) * rows / (rows - 1.0)
    mean = 2.0 * rows / (rows - 1.0)
    sigma = 2.0 * rows / (rows - 1.0) * float(np.sqrt((rows - 2.0) / (rows**2 - 1.0)))
    return 2.0 * float(ndtr(-abs(ratio - mean) / sigma))


def _normal_p(values: Float) -> float:
    """Return p of skewness and kurtosis (Jarque and Bera, Econ. Lett. 6 (1980) 255)."""
    centred = values - np.mean(values)
    square = float(np.mean(centred**2))
    skewness = float(np.mean(centred**3)) / square**1.5
    kurtosis = float(np.mean(centred**4)) / square**2
    statistic = values.size / 6.0 * (skewness**2 + 0.25 * (kurtosis - 3.0) ** 2)
    return float(chdtrc(2, statistic))


def noise_data(noise: Noise, whitened: tuple[Float | None, Float | None]) -> dict[str, Any]:
    """Return white and coloured parts of both channels, arcseconds, and their tests, as JSON."""
    found: dict[str, Any] = {}
    for channel, law, of_rows, values in (
        ("capture", noise.capture_law, noise.capture, whitened[0]),
        ("reference", noise.reference_law, noise.reference, whitened[1]),
    ):
        if law is None or of_rows is None or values is None or of_rows.weightless:
            continue
        tests = whiteness(values)
        found[channel] = {
            **_parts(law),
            "tests": None if tests is None else asdict(tests),
        }
    if noise.capture is not None:
        found["index_arcsec"] = float(np.sqrt(noise.index_variance))
    return found


def _parts(law: NoiseLaw) -> dict[str, Any]:
    """Return root mean squares over the runs, and each coloured part of the first run."""
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
