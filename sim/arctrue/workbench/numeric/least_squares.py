"""Computes the sums of generalised least squares over whitened rows (noise of variance 1).

Each run has a constant offset. The column of an offset contains the whitened ones on the rows of
the run and 0 elsewhere. It is never stored: its sums are calculated as sums over the rows of the
run.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from arctrue.base.runs import run_spans

Matrix = NDArray[np.float64]
Whole = NDArray[np.int64]


@dataclass(frozen=True)
class WhitenedRows:
    """One channel: columns (rows, k), whitened ones (rows,), and the number of each row's offset
    (rows,)."""

    columns: Matrix
    ones: Matrix
    offset: Whole
    offsets: int
    mixed: Matrix | None = None
    """Weights (m, m) of the offsets of each m successive runs in the rows of these runs; None if
    the rows of a run contain its own offset only."""

    def moment(self, whitened: Matrix) -> Matrix:
        """Multiply columns and offset columns by whitened values, shape (rows,) or (rows, m); the
        result has the shape (k + offsets,) or (k + offsets, m)."""
        two = whitened[:, np.newaxis] if whitened.ndim == 1 else whitened
        found = np.concatenate([self.columns.T @ two, self._times_ones(two)])
        return found[:, 0] if whitened.ndim == 1 else found

    @cached_property
    def _spans(self) -> list[tuple[int, int]]:
        """First row, and row after the last, of each block of rows with the same offset."""
        return run_spans(self.offset)

    def _times_ones(self, values: Matrix) -> Matrix:
        """Multiply the column of each offset by values (rows, k); the result is (offsets, k)."""
        total = np.zeros((self.offsets, values.shape[1]))
        for start, end in self._spans:
            total[self.offset[start]] += self.ones[start:end] @ values[start:end]
        return total if self.mixed is None else times_of_runs(self.mixed.T, total)

    @cached_property
    def gram(self) -> Matrix:
        """Gram matrix of all columns and of the columns of the offsets."""
        shared = self.columns.shape[1]
        found = np.zeros((shared + self.offsets,) * 2)
        found[:shared, :shared] = self.columns.T @ self.columns
        found[shared:, :shared] = self._times_ones(self.columns)
        found[:shared, shared:] = found[shared:, :shared].T
        places = np.arange(shared, shared + self.offsets)
        found[places, places] = np.bincount(self.offset, self.ones**2, self.offsets)
        if self.mixed is not None:
            own = found[shared:, shared:]
            found[shared:, shared:] = times_of_runs(
                self.mixed.T, times_of_runs(self.mixed.T, own).T
            )
        return found

    @property
    def every_column(self) -> Matrix:
        """Return the columns, then one column for each offset; shape (rows, k + offsets)."""
        constants = np.zeros((self.ones.size, self.offsets))
        constants[np.arange(self.ones.size), self.offset] = self.ones
        if self.mixed is not None:
            constants = times_of_runs(self.mixed.T, constants.T).T
        return np.hstack([self.columns, constants])

    def model(self, coefficients: Matrix) -> Matrix:
        """Return the whitened prediction of coefficients (k + offsets,) or (k + offsets, m)."""
        shared = self.columns.shape[1]
        constants = coefficients[shared:]
        if self.mixed is not None:
            constants = times_of_runs(self.mixed, constants)
        constants = constants[self.offset]
        own = (constants.T * self.ones).T
        return np.asarray(self.columns @ coefficients[:shared] + own)


def times_of_runs(weights: Matrix, values: Matrix) -> Matrix:
    """Multiply the values of each m successive runs, (runs,) or (runs, k), by weights (m, m)."""
    size = weights.shape[0]
    by_run = values.reshape(values.shape[0] // size, size, *values.shape[1:])
    return np.asarray(np.einsum("ij,rj...->ri...", weights, by_run).reshape(values.shape))


def divided_by_constants(cross: Matrix, constants: Matrix, smallest: float) -> Matrix:
    """Return ``cross`` (k, n) times the inverse of the Gram matrix of constants, (n, n).

    ``smallest`` replaces smaller elements of a diagonal matrix, so that a constant without rows
    does not cause a division by zero.
    """
    own = np.diag(constants)
    if not np.any(constants - np.diag(own)):
        return np.asarray(cross / np.maximum(own, smallest))
    return np.asarray(cross @ np.linalg.pinv(constants, hermitian=True))


@dataclass(frozen=True)
class ChannelSums:
    """Sums over whitened rows: Gram matrix, right-hand side, sum of squares. The columns of the
    terms come before those of the offsets."""

    gram: Matrix
    moment: Matrix
    square: float
    rows: int
    log_determinant: float
    """Log determinant of the covariance of the rows."""

    def residual_square(self, coefficients: Matrix) -> float:
        """Return χ² at these coefficients, without a new sum over the rows."""
        explained = 2.0 * self.moment @ coefficients - coefficients @ self.gram @ coefficients
        return max(float(self.square - explained), 0.0)

    def __add__(self, other: ChannelSums) -> ChannelSums:
        """Return the sums of this and the other object."""
        return ChannelSums(
            self.gram + other.gram,
            self.moment + other.moment,
            self.square + other.square,
            self.rows + other.rows,
            self.log_determinant + other.log_determinant,
        )


@dataclass(frozen=True)
class Layout:
    """Column numbers of each channel in the joint system of both channels; its columns are the
    terms, the run offsets and the constant a₀."""

    shared: int
    runs: int

    @property
    def size(self) -> int:
        """Number of all columns."""
        return self.shared + self.runs + 1

    def capture(self) -> NDArray[np.int64]:
        """Return the column numbers of the terms and of the run offsets."""
        return np.arange(self.shared + self.runs)

    def reference(self) -> NDArray[np.int64]:
        """Return the column numbers of the terms and of the constant a₀."""
        return np.append(np.arange(self.shared), self.shared + self.runs)
