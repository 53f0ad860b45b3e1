"""Factors the noise covariance C = L·Lᵀ of the rows of one channel, and whitens columns by L⁻¹.

The covariance is semiseparable, so the time of a Cholesky factorisation is proportional to the
number of rows (Foreman-Mackey et al., Astron. J. 154 (2017) 220; library celerite2). L⁻¹, applied
to measured values and columns, turns generalised least squares into ordinary least squares.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from celerite2 import driver  # type: ignore[import-untyped]
from numpy.typing import NDArray

from arctrue.workbench.noise.spectrum import Spectrum

Float = NDArray[np.float64]
Integer = NDArray[np.int64]

LONG = 5_000
"""Rows of a stretch from which negligible parts of its spectrum are left out; a shorter stretch
takes little time with all of them."""


@dataclass(frozen=True)
class Factor:
    """Cholesky factor L of the covariance C of one stretch of rows with a common spectrum."""

    clock: Float
    spectrum: Spectrum

    @cached_property
    def _parts(self) -> tuple[Float, Float, Float, Float]:
        rows, count = self.clock.size, self.spectrum.constants.size
        pivots = np.full(rows, self.spectrum.variance)
        rates = 1.0 / self.spectrum.constants
        left = np.empty((rows, count))
        left[:] = self.spectrum.variances
        lower = np.ones((rows, count))
        # The library factors in place, so that two arrays suffice.
        driver.factor(self.clock, rates, pivots, left, lower, pivots, lower)
        return rates, left, pivots, lower

    @cached_property
    def _white(self) -> bool:
        return not self.spectrum.variances.any()

    @cached_property
    def deviation(self) -> Float:
        """Square root of the pivots: the standard deviation of a row given all rows before it,
        shape (n,)."""
        if self._white:
            return np.full(self.clock.size, np.sqrt(self.spectrum.white))
        return np.sqrt(self._parts[2])

    @property
    def log_determinant(self) -> float:
        """Logarithm of the determinant of C."""
        return float(2.0 * np.sum(np.log(self.deviation)))

    def whiten(self, values: Float) -> Float:
        """Multiply columns, shape (n, k), by L⁻¹: the noise of the result is white with variance
        1."""
        found = np.array(values, order="C")
        self.whiten_in_place(found)
        return found

    def whiten_in_place(self, columns: Float) -> None:
        """Whiten contiguous columns, shape (n, k), without a copy."""
        if not self._white:
            rates, left, _, lower = self._parts
            driver.solve_lower(self.clock, rates, left, lower, columns, columns)
        columns /= self.deviation[:, np.newaxis]

    def unwhiten_transposed(self, whitened: Float) -> Float:
        """Multiply whitened columns, shape (n, k), by L⁻ᵀ; the result is C⁻¹ times the original
        columns."""
        scaled = np.ascontiguousarray(whitened / self.deviation[:, np.newaxis])
        if self._white:
            return scaled
        rates, left, _, lower = self._parts
        return np.asarray(
            driver.solve_upper(self.clock, rates, left, lower, scaled, np.empty_like(scaled))
        )

    def colour(self, white: Float) -> Float:
        """Multiply columns of independent normal numbers, shape (n, k), by L; the result is a draw
        of the noise."""
        scaled = np.ascontiguousarray(white * self.deviation[:, np.newaxis])
        if self._white:
            return scaled
        rates, left, _, lower = self._parts
        return np.asarray(
            driver.matmul_lower(self.clock, rates, left, lower, scaled, scaled.copy())
        )

    def expected(self, clock: Float, precise: Float) -> Float:
        """Predict the coloured part at the times ``clock``; ``precise`` is C⁻¹ times the residuals
        of this factor's rows, shape (n,)."""
        if self._white or self.clock.size == 0:
            return np.zeros(clock.size)
        rates = 1.0 / self.spectrum.constants
        here = np.tile(self.spectrum.variances, (clock.size, 1))
        there = np.ones((self.clock.size, rates.size))
        column = np.ascontiguousarray(precise[:, np.newaxis])
        total = np.zeros((clock.size, 1))
        total = driver.general_matmul_lower(clock, self.clock, rates, here, there, column, total)
        total = driver.general_matmul_upper(clock, self.clock, rates, here, there, column, total)
        return np.asarray(total[:, 0])


