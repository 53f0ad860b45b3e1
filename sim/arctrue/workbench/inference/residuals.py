"""What a fitted model leaves, and how much of it further columns would take."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from arctrue.workbench.effects.base import Effect, Nonlinear
from arctrue.workbench.inference.normal import (
    Matrix,
    RunningSums,
    capture_columns,
    reference_columns,
    row_blocks,
    sums_by_run,
)
from arctrue.workbench.inference.solution import Solution
from arctrue.workbench.inference.symmetric import solve_symmetric
from arctrue.workbench.observations import Observations


@dataclass(frozen=True)
class Score:
    """The score test of a block of columns against the residuals of a model."""

    gain: float
    """χ² that the block takes from the weighted residuals, its noise held."""
    rank: int
    coefficients: Matrix
    covariance: Matrix
    moment: Matrix
    information: Matrix
    """Of the block, after the model is projected out."""


class Residuals:
    """Residuals of a solution with everything that a scan or a score test needs."""

    def __init__(self, solution: Solution) -> None:
        """Residuals of ``solution``; the arrays are computed when they are first used."""
        self.solution = solution
        self.observations: Observations = solution.observations

    @cached_property
    def capture_arcsec(self) -> NDArray[np.float64] | None:
        """Shape (capture rows,)."""
        return self.solution.capture_residual_arcsec()

    @cached_property
    def reference_arcsec(self) -> NDArray[np.float64] | None:
        """Shape (reference rows,)."""
        return self.solution.reference_residual_arcsec()

    @property
    def capture_sigma_arcsec(self) -> float:
        """Noise of a capture row that the fit found."""
        return self.solution.capture_sigma_arcsec or 1.0

    @property
    def reference_sigma_arcsec(self) -> float:
        """Noise of a reference row that the fit found."""
        return self.solution.reference_sigma_arcsec or 1.0

    @cached_property
    def _normal(self) -> Matrix:
        """Weighted normal matrix of the model: terms, run offsets, constant."""
        return self._weighted_normal()

    def _model_reference(self, block: slice) -> Matrix:
        solution = self.solution
        return reference_columns(
            solution.terms, solution.widths, self.observations, block, solution.context
        )

    def _effect_reference(self, effect: Effect, nonlinear: Nonlinear, block: slice) -> Matrix:
        """Columns of one effect for a block of reference rows, zeros where it has none."""
        rows = self.observations.reference
        assert rows is not None
        part = rows.part(block)
        columns = effect.reference_columns(part, nonlinear, self.solution.context)
        width = len(effect.column_names(self.observations))
        return np.zeros((part.run.size, width)) if columns is None else columns

    @property
    def _shared(self) -> int:
        return sum(self.solution.widths)

    @property
    def _size(self) -> int:
        return self._shared + self.observations.runs + 1

    @cached_property
    def _cached_capture(self) -> Matrix | None:
        """The model's capture columns, when they are small enough to keep."""
        rows = self.observations.capture
        if rows is None or rows.run.size * self._shared * 8 > KEEP_BYTES:
            return None
        blocks = [self._computed_capture(block) for block in row_blocks(rows.run.size)]
        return np.vstack(blocks) if blocks else None

    def _computed_capture(self, block: slice) -> Matrix:
        solution = self.solution
        return capture_columns(
            solution.terms, solution.widths, self.observations, block, solution.context
        )[0]

    def _capture_part(self, block: slice) -> Matrix:
        """Model columns of a block of capture rows; the run offsets are not written out."""
        cached = self._cached_capture
        return self._computed_capture(block) if cached is None else cached[block]

    def _runs_of(self, block: slice) -> NDArray[np.int64]:
        assert self.observations.capture is not None
        return self.observations.capture.run[block]

    def _capture_moment(self, block: slice, values: Matrix) -> Matrix:
        """Xᵀ·values of a block in the joint layout: terms, run offsets, constant."""
        two = values[:, np.newaxis] if values.ndim == 1 else values
        joint = np.concatenate(
            [
                self._capture_part(block).T @ two,
                sums_by_run(two, self._runs_of(block), self.observations.runs),
                np.zeros((1, two.shape[1])),
            ]
        )
        return joint[:, 0] if values.ndim == 1 else joint

    def _capture_model(self, block: slice, joint: Matrix) -> Matrix:
        """X·coefficients of a block, coefficients in the joint layout."""
        offsets = joint[self._shared : -1]
        return np.asarray(
            self._capture_part(block) @ joint[: self._shared] + offsets[self._runs_of(block)]
        )

    def _reference_moment(self, block: slice, values: Matrix) -> Matrix:
        offsets = np.zeros((self.observations.runs, *values.shape[1:]))
        own = self._model_reference(block).T @ values
        return np.concatenate([own, offsets, values.sum(axis=0)[np.newaxis]])

    def _reference_model(self, block: slice, joint: Matrix) -> Matrix:
        return np.asarray(self._model_reference(block) @ joint[: self._shared] + joint[-1])

    def _weighted_normal(self) -> Matrix:
        normal = np.zeros((self._size, self._size))
        capture, reference = self.observations.capture, self.observations.reference
        runs, shared = self.observations.runs, self._shared
        if capture is not None:
            sums = RunningSums(shared, runs)
            for block in row_blocks(capture.run.size):
                run = self._runs_of(block)
                sums.add(self._capture_part(block), run, np.zeros(run.size))
            normal[:-1, :-1] += sums.sums().gram / self.capture_sigma_arcsec**2
        if reference is not None:
            sums = RunningSums(shared, 1)
            for block in row_blocks(reference.run.size):
                columns = self._model_reference(block)
                count = columns.shape[0]
                sums.add(columns, np.zeros(count, dtype=np.int64), np.zeros(count))
            places = np.append(np.arange(shared), self._size - 1)
            normal[np.ix_(places, places)] += sums.sums().gram / self.reference_sigma_arcsec**2
        offsets = np.arange(shared, shared + runs)
        normal[offsets, offsets] += 1.0 / self.observations.index_sigma_arcsec**2
        if self.solution.held:
            # Coefficients that were not fitted to these rows take nothing from any column.
            normal[:shared] = 0.0
            normal[:, :shared] = 0.0
        return normal

    @cached_property
    def _inverse(self) -> Matrix:
        _, inverse, _, _ = solve_symmetric(self._normal, np.zeros(self._size))
        return inverse

    def with_residuals(
        self, capture: NDArray[np.float64] | None, reference: NDArray[np.float64] | None
    ) -> Residuals:
        """The same model beside other residuals (surrogates), fitted out of them."""
        other = Residuals(self.solution)
        for name in ("_cached_capture", "_normal", "_inverse"):
            # The model's own matrices do not depend on the residuals.
            other.__dict__[name] = getattr(self, name)
        fitted = self._fitted_out(capture, reference)
        other.__dict__["capture_arcsec"], other.__dict__["reference_arcsec"] = fitted
        return other

    def _fitted_out(
        self, capture: NDArray[np.float64] | None, reference: NDArray[np.float64] | None
    ) -> tuple[NDArray[np.float64] | None, NDArray[np.float64] | None]:
        moment = np.zeros(self._size)
        if capture is not None:
            weight = 1.0 / self.capture_sigma_arcsec**2
            for block in row_blocks(capture.size):
                moment += weight * self._capture_moment(block, capture[block])
        if reference is not None:
            weight = 1.0 / self.reference_sigma_arcsec**2
            for block in row_blocks(reference.size):
                moment += weight * self._reference_moment(block, reference[block])
        solution = self._inverse @ moment
        if capture is not None:
            left = np.empty_like(capture)
            for block in row_blocks(capture.size):
                left[block] = capture[block] - self._capture_model(block, solution)
            capture = left
        if reference is not None:
            left = np.empty_like(reference)
            for block in row_blocks(reference.size):
                left[block] = reference[block] - self._reference_model(block, solution)
            reference = left
        return capture, reference

    def weighted_columns(
        self, effect: Effect, nonlinear: Nonlinear
    ) -> tuple[Matrix | None, Matrix | None]:
        """An effect's columns by channel, shape (rows, width), with the model projected out.

        They are divided by the variance of a row: their product with residuals is the moment that
        the gain is made of.
        """
        width = len(effect.column_names(self.observations))
        context = self.solution.context
        back = self._inverse @ self._cross_moment(effect, nonlinear, width)
        capture, reference = self.observations.capture, self.observations.reference
        of_capture = of_reference = None
        if capture is not None:
            of_capture = np.zeros((capture.run.size, width))
            for block in row_blocks(capture.run.size):
                columns = effect.capture_columns(capture.part(block), nonlinear, context)
                projected = -self._capture_model(block, back)
                if columns is not None:
                    projected = projected + columns
                of_capture[block] = projected / self.capture_sigma_arcsec**2
        if reference is not None:
            of_reference = np.zeros((reference.run.size, width))
            for block in row_blocks(reference.run.size):
                columns = self._effect_reference(effect, nonlinear, block)
                projected = columns - self._reference_model(block, back)
                of_reference[block] = projected / self.reference_sigma_arcsec**2
        return of_capture, of_reference

    def _cross_moment(self, effect: Effect, nonlinear: Nonlinear, width: int) -> Matrix:
        cross = np.zeros((self._size, width))
        context = self.solution.context
        capture, reference = self.observations.capture, self.observations.reference
        if capture is not None:
            for block in row_blocks(capture.run.size):
                columns = effect.capture_columns(capture.part(block), nonlinear, context)
                if columns is None:
                    break
                cross += self._capture_moment(block, columns) / self.capture_sigma_arcsec**2
        if reference is not None:
            for block in row_blocks(reference.run.size):
                columns = self._effect_reference(effect, nonlinear, block)
                cross += self._reference_moment(block, columns) / self.reference_sigma_arcsec**2
        return cross

    def score(self, effect: Effect, nonlinear: Nonlinear) -> Score:
        """Score test of an effect's whole block: its columns with the model projected out."""
        width = len(effect.column_names(self.observations))
        information, moment = np.zeros((width, width)), np.zeros(width)
        cross = self._cross_moment(effect, nonlinear, width)
        context = self.solution.context
        capture, reference = self.observations.capture, self.observations.reference
        if capture is not None:
            residual = self.capture_arcsec
            assert residual is not None
            weight = 1.0 / self.capture_sigma_arcsec**2
            for block in row_blocks(capture.run.size):
                columns = effect.capture_columns(capture.part(block), nonlinear, context)
                if columns is None:
                    break
                information += weight * columns.T @ columns
                moment += weight * columns.T @ residual[block]
        if reference is not None:
            residual = self.reference_arcsec
            assert residual is not None
            weight = 1.0 / self.reference_sigma_arcsec**2
            for block in row_blocks(reference.run.size):
                columns = self._effect_reference(effect, nonlinear, block)
                information += weight * columns.T @ columns
                moment += weight * columns.T @ residual[block]
        projected = information - cross.T @ self._inverse @ cross
        # What the model explains of the columns to within rounding is not theirs.
        alive = np.diag(projected) > 1e-9 * np.maximum(np.diag(information), 1e-300)
        kept = np.where(alive[:, None] & alive[None, :], projected, 0.0)
        coefficients, covariance, rank, _ = solve_symmetric(kept, np.where(alive, moment, 0.0))
        gain = float(np.where(alive, moment, 0.0) @ coefficients)
        return Score(max(gain, 0.0), rank, coefficients, covariance, moment, projected)


KEEP_BYTES = 200_000_000
