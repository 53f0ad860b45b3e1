"""Calculates the restricted likelihood of the noise from single residuals and from means of blocks.

A few thousand consecutive rows show the fast parts of the noise; means over blocks of rows show the
slow parts. The covariance of such means is known in closed form. The means over blocks of one
length are a level; the calculation treats the levels as independent, which is an approximation. On
the level with the longest blocks the columns of the model are added to the residuals, because the
model absorbs slow noise (restricted likelihood, Patterson and Thompson, Biometrika 58 (1971) 545).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from hashlib import blake2b

import numpy as np
from celerite2 import driver  # type: ignore[import-untyped]
from numpy.typing import NDArray
from scipy.linalg import lapack

from arctrue.workbench.noise.row_noise import Factor
from arctrue.workbench.noise.spectrum import Spectrum

Float = NDArray[np.float64]

ROWS_A_LEVEL = 1200
"""Approximate number of rows of a level; each evaluation of the likelihood factors their
covariance.
"""
WHOLE_ROWS = 2400
"""Largest number of rows of a group that is used without averaging."""
LEVEL_RATIO = 8
"""Ratio of the block lengths of neighbouring levels; about three levels cover a capture."""
MOST_STRETCHES = 12
"""Largest number of evenly spread stretches of a group of more than WHOLE_ROWS rows that are used;
it limits cost."""
SLOW_BLOCKS = 4.0
"""If a block is longer than this number of time constants of a part of the noise, the block means
of this part count as white."""
RIDGE = 1e-8
"""Share of the information that is added to its diagonal, so that two equal columns of the model
get half of the coefficient each."""
DIFFERENCE = 1e-5
"""Relative change of a variance in a difference quotient."""
LATEST = 2
"""Number of spectra whose whitened rows are kept: a warm search has two starts."""
UNCORRELATED = 40.0
"""Distance between two stretches in units of the largest time constant: a correlation of e⁻⁴⁰ is
negligible.
"""


@dataclass(frozen=True)
class Stretch:
    """Successive rows whose noise is correlated: clock (n,), residual (n,), model columns (n,
    k)."""

    clock: Float
    residual: Float
    columns: Float
    constant: int
    """Number of the free constant; stretches with the same number share one constant."""
    ones: Float
    """Column of the constant, shape (n,)."""


@dataclass(frozen=True)
class _Level:
    """Means over blocks of rows; all stretches follow one another, without correlation between
    them."""

    clock: Float
    values: Float
    """Residual in the first column, then the columns of the model, shape (n, 1 + k); k = 0 if the
    model is left out."""
    block: int
    white_share: Float
    """Share of each coloured part's variance that is white in the block means."""
    between_share: Float
    """Share of each coloured part's variance that is correlated between the block means."""


_Whitened = list[tuple[_Level, Factor, Float]]
"""Each level with its factor and its whitened values."""


@dataclass(frozen=True)
class FixedTerms:
    """Information about the model's coefficients from the other rows of the set."""

    information: Float
    """Normal matrix, shape (k, k)."""
    moment: Float
    """Right-hand side of the normal equations, whose unknowns are the changes of the coefficients
    since the residuals were computed, shape (k,)."""