@dataclass(frozen=True, eq=False)
class RowNoise:
    """Noise of the rows of one channel: stretches of successive rows, the noise spectrum of each
    stretch, and a scale for each row."""

    clock: Float
    """Time of each row, or its number if there are no times, shape (rows,); it increases within
    each stretch."""
    starts: Integer
    """First row of each stretch."""
    spectra: tuple[Spectrum, ...]
    """Spectrum of each stretch."""
    scale: Float
    """Standard deviation of each row divided by the standard deviation of its spectrum, shape
    (rows,)."""
    weightless: bool = False
    """True if the noise of this channel cannot be estimated, so that no fit uses its rows."""

    @property
    def rows(self) -> int:
        """Number of rows."""
        return int(self.clock.size)

    @cached_property
    def stretches(self) -> list[slice]:
        """The rows of each stretch, as a slice."""
        starts = self.starts.tolist()
        ends = [*starts[1:], self.rows] if starts else []  # a part of a set may have no row
        return [slice(start, end) for start, end in zip(starts, ends, strict=True)]

    @cached_property
    def variance_arcsec2(self) -> Float:
        """Variance of each row, the sum over all parts of its spectrum."""
        found = self.scale**2
        for rows, spectrum in zip(self.stretches, self.spectra, strict=True):
            found[rows] *= spectrum.variance
        return found

    @cached_property
    def _factors(self) -> list[Factor]:
        return [
            Factor(np.ascontiguousarray(self.clock[rows]), self._needed(rows, spectrum))
            for rows, spectrum in zip(self.stretches, self.spectra, strict=True)
        ]

    def _needed(self, rows: slice, spectrum: Spectrum) -> Spectrum:
        """Return the spectrum that a factor needs: each further part of a long stretch takes
        time."""
        count = rows.stop - rows.start
        if count < LONG:
            return spectrum
        return spectrum.without_negligible_parts(count, float(np.diff(self.clock[rows]).min()))

    @cached_property
    def _even(self) -> bool:
        """True if every row has the scale 1."""
        return bool(np.all(self.scale == 1.0))

    @cached_property
    def whitened_ones(self) -> Float:
        """The whitened column of ones, shape (rows,)."""
        return self.whiten(np.ones(self.rows))

    @cached_property
    def log_determinant(self) -> float:
        """Logarithm of the determinant of the covariance of all rows."""
        inside = sum(factor.log_determinant for factor in self._factors)
        return float(inside + 2.0 * np.sum(np.log(self.scale)))

    def _each(self, values: Float, how: str) -> Float:
        two = values[:, np.newaxis] if values.ndim == 1 else values
        found = np.empty(two.shape)
        for rows, factor in zip(self.stretches, self._factors, strict=True):
            found[rows] = getattr(factor, how)(two[rows])
        return found[:, 0] if values.ndim == 1 else found

    def whiten(self, values: Float) -> Float:
        """Whiten values or columns, shape (rows,) or (rows, k): the noise of the result is
        uncorrelated with variance 1."""
        found = np.array(values, dtype=np.float64, order="C")
        self.whiten_in_place(found[:, np.newaxis] if found.ndim == 1 else found)
        return found

    def whiten_in_place(self, columns: Float) -> None:
        """Whiten contiguous columns, shape (rows, k), without a copy."""
        if self.weightless:
            columns[:] = 0.0
            return
        if not self._even:
            columns /= self.scale[:, np.newaxis]
        for rows, factor in zip(self.stretches, self._factors, strict=True):
            factor.whiten_in_place(columns[rows])

    def precise(self, whitened: Float) -> Float:
        """Multiply whitened values by the transposed L⁻¹; the result is C⁻¹ times the original
        values."""
        if self.weightless:
            return np.zeros(whitened.shape)
        return np.asarray((self._each(whitened, "unwhiten_transposed").T / self.scale).T)

    def coloured(self, whitened: Float) -> Float:
        """Reverse :meth:`whiten`; the result is in arcseconds, shape (rows,)."""
        return self.scale * self._each(whitened, "colour")

    def draw(self, random: np.random.Generator) -> Float:
        """Draw noise of this covariance, shape (rows,)."""
        return self.coloured(random.normal(size=self.rows))

    def expected(self, keep: NDArray[np.bool_], precise: Float) -> Float:
        """Predict the coloured part of the rows that are not kept.

        ``self`` covers all rows. ``precise`` is C⁻¹ times the residuals of the kept rows.
        """
        found = np.zeros(self.rows)
        kept_before = np.concatenate([[0], np.cumsum(keep)])
        for rows, spectrum in zip(self.stretches, self.spectra, strict=True):
            inside = keep[rows]
            part = slice(kept_before[rows.start], kept_before[rows.stop])
            clock = self.clock[rows]
            factor = Factor(np.ascontiguousarray(clock[inside]), spectrum)
            scaled = precise[part] * self.scale[rows][inside]
            values = np.zeros(inside.size)
            values[~inside] = factor.expected(np.ascontiguousarray(clock[~inside]), scaled)
            found[rows] = values * self.scale[rows]
        return found[~keep]

    def deviation_arcsec(self) -> Float:
        """Return the standard deviation of each row, with white and coloured parts, shape
        (rows,)."""
        found = np.empty(self.rows)
        for rows, spectrum in zip(self.stretches, self.spectra, strict=True):
            found[rows] = np.sqrt(spectrum.variance) * self.scale[rows]
        return found

    @cached_property
    def rms_arcsec(self) -> float:
        """Root mean square of the rows' standard deviations."""
        return float(np.sqrt(np.mean(self.deviation_arcsec() ** 2))) if self.rows else 0.0

    @cached_property
    def white_rms_arcsec(self) -> float:
        """Root mean square of the standard deviations of the white part."""
        parts = [
            spectrum.white * float(np.sum(self.scale[rows] ** 2))
            for rows, spectrum in zip(self.stretches, self.spectra, strict=True)
        ]
        return float(np.sqrt(sum(parts) / max(self.rows, 1)))

    def mean_square_scale(self, rows: slice) -> float:
        """Return the harmonic mean of the squared scales in a stretch; the noise spectrum of the
        stretch is multiplied by this value."""
        return float(1.0 / np.mean(1.0 / self.scale[rows] ** 2))

    def step(self, rows: slice) -> float:
        """Return the median step of the clock in a stretch; 1 for a stretch of one row."""
        return float(np.median(np.diff(self.clock[rows]))) if rows.stop - rows.start > 1 else 1.0

    def white_part(self) -> RowNoise:
        """Return the same noise without its coloured parts."""
        return replace(self, spectra=tuple(Spectrum(item.white) for item in self.spectra))

    def part(self, keep: NDArray[np.bool_]) -> RowNoise:
        """Return the noise of the kept rows."""
        kept_before = np.concatenate([[0], np.cumsum(keep)])
        starts, spectra = [], []
        for rows, spectrum in zip(self.stretches, self.spectra, strict=True):
            if kept_before[rows.stop] > kept_before[rows.start]:
                starts.append(int(kept_before[rows.start]))
                spectra.append(spectrum)
        return replace(
            self,
            clock=self.clock[keep],
            starts=np.array(starts, dtype=np.int64),
            spectra=tuple(spectra),
            scale=self.scale[keep],
        )


__all__ = ["Factor", "RowNoise"]
