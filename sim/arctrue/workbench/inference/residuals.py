"""Calculates the residuals of a fitted model, and the part of their variance that columns of other
effects explain."""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from dataclasses import replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from arctrue.base.units import RAD_PER_ARCSEC
from arctrue.workbench.effects.base import Effect, Nonlinear
from arctrue.workbench.inference.columns_side_by_side import of_waves, whitened_side_by_side
from arctrue.workbench.inference.design_matrix import Term, term_columns, whitened_rows
from arctrue.workbench.inference.same_place import Visits
from arctrue.workbench.inference.score_test import (
    LEAST_OWN_SHARE,
    Score,
    above_the_phase_noise,
    own_directions,
)
from arctrue.workbench.inference.solution import Solution, context_of
from arctrue.workbench.inference.visits_of_places import visits_of
from arctrue.workbench.noise.repeats import row_noise_arcsec
from arctrue.workbench.noise.row_noise import RowNoise
from arctrue.workbench.noise.whiteness import Whiteness, whiteness
from arctrue.workbench.numeric.least_squares import Layout, Matrix, WhitenedRows
from arctrue.workbench.numeric.symmetric import log_determinant, solve_symmetric
from arctrue.workbench.observations import Observations

COLUMNS_TOGETHER = 24
"""Largest number of columns that are whitened and multiplied with the model's columns at once."""
TIMES_THE_NOISE = 4.0
"""Smallest ratio of squares: the part of a signal-period wave that the model does not explain must
be at least twice its phase noise."""
MOST_OWN_SHARE = 0.5
"""Upper bound of the limit that follows from the phase noise: if the model leaves a larger share of
a block, the block is always tested."""


def _combined(gram: Matrix, factors: Matrix | None) -> Matrix:
    """Return the Gram matrix of combinations of columns from the Gram matrix of these columns."""
    return gram if factors is None else factors.T @ gram @ factors


