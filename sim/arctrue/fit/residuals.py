"""What a fitted model leaves, and how much of it further columns would take."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from arctrue.effects.base import Effect, Nonlinear
from arctrue.fit.normal import (
    Matrix,
    capture_block,
    reference_block,
    row_blocks,
)
from arctrue.fit.solution import Solution
from arctrue.fit.symmetric import solve_symmetric
from arctrue.observations import Observations


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

    def _model_capture(self, block: slice) -> Matrix:
        solution = self.solution
        return capture_block(
            solution.terms, solution.widths, self.observations, block, solution.context
        )

    def _model_reference(self, block: slice) -> Matrix:
        solution = self.solution
        return reference_block(
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

    def _spread_capture(self, matrix: Matrix) -> Matrix:
        """Columns of the capture's model part in the joint layout."""
        return np.hstack([matrix, np.zeros((matrix.shape[0], 1))])

    def _spread_reference(self, matrix: Matrix) -> Matrix:
        runs = np.zeros((matrix.shape[0], self.observations.runs))
        return np.hstack([matrix[:, :-1], runs, matrix[:, -1:]])

    @cached_property
    def _cached_capture(self) -> Matrix | None:
        """The model's capture columns, when they are small enough to keep."""
        rows = self.observations.capture
        if rows is None or rows.run.size * (self._size) * 8 > KEEP_BYTES:
            return None
        return np.vstack([self._model_capture(block) for block in row_blocks(rows.run.size)])

    def _capture_part(self, block: slice) -> Matrix:
        cached = self._cached_capture
        return self._model_capture(block) if cached is None else cached[block]

    def _weighted_normal(self) -> Matrix:
        normal = np.zeros((self._size, self._size))
        capture, reference = self.observations.capture, self.observations.reference
        if capture is not None:
            for block in row_blocks(capture.run.size):
                matrix = self._spread_capture(self._capture_part(block))
                normal += matrix.T @ matrix / self.capture_sigma_arcsec**2
        if reference is not None:
            for block in row_blocks(reference.run.size):
                matrix = self._spread_reference(self._model_reference(block))
                normal += matrix.T @ matrix / self.reference_sigma_arcsec**2
        offsets = np.arange(self._shared, self._shared + self.observations.runs)
        normal[offsets, offsets] += 1.0 / self.observations.index_sigma_arcsec**2
        if self.solution.held:
            # Coefficients that were not fitted to these rows take nothing from any column.
            normal[: self._shared] = 0.0
            normal[:, : self._shared] = 0.0
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
            for block in row_blocks(capture.size):
                model = self._capture_part(block)
                moment[: model.shape[1]] += model.T @ capture[block] / self.capture_sigma_arcsec**2
        if reference is not None:
            for block in row_blocks(reference.size):
                spread = self._spread_reference(self._model_reference(block))
                moment += spread.T @ reference[block] / self.reference_sigma_arcsec**2
        solution = self._inverse @ moment
        if capture is not None:
            left = np.empty_like(capture)
            for block in row_blocks(capture.size):
                model = self._capture_part(block)
                left[block] = capture[block] - model @ solution[: model.shape[1]]
            capture = left
        if reference is not None:
            left = np.empty_like(reference)
            for block in row_blocks(reference.size):
                spread = self._spread_reference(self._model_reference(block))
                left[block] = reference[block] - spread @ solution
            reference = left
        return capture, reference

    def surrogate_gains(
        self,
        effect: Effect,
        nonlinear: Nonlinear,
        captures: Iterator[NDArray[np.float64]] | None,
        references: Iterator[NDArray[np.float64]] | None,
        count: int,
    ) -> NDArray[np.float64]:
        """Gain of one linear block on each surrogate: its columns are projected only once."""
        width = len(effect.column_names(self.observations))
        score = self.score(effect, nonlinear)
        context = self.solution.context
        weighted_capture = weighted_reference = None
        cross = self._cross_moment(effect, nonlinear, width)
        back = self._inverse @ cross
        capture, reference = self.observations.capture, self.observations.reference
        if capture is not None and captures is not None:
            weighted_capture = np.zeros((capture.run.size, width))
            for block in row_blocks(capture.run.size):
                model = self._capture_part(block)
                columns = effect.capture_columns(capture.part(block), nonlinear, context)
                projected = -model @ back[: model.shape[1]]
                if columns is not None:
                    projected = projected + columns
                weighted_capture[block] = projected / self.capture_sigma_arcsec**2
        if reference is not None and references is not None:
            weighted_reference = np.zeros((reference.run.size, width))
            for block in row_blocks(reference.run.size):
                columns = self._effect_reference(effect, nonlinear, block)
                spread = self._spread_reference(self._model_reference(block))
                weighted_reference[block] = (columns - spread @ back) / (
                    self.reference_sigma_arcsec**2
                )
        gains = np.empty(count)
        for index in range(count):
            moment = np.zeros(width)
            if weighted_capture is not None and captures is not None:
                moment += next(captures) @ weighted_capture
            if weighted_reference is not None and references is not None:
                moment += next(references) @ weighted_reference
            gains[index] = moment @ score.covariance @ moment
        return gains

    def _cross_moment(self, effect: Effect, nonlinear: Nonlinear, width: int) -> Matrix:
        cross = np.zeros((self._size, width))
        context = self.solution.context
        capture, reference = self.observations.capture, self.observations.reference
        if capture is not None:
            for block in row_blocks(capture.run.size):
                columns = effect.capture_columns(capture.part(block), nonlinear, context)
                if columns is None:
                    break
                model = self._capture_part(block)
                cross[: model.shape[1]] += model.T @ columns / self.capture_sigma_arcsec**2
        if reference is not None:
            for block in row_blocks(reference.run.size):
                columns = self._effect_reference(effect, nonlinear, block)
                spread = self._spread_reference(self._model_reference(block))
                cross += spread.T @ columns / self.reference_sigma_arcsec**2
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