class RestrictedLikelihood:
    """Restricted likelihood of the spectrum that some stretches have in common."""

    def __init__(
        self, stretches: Sequence[Stretch], step: float, constants: Float, fixed_terms: FixedTerms
    ) -> None:
        """Prepare the levels; ``step`` is the typical clock step, ``constants`` are the time
        constants of all spectra."""
        self._fixed_terms = fixed_terms
        self._levels, self._constant_count = _levels(stretches, step, constants)
        self._ridge: Float | None = None
        self._latest: list[tuple[Spectrum, _Whitened | None]] = []

    def digest(self) -> bytes:
        """Return a hash of all numbers that the likelihood contains."""
        found = blake2b()
        for level in self._levels:
            for values in (level.clock, level.values, level.white_share, level.between_share):
                found.update(repr((values.shape, level.block)).encode())
                found.update(values.tobytes())
        found.update(self._fixed_terms.information.tobytes())
        found.update(self._fixed_terms.moment.tobytes())
        return found.digest()

    def forget(self) -> None:
        """Release the whitened rows of the latest spectra."""
        self._latest = []

    def __call__(self, spectrum: Spectrum) -> float:
        """Return the log likelihood; −∞ where the covariance cannot be factored."""
        whitened = self._whitened(spectrum)
        return -np.inf if whitened is None else self._value(whitened)[0]

    def with_gradient(self, spectrum: Spectrum) -> tuple[float, Float]:
        """Return the log likelihood, and its derivatives with respect to the white and each
        coloured variance.

        Let V be the covariance of a level, r its residuals, X its columns, u = V⁻¹r and W = V⁻¹X, β
        the coefficients and N their normal matrix. A change dV of V changes the log likelihood by

        ½·(u − Wβ)ᵀdV(u − Wβ) + ½·tr(N⁻¹WᵀdV·W) − ½·tr(V⁻¹dV).
        """
        gradient = np.zeros(1 + spectrum.variances.size)
        whitened = self._whitened(spectrum)
        if whitened is None:
            return -np.inf, gradient
        value, coefficients, root = self._value(whitened)
        for level, factor, inside in whitened:
            precise = factor.unwhiten_transposed(inside)
            left = precise[:, :1]
            if inside.shape[1] > 1 and root is not None:
                columns = precise[:, 1:]
                left = np.hstack([left - columns @ coefficients[:, np.newaxis], columns @ root])
            white, between = _slopes(factor, np.ascontiguousarray(left))
            kept = level.between_share > 0.0
            gradient[0] += white / level.block
            gradient[1:] += white * level.white_share
            gradient[1:][kept] += between * level.between_share[kept]
        return value, gradient

    def _whitened(self, spectrum: Spectrum) -> _Whitened | None:
        """Return each level with its factor and its whitened values; None if a level cannot be
        factored."""
        # The latest spectra are kept, because a search compares the costs of its starts and then
        # begins at one of them.
        for before, found in self._latest:
            if before.equals(spectrum):
                return found
        found = self._whiten_levels(spectrum)
        self._latest = [*self._latest[1 - LATEST :], (spectrum, found)]
        return found

    def _whiten_levels(self, spectrum: Spectrum) -> _Whitened | None:
        found = []
        for level in self._levels:
            try:
                factor = _factor(level, spectrum)
                inside = factor.whiten(level.values)
            except driver.LinAlgError:
                return None
            if not np.isfinite(inside).all():
                # The closed form of the means is not positive definite for this spectrum.
                return None
            found.append((level, factor, inside))
        return found

    def _value(self, whitened: _Whitened) -> tuple[float, Float, Float | None]:
        """Return log likelihood, β, and a root of N⁻¹ (None if no model is projected out)."""
        total = 0.0
        own_size = self._fixed_terms.moment.size
        width = own_size + self._constant_count
        normal, moment = np.zeros((width, width)), np.zeros(width)
        normal[:own_size, :own_size] = self._fixed_terms.information
        moment[:own_size] = self._fixed_terms.moment
        restricted = False
        for _, factor, inside in whitened:
            own = inside[:, 0]
            total -= 0.5 * (float(own @ own) + factor.log_determinant)
            if inside.shape[1] > 1:
                columns = inside[:, 1:]
                normal += columns.T @ columns
                moment += columns.T @ own
                restricted = True
        if not restricted or width == 0:
            return total, moment, None
        # A direction that no row shows has a diagonal of 0, which rounding makes negative.
        shown = np.maximum(np.diag(normal), 0.0)
        if self._ridge is None:
            # The ridge is calculated once, so that directions that no row shows add the same
            # constant to each likelihood.
            self._ridge = RIDGE * np.maximum(shown, max(RIDGE * float(shown.max()), 1e-30))
        normal[np.diag_indices(width)] = shown + self._ridge
        scale = 1.0 / np.sqrt(np.diag(normal))
        # LAPACK without SciPy's checks: this is called a hundred times in a fit of a spectrum.
        lower, info = lapack.dpotrf(normal * np.outer(scale, scale), lower=1)
        if info > 0 or not np.isfinite(lower).all():
            return -np.inf, moment, None
        whole, _ = lapack.dtrtrs(lower, np.diag(scale), lower=1)
        # N⁻¹ = whole'·whole.
        scaled = whole @ moment
        total += 0.5 * float(scaled @ scaled)
        total -= float(np.sum(np.log(np.diag(lower)))) - float(np.sum(np.log(scale)))
        return total, whole.T @ scaled, whole.T