class Residuals:
    """Residuals of a solution, and the arrays that scans and score tests need."""

    def __init__(self, solution: Solution) -> None:
        """Store ``solution``; the arrays are computed when they are first used."""
        self.solution = solution
        self.observations: Observations = solution.observations

    @cached_property
    def capture_arcsec(self) -> NDArray[np.float64] | None:
        """Residuals of the capture, shape (capture rows,)."""
        return self.solution.capture_residual_arcsec()

    @cached_property
    def reference_arcsec(self) -> NDArray[np.float64] | None:
        """Residuals of the reference, shape (reference rows,)."""
        return self.solution.reference_residual_arcsec()

    @cached_property
    def visits(self) -> Visits | None:
        """The passes of the reference at equal places; None if no second pass repeats them."""
        return visits_of(self.solution)

    @cached_property
    def capture_whitened(self) -> NDArray[np.float64] | None:
        """Whitened residuals of the capture: their noise has variance one and no correlation."""
        return self._whitened(self.capture_arcsec, self.solution.noise.capture)

    @cached_property
    def reference_whitened(self) -> NDArray[np.float64] | None:
        """Whitened residuals of the reference: their noise has variance one and no correlation."""
        return self._whitened(self.reference_arcsec, self.solution.noise.reference)

    @cached_property
    def capture_whiteness(self) -> Whiteness | None:
        """Tests whether the whitened residuals of the capture are white; None for too few rows."""
        return self._whiteness(self.capture_whitened, self._designs[0])

    @cached_property
    def reference_whiteness(self) -> Whiteness | None:
        """Tests whether the whitened residuals of the reference are white; None for too few
        rows."""
        return self._whiteness(self.reference_whitened, self._designs[1])

    def _whiteness(self, values: Matrix | None, design: WhitenedRows | None) -> Whiteness | None:
        if values is None:
            return None
        if design is None or self.solution.held:
            # Coefficients that were not fitted to these rows absorb no noise of these rows.
            return whiteness(values)
        return whiteness(values, design.every_column)

    @staticmethod
    def _whitened(
        values: NDArray[np.float64] | None, noise: RowNoise | None
    ) -> NDArray[np.float64] | None:
        return None if values is None or noise is None else noise.whiten(values)

    @cached_property
    def capture_precise(self) -> NDArray[np.float64] | None:
        """C⁻¹ times the residuals of the capture; its product with a column is the column's
        moment."""
        values, noise = self.capture_whitened, self.solution.noise.capture
        return None if values is None or noise is None else noise.precise(values)

    @cached_property
    def reference_precise(self) -> NDArray[np.float64] | None:
        """C⁻¹ times the residuals of the reference; its product with a column is the column's
        moment."""
        values, noise = self.reference_whitened, self.solution.noise.reference
        return None if values is None or noise is None else noise.precise(values)

    @cached_property
    def _designs(self) -> tuple[WhitenedRows | None, WhitenedRows | None]:
        solution = self.solution
        capture, reference = (
            whitened_rows(
                solution.terms, self.observations, solution.context, solution.noise, capture=is_it
            )
            for is_it in (True, False)
        )
        return capture, reference

    @cached_property
    def capture_precise_design(self) -> WhitenedRows | None:
        """C⁻¹ times the model's columns and ones in the capture; None without a capture."""
        design, noise = self._designs[0], self.solution.noise.capture
        if design is None or noise is None:
            return None
        columns, ones = noise.precise(design.columns), noise.precise(design.ones)
        return replace(design, columns=columns, ones=ones)

    def explained_squares(self, cross: Matrix) -> Matrix:
        """Return, for each of n columns of the capture, the part of its weighted sum of squares
        that the model explains, (n,); ``cross``: products of the model's columns in the capture
        with these columns, shape (columns of the model, n)."""
        places = self._layout.capture()
        inside = self._inverse[np.ix_(places, places)]
        return np.asarray(np.sum(cross * (inside @ cross), axis=0))

    @property
    def reference_design(self) -> WhitenedRows | None:
        """Whitened columns of the model in the reference; None without a reference."""
        return self._designs[1]

    @cached_property
    def _layout(self) -> Layout:
        return Layout(sum(self.solution.widths), self.observations.runs)

    @cached_property
    def _normal(self) -> Matrix:
        """Normal matrix of the model; the unknowns are coefficients of terms, run offsets, the
        constant."""
        layout = self._layout
        normal = np.zeros((layout.size, layout.size))
        for design, places in zip(
            self._designs, (layout.capture(), layout.reference()), strict=True
        ):
            if design is not None:
                normal[np.ix_(places, places)] += design.gram
        offsets = np.arange(layout.shared, layout.shared + layout.runs)
        normal[offsets, offsets] += 1.0 / self.solution.noise.index_variance
        if self.solution.held:
            # Coefficients that were not fitted to these rows absorb no part of a column.
            normal[: layout.shared] = 0.0
            normal[:, : layout.shared] = 0.0
        return normal

    @cached_property
    def _inverse(self) -> Matrix:
        _, inverse, _, _ = solve_symmetric(self._normal, np.zeros(self._layout.size))
        return inverse

    @property
    def joint_system(self) -> tuple[Layout, Matrix, Matrix]:
        """Layout of the unknowns of the model in both channels, their normal matrix, and the moment
        of the residuals along their columns."""
        return self._layout, self._normal, self._left_moment

    def _joint_moment(self, capture: Matrix | None, reference: Matrix | None) -> Matrix:
        """Multiply whitened values of both channels with the model's columns (joint layout)."""
        layout = self._layout
        there = capture if capture is not None else reference
        assert there is not None
        total = np.zeros((layout.size, *there.shape[1:]))
        for design, values, places in zip(
            self._designs,
            (capture, reference),
            (layout.capture(), layout.reference()),
            strict=True,
        ):
            if design is not None and values is not None:
                total[places] += design.moment(values)
        return total

    @cached_property
    def _left_moment(self) -> Matrix:
        """Moment of the residuals along the model's own columns; zero after a fit.

        Columns that depend on the model change with the model's coefficients. A solution that was
        fitted with the earlier columns is therefore only nearly the least-squares solution.
        """
        layout, solution = self._layout, self.solution
        if solution.held:
            return np.zeros(layout.size)
        total = self._joint_moment(self.capture_whitened, self.reference_whitened)
        offsets = np.arange(layout.shared, layout.shared + layout.runs)
        total[offsets] -= solution.run_offsets_arcsec / solution.noise.index_variance
        return total

    def with_residuals(
        self, capture: NDArray[np.float64] | None, reference: NDArray[np.float64] | None
    ) -> Residuals:
        """Return the same model with the residuals that remain after a fit of the model to other
        values, such as draws of the noise."""
        other = Residuals(self.solution)
        for name in ("_designs", "_normal", "_inverse", "_reading_noise_arcsec"):
            # The model's own matrices, and the noise of the set, do not depend on the residuals.
            other.__dict__[name] = getattr(self, name)
        # After a fit, the other residuals have no moment along the model's columns.
        other.__dict__["_left_moment"] = np.zeros(self._layout.size)
        noise, layout = self.solution.noise, self._layout
        white = [self._whitened(capture, noise.capture), self._whitened(reference, noise.reference)]
        found = self._inverse @ self._joint_moment(white[0], white[1])
        for name, values, whitened, of_rows, design, places in (
            ("capture", capture, white[0], noise.capture, self._designs[0], layout.capture()),
            (
                "reference", reference, white[1], noise.reference, self._designs[1],
                layout.reference(),
            ),
        ):  # fmt: skip
            if values is None or whitened is None or of_rows is None or design is None:
                other.__dict__[f"{name}_arcsec"] = None
                continue
            left = whitened - design.model(found[places])
            other.__dict__[f"{name}_whitened"] = left
            other.__dict__[f"{name}_arcsec"] = of_rows.coloured(left)
        return other

    def whitened_columns(
        self, effect: Effect, nonlinear: Nonlinear
    ) -> tuple[Matrix | None, Matrix | None]:
        """Return the whitened columns of one effect by channel; None for a channel to which the
        effect adds nothing."""
        term, noise = Term(effect, nonlinear), self.solution.noise
        found: list[Matrix | None] = []
        for rows, of_rows, is_it in (
            (self.observations.capture, noise.capture, True),
            (self.observations.reference, noise.reference, False),
        ):
            columns = None
            if rows is not None and of_rows is not None:
                columns = term_columns(
                    term, self.observations, self.solution.context, capture=is_it
                )
            found.append(None if columns is None or of_rows is None else of_rows.whiten(columns))
        return found[0], found[1]

    def score(self, effect: Effect, nonlinear: Nonlinear) -> Score:
        """Test the whole block of an effect's columns by its score, with the model projected out.

        The score is stored, because searches, rankings and sizes use it again.
        """
        return self.scores([(effect, nonlinear)])[0]

    def reference_excess_arcsec2(self, effect: Effect, nonlinear: Nonlinear) -> float:
        """Return the mean square of the reference's residuals, with an effect in the model, minus
        that of the noise of the repeats; 0 without a reference."""
        grown = self.solution_with(effect, nonlinear, self.score(effect, nonlinear))
        left = grown.reference_residual_arcsec()
        if left is None:
            return 0.0
        rms = float(np.sqrt(np.mean(left**2)))
        return rms**2 - row_noise_arcsec(self.observations, left, "reference", rms) ** 2

    def scores(self, asked: Sequence[tuple[Effect, Nonlinear]]) -> list[Score]:
        """Test several effects by their scores; testing them together takes less time than one by
        one."""
        keys = [(id(effect), tuple(sorted(place.items()))) for effect, place in asked]
        waiting = {
            key: item for key, item in zip(keys, asked, strict=True) if key not in self._scores
        }
        together: list[tuple[Hashable, Effect, Nonlinear]] = []
        widths: dict[Hashable, int] = {}
        for key, (effect, place) in waiting.items():
            combined = of_waves(effect, self.observations)
            own: dict[Hashable, int] = {key: len(effect.column_names(self.observations))}
            if combined is not None:
                own = {wave.key: wave.width for wave in combined.waves}
            if together and sum((widths | own).values()) > COLUMNS_TOGETHER:
                self._work_out(together)
                together, widths = [], {}
            together.append((key, effect, place))
            widths |= own
        if together:
            self._work_out(together)
        return [self._scores[key][1] for key in keys]

    @cached_property
    def _scores(self) -> dict[Hashable, tuple[Effect, Score]]:
        """Scores with their effects: while an effect is kept, no other effect gets its id."""
        return {}

    def _work_out(self, asked: Sequence[tuple[Hashable, Effect, Nonlinear]]) -> None:
        widths = [len(effect.column_names(self.observations)) for _, effect, _ in asked]
        ends = np.cumsum(widths)
        parts = [slice(end - width, end) for end, width in zip(ends, widths, strict=True)]
        moment, cross = np.zeros(ends[-1]), np.zeros((self._layout.size, ends[-1]))
        information = [np.zeros((width, width)) for width in widths]
        squares = np.zeros(len(asked))
        for is_it, residual, design, places in (
            (True, self.capture_whitened, self._designs[0], self._layout.capture()),
            (False, self.reference_whitened, self._designs[1], self._layout.reference()),
        ):
            if residual is None or design is None:
                continue
            found, inside = whitened_side_by_side(self.solution, asked, capture=is_it)
            if found is None:
                continue
            of_residual, of_design = found.T @ residual, design.moment(found)
            grams: dict[tuple[int, ...], Matrix] = {}
            for one in inside:
                if one.columns not in grams:
                    first, last = one.columns[0], one.columns[-1] + 1
                    in_a_row = last - first == len(one.columns)
                    block = found[:, first:last] if in_a_row else found[:, one.columns]
                    grams[one.columns] = block.T @ block
                squares[one.number] += one.square
                part, at = parts[one.number], list(one.columns)
                information[one.number] += _combined(grams[one.columns], one.factors)
                moment[part] += (
                    of_residual[at] if one.factors is None else one.factors.T @ of_residual[at]
                )
                of_columns = of_design[:, at]
                cross[places, part] += (
                    of_columns if one.factors is None else of_columns @ one.factors
                )
        for (key, effect, _), part, own, square in zip(
            asked, parts, information, squares, strict=True
        ):
            least = self._least_own_share(effect), self._phase_noise_squares(effect, own, square)
            self._scores[key] = (effect, self._test(own, moment[part], cross[:, part], *least))

    def _least_own_share(self, effect: Effect) -> float:
        """Return the share of a block's weighted squares that noise of the measured angles can
        explain."""
        order = max(effect.electrical_orders(self.observations), default=0.0)
        if order == 0.0:
            return LEAST_OWN_SHARE
        in_phase = TIMES_THE_NOISE * (order * self._reading_noise_arcsec * RAD_PER_ARCSEC) ** 2
        return float(np.clip(in_phase, LEAST_OWN_SHARE, MOST_OWN_SHARE))

    def _phase_noise_squares(self, effect: Effect, information: Matrix, square: float) -> Matrix:
        """Return the weighted squares that the noise of the readings adds to each wave of the
        signal phase, shape (columns,); an empty array for other effects.

        The derivative of the wave with respect to the reading in radians is its electrical order.
        After whitening, the noise of the readings has the mean square 1 in each row. The mean
        square of its effect on the wave is therefore the square of that derivative. ``square``: sum
        of the squares of one wave over the rows. The result is at most MOST_OWN_SHARE of the
        largest weighted sum of squares of the block's columns.
        """
        orders = np.asarray(effect.electrical_orders(self.observations), dtype=np.float64)
        noise = TIMES_THE_NOISE * (orders * RAD_PER_ARCSEC) ** 2 * square
        return np.minimum(noise, MOST_OWN_SHARE * float(np.max(np.diag(information), initial=0.0)))

    @cached_property
    def _reading_noise_arcsec(self) -> float:
        """Noise of a row in the noisier of the two channels, from the scatter of its repeats.

        The fitted noise is not used: if the model lacks an effect, that noise contains the effect,
        which is not noise of the phase.
        """
        found = [0.0]
        for channel, values in (
            ("capture", self.capture_arcsec),
            ("reference", self.reference_arcsec),
        ):
            if values is not None:
                rms = float(np.sqrt(np.mean(values**2)))
                found.append(row_noise_arcsec(self.observations, values, channel, rms))
        return max(found)

    def _test(
        self, information: Matrix, moment: Matrix, cross: Matrix, least: float, noise: Matrix
    ) -> Score:
        projected = information - cross.T @ self._inverse @ cross
        moment = moment - cross.T @ (self._inverse @ self._left_moment)
        projected, moment = own_directions(information, projected, moment, least)
        if noise.size:
            projected, moment = above_the_phase_noise(projected, moment, noise)
        # A column that the model explains, apart from rounding, is left out.
        alive = np.diag(projected) > 1e-9 * np.maximum(np.diag(information), 1e-300)
        kept = np.where(alive[:, None] & alive[None, :], projected, 0.0)
        moment = np.where(alive, moment, 0.0)
        coefficients, covariance, rank, _ = solve_symmetric(kept, moment)
        gain = float(moment @ coefficients)
        own_share = float(np.trace(projected)) / max(float(np.trace(information)), 1e-300)
        return Score(
            max(gain, 0.0), rank, coefficients, covariance, moment, projected, cross, own_share
        )

    @cached_property
    def log_determinant(self) -> float:
        """Log determinant of the normal matrix, over the directions that the data determine."""
        return log_determinant(self._normal)

    def projected(
        self, effect: Effect, nonlinear: Nonlinear, score: Score
    ) -> tuple[tuple[Matrix | None, Matrix | None], Matrix]:
        """Return C⁻¹·z by channel, and the run offsets in z, arcseconds; z is the sum of a scored
        effect's columns times their coefficients, with the model projected out."""
        layout, noise = self._layout, self.solution.noise
        back = self._inverse @ (score.cross @ score.coefficients)
        found: list[Matrix | None] = []
        for columns, design, of_rows, places in zip(
            self.whitened_columns(effect, nonlinear),
            self._designs,
            (noise.capture, noise.reference),
            (layout.capture(), layout.reference()),
            strict=True,
        ):
            if design is None or of_rows is None:
                found.append(None)
                continue
            own = -design.model(back[places])
            if columns is not None:
                own = own + columns @ score.coefficients
            found.append(of_rows.precise(own))
        return (found[0], found[1]), -back[layout.shared : layout.shared + layout.runs]

    def projected_columns(
        self, effect: Effect, nonlinear: Nonlinear, score: Score
    ) -> tuple[Matrix | None, Matrix | None]:
        """Return the whitened columns of a scored effect with the model projected out, by
        channel."""
        layout = self._layout
        back = self._inverse @ score.cross
        found: list[Matrix | None] = []
        for columns, design, places in zip(
            self.whitened_columns(effect, nonlinear),
            self._designs,
            (layout.capture(), layout.reference()),
            strict=True,
        ):
            if design is None:
                found.append(None)
                continue
            own = -design.model(back[places])
            found.append(own if columns is None else columns + own)
        return found[0], found[1]

    def solution_with(self, effect: Effect, nonlinear: Nonlinear, score: Score) -> Solution:
        """Return the solution of the model with one more effect, whose search parameters are not
        fitted.

        The solution equals a fit with this noise, and is computed from the sums of the score test.
        """
        solution, layout = self.solution, self._layout
        shift = self._inverse @ score.cross
        joint = np.concatenate(
            [solution.coefficients, solution.run_offsets_arcsec, [solution.reference_offset_arcsec]]
        )
        joint = joint - shift @ score.coefficients
        offsets = np.arange(layout.shared, layout.shared + layout.runs)
        spread = self._inverse + shift @ score.covariance @ shift.T
        shared, width = layout.shared, score.coefficients.size
        covariance = np.zeros((shared + width, shared + width))
        covariance[:shared, :shared] = spread[:shared, :shared]
        covariance[shared:, shared:] = score.covariance
        covariance[:shared, shared:] = -(shift @ score.covariance)[:shared]
        covariance[shared:, :shared] = covariance[:shared, shared:].T
        grown = replace(
            solution,
            terms=(*solution.terms, Term(effect, dict(nonlinear))),
            widths=(*solution.widths, width),
            coefficients=np.concatenate([joint[:shared], score.coefficients]),
            covariance=covariance,
            run_offsets_arcsec=joint[offsets],
            reference_offset_arcsec=float(joint[-1]),
            log_likelihood=solution.log_likelihood + 0.5 * score.gain,
            rank=solution.rank + score.rank,
        )
        return replace(grown, context=context_of(grown))