def _levels(
    stretches: Sequence[Stretch], step: float, constants: Float
) -> tuple[list[_Level], int]:
    rows = sum(stretch.clock.size for stretch in stretches)
    chosen = stretches
    if len(stretches) > MOST_STRETCHES and rows > WHOLE_ROWS:
        places = np.linspace(0, len(stretches) - 1, MOST_STRETCHES).round().astype(int)
        chosen = [stretches[place] for place in places]
        rows = sum(stretch.clock.size for stretch in chosen)
    names = sorted({stretch.constant for stretch in chosen})
    whole = []
    for stretch in chosen:
        constant = np.zeros((stretch.clock.size, len(names)))
        constant[:, names.index(stretch.constant)] = stretch.ones
        inside = np.column_stack([stretch.residual, stretch.columns, constant])
        whole.append((stretch.clock, inside))
    if rows <= WHOLE_ROWS:
        return [_level(whole, 1, step, constants)], len(names)
    top = -(-rows // ROWS_A_LEVEL)
    found = [_level(whole, top, step, constants)]
    block = 1
    while block * LEVEL_RATIO <= top * 2:
        size = max(ROWS_A_LEVEL // len(chosen), 64) * block
        middle = []
        for stretch in chosen:
            first = max((stretch.clock.size - size) // 2, 0)
            part = slice(first, min(first + size, stretch.clock.size))
            middle.append((stretch.clock[part], stretch.residual[part, np.newaxis]))
        found.append(_level(middle, block, step, constants))
        block *= LEVEL_RATIO
    return found, len(names)


def _level(
    stretches: Sequence[tuple[Float, Float]], block: int, step: float, constants: Float
) -> _Level:
    clocks, values = [], []
    last = 0.0
    gap = UNCORRELATED * float(constants.max(initial=step))
    for clock, inside in stretches:
        count = clock.size // block
        if count < 2:
            continue
        kept = count * block
        middle = clock[:kept].reshape(count, block).mean(axis=1)
        clocks.append(middle - middle[0] + last)
        last = float(clocks[-1][-1]) + gap
        values.append(inside[:kept].reshape(count, block, inside.shape[1]).mean(axis=1))
    white, between = _shares(block, step, constants)
    if not clocks:
        return _Level(np.zeros(0), np.zeros((0, 1)), block, white, between)
    return _Level(np.concatenate(clocks), np.vstack(values), block, white, between)


def _shares(block: int, step: float, constants: Float) -> tuple[Float, Float]:
    """Return the shares of a part's variance in block means: the white share, and the share
    correlated between blocks.

    The mean of exp(−|τ|/τⱼ) over two blocks is gain²·exp(−distance/τⱼ); within one block the
    remainder of the variance of a mean is white.
    """
    white, between = np.zeros(constants.size), np.ones(constants.size)
    if block == 1:
        return white, between
    places = np.arange(block) - 0.5 * (block - 1)
    lags = np.arange(1, block)
    for index, constant in enumerate(constants):
        decay = step / constant
        if block * decay > SLOW_BLOCKS:
            # Means over such long blocks are white, with the spectral density of the part at
            # frequency 0.
            rho = float(np.exp(-decay))
            white[index], between[index] = (1.0 + rho) / (1.0 - rho) / block, 0.0
            continue
        mean = block + 2.0 * float(np.sum((block - lags) * np.exp(-lags * decay)))
        between[index] = float(np.mean(np.exp(places * decay))) ** 2
        # The share may be slightly below 0: the correlated share is then slightly above the whole.
        white[index] = mean / block**2 - between[index]
    return white, between


def _log_determinant_slopes(factor: Factor) -> tuple[float, Float]:
    """Return tr(V⁻¹dV) for a change dV of the white and of each coloured variance, by differences.

    The library's own backward pass is wrong for more than four exponentials (celerite2 0.3.3).
    """
    spectrum = factor.spectrum
    here = factor.log_determinant
    found = np.empty(1 + spectrum.variances.size)
    values = np.concatenate([[spectrum.white], spectrum.variances])
    shape, rates = (factor.clock.size, spectrum.variances.size), 1.0 / spectrum.constants
    # All changes share these arrays; new arrays take up to half of the time of a short level.
    left, ones, lower = np.empty(shape), np.ones(shape), np.empty(shape)
    diagonal, pivots = np.empty(shape[0]), np.empty(shape[0])
    for index, value in enumerate(values):
        moved = values.copy()
        moved[index] += DIFFERENCE * value
        diagonal[:] = moved[0] + moved[1:].sum()
        if rates.size:
            left[:] = moved[1:]
            driver.factor(factor.clock, rates, diagonal, left, ones, pivots, lower)
        else:
            pivots[:] = diagonal
        there = float(2.0 * np.sum(np.log(np.sqrt(pivots))))
        found[index] = (there - here) / (DIFFERENCE * value)
    return float(found[0]), found[1:]


def _slopes(factor: Factor, left: Float) -> tuple[float, Float]:
    """Return ½·Σ qᵀdV·q − ½·tr(V⁻¹dV) over the columns q of ``left``.

    dV is the unit matrix for the first result, and each exponential of the level for the second.
    """
    white, between = _log_determinant_slopes(factor)
    squares = float(np.sum(left**2))
    forms = np.empty(between.size)
    ones, below = np.ones((left.shape[0], 1)), np.empty_like(left)
    for index, constant in enumerate(factor.spectrum.constants):
        below.fill(0.0)  # the library adds to this array, which all parts share
        driver.matmul_lower(factor.clock, np.array([1.0 / constant]), ones, ones, left, below)
        # The exponential's matrix is the unit matrix plus a lower and an upper triangle; both
        # triangles contribute equally to qᵀKq.
        below *= left
        forms[index] = squares + 2.0 * float(np.sum(below))
    return 0.5 * (squares - white), 0.5 * (forms - between)


def _factor(level: _Level, spectrum: Spectrum) -> Factor:
    white = spectrum.white / level.block + float(level.white_share @ spectrum.variances)
    kept = level.between_share > 0.0
    between = (level.between_share * spectrum.variances)[kept]
    return Factor(level.clock, Spectrum(white, spectrum.constants[kept], between))
