"""Holds a fitted model: coefficients of generalised least squares, predictions, uncertainties.

The inverse of the joint normal matrix of columns and tangents is the covariance of coefficients and
search parameters together (Seber and Wild, Nonlinear Regression, section 2.1). The uncertainty of
the search parameters follows from it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from arctrue.workbench.effects.base import FitContext, Parameter
from arctrue.workbench.inference.change_point import position_sigma_samples
from arctrue.workbench.inference.design_matrix import (
    Term,
    channel_prediction,
    channel_sums,
    every_row_sums,
    term_widths,
)
from arctrue.workbench.inference.directions import directions_of, undetermined_parameters
from arctrue.workbench.inference.fitted import Fitted
from arctrue.workbench.inference.named import labels, term_parameters
from arctrue.workbench.inference.tangents import refined_names, tangent_terms
from arctrue.workbench.noise.noise import Noise
from arctrue.workbench.numeric.least_squares import ChannelSums, Layout, Matrix
from arctrue.workbench.numeric.symmetric import solve_symmetric
from arctrue.workbench.observations import Observations


@dataclass(frozen=True)
class Solution(Fitted):
    """A model fitted to a set, with coefficients, covariance and noise."""

    @property
    def capture_sigma_arcsec(self) -> float | None:
        """Standard deviation of a capture row, with all parts of its noise."""
        return None if self.noise.capture is None else self.noise.capture.rms_arcsec

    @property
    def reference_sigma_arcsec(self) -> float | None:
        """Standard deviation of a reference row, with all parts of its noise."""
        return None if self.noise.reference is None else self.noise.reference.rms_arcsec

    @property
    def noise_is_unknown(self) -> bool:
        """True if the noise of no channel is known: too few rows for the coefficients, and no
        stated uncertainty.
        """
        channels = {"capture": self.observations.capture, "reference": self.observations.reference}
        return {name for name, rows in channels.items() if rows is not None} <= self.unknown_noise

    @property
    def searched_parts(self) -> list[slice]:
        """The slice of each term's continuous search parameters among the unknowns."""
        counts = [len(refined_names(term.effect)) for term in self.terms]
        ends = sum(self.widths) + np.cumsum(counts, dtype=int)
        return [slice(end - count, end) for end, count in zip(ends.tolist(), counts, strict=True)]

    @property
    def rows(self) -> int:
        """Number of rows in the likelihood, of both channels together."""
        observations = self.observations
        reference = observations.every_reference_row
        if not self.every_row:
            return observations.rows
        return observations.capture_rows + (0 if reference is None else reference.run.size)

    @property
    def bic(self) -> float:
        """Bayesian information criterion; each search parameter counts as one coefficient."""
        return float((self.rank + self.searched) * np.log(self.rows) - 2.0 * self.log_likelihood)

    @property
    def searched(self) -> int:
        """Number of parameters of the model that a search found."""
        return sum(term.searched for term in self.terms)

    def parameters(self) -> list[dict[str, Parameter]]:
        """Return the parameters of every term, with the names and units that reports show; a
        parameter that the rows do not determine has no uncertainty (NaN)."""
        covariance, sigmas = self._uncertainty
        return [
            {
                name: replace(item, sigma=float("nan"))
                if f"{label}.{name}" in self._undetermined
                else item
                for name, item in self._of_term(index, covariance, sigmas[index]).items()
            }
            for index, label in enumerate(labels(self.terms))
        ]

    def named_parameters(self, covariance: Matrix | None = None) -> dict[str, Parameter]:
        """Return every parameter under one name, with its standard uncertainty and unit.

        ``covariance``: covariance of all coefficients and, after them, of the continuous search
        parameters of each term; by default the covariance of the solution.
        """
        own, sigmas = self._uncertainty
        if covariance is not None:
            spread = np.sqrt(np.maximum(np.diag(covariance), 0.0))
            own, sigmas = covariance, [dict(of_term) for of_term in sigmas]
            for term, part, of_term in zip(self.terms, self.searched_parts, sigmas, strict=True):
                for name, sigma in zip(refined_names(term.effect), spread[part], strict=True):
                    if term.effect.step_at is None or name != term.effect.step_at[1]:
                        of_term[name] = float(sigma)
        return {
            f"{label}.{name}": item
            for index, label in enumerate(labels(self.terms))
            for name, item in self._of_term(index, own, sigmas[index]).items()
        }

    def _of_term(
        self, index: int, covariance: Matrix, sigmas: Mapping[str, float]
    ) -> dict[str, Parameter]:
        part, observations = self.part(index), self.observations
        return term_parameters(
            self.terms[index], self.coefficients[part], covariance[part, part], sigmas, observations
        )

    @cached_property
    def _undetermined(self) -> frozenset[str]:
        """Names of the parameters that the rows do not determine."""
        constants = self.observations.runs + (self.observations.reference is not None)
        joint = self.with_tangents
        if self.held or joint.rank >= sum(joint.widths) + constants:
            return frozenset()
        return frozenset(undetermined_parameters(self, directions_of(self)))

    @cached_property
    def with_tangents(self) -> Solution:
        """The model fitted together with the tangents of its search parameters, with the noise
        unchanged; the unknowns of the tangents follow those of the terms."""
        if not any(refined_names(term.effect) for term in self.terms):
            return self
        terms, observations = tangent_terms(self), self.observations
        context, noise = self.context, self.noise
        summed = every_row_sums if self.every_row else channel_sums
        return solve(
            terms,
            observations,
            context,
            noise,
            capture=summed(terms, observations, context, noise, capture=True),
            reference=summed(terms, observations, context, noise, capture=False),
        )

    @cached_property
    def _uncertainty(self) -> tuple[Matrix, list[dict[str, float]]]:
        return _joint_uncertainty(self)

    def capture_prediction_arcsec(self, with_offsets: bool = True) -> NDArray[np.float64]:
        """Return the model's prediction of R₂ − R₁ − α for every capture row."""
        rows = self.observations.capture
        assert rows is not None
        total = self._of_terms(capture=True)
        return total + rows.offsets_of_rows(self.run_offsets_arcsec) if with_offsets else total

    def _of_terms(self, *, capture: bool) -> NDArray[np.float64]:
        """Return the prediction of the terms alone; it is stored for further calls."""
        if capture not in self._predictions:
            found = channel_prediction(
                self.terms, self.coefficients, self.observations, self.context, capture=capture
            )
            found.setflags(write=False)
            self._predictions[capture] = found
        return self._predictions[capture]

    @cached_property
    def _predictions(self) -> dict[bool, NDArray[np.float64]]:
        return {}

    def reference_prediction_arcsec(self) -> NDArray[np.float64]:
        """Return the model's prediction of ε for every reference row."""
        assert self.observations.reference is not None
        return self._of_terms(capture=False) + self.reference_offset_arcsec

    def capture_residual_arcsec(self) -> NDArray[np.float64] | None:
        """Return measured minus predicted R₂ − R₁ − α; None without a capture."""
        rows = self.observations.capture
        if rows is None:
            return None
        return rows.difference_arcsec - self.capture_prediction_arcsec()

    def reference_residual_arcsec(self) -> NDArray[np.float64] | None:
        """Return measured minus predicted ε; None without a reference."""
        rows = self.observations.reference
        return None if rows is None else rows.error_arcsec - self.reference_prediction_arcsec()


@dataclass(frozen=True)
class Held:
    """Coefficients that are not fitted: their indices among the coefficients of all terms, and
    their values."""

    places: NDArray[np.int64]
    values: Matrix


def joint_normal(
    layout: Layout, noise: Noise, capture: ChannelSums | None, reference: ChannelSums | None
) -> tuple[Matrix, Matrix]:
    """Return normal matrix and right-hand side of both channels; the unknowns are coefficients of
    terms, run offsets, the constant a₀."""
    normal, moment = np.zeros((layout.size, layout.size)), np.zeros(layout.size)
    for sums, places in ((capture, layout.capture()), (reference, layout.reference())):
        if sums is not None:
            normal[np.ix_(places, places)] += sums.gram
            moment[places] += sums.moment
    offsets = np.arange(layout.shared, layout.shared + layout.runs)
    normal[offsets, offsets] += 1.0 / noise.index_variance
    return normal, moment


def _fixed_terms(normal: Matrix, moment: Matrix, held: Held) -> tuple[Matrix, Matrix, int, float]:
    """Solve as :func:`solve_symmetric` does, with known values for the unknowns in ``held``."""
    free = np.ones(moment.size, dtype=np.bool_)
    free[held.places] = False
    rest, of_rest, rank, condition = solve_symmetric(
        normal[np.ix_(free, free)], moment[free] - normal[np.ix_(free, ~free)] @ _sorted(held)
    )
    solution, covariance = np.zeros(moment.size), np.zeros(normal.shape)
    solution[free], solution[held.places] = rest, held.values
    covariance[np.ix_(free, free)] = of_rest
    return solution, covariance, rank, condition


def _sorted(held: Held) -> Matrix:
    """Return the values of ``held``, sorted by their indices among the coefficients."""
    return np.asarray(held.values[np.argsort(held.places)])


def solve(
    terms: Sequence[Term],
    observations: Observations,
    context: FitContext,
    noise: Noise,
    *,
    capture: ChannelSums | None,
    reference: ChannelSums | None,
    held: Held | None = None,
) -> Solution:
    """Return the solution of generalised least squares, from the channels' whitened sums.

    ``held``: coefficients that keep given values.
    """
    widths = term_widths(terms, observations)
    layout = Layout(sum(widths), observations.runs)
    normal, moment = joint_normal(layout, noise, capture, reference)
    offsets = np.arange(layout.shared, layout.shared + layout.runs)
    solution, covariance, rank, condition = (
        solve_symmetric(normal, moment) if held is None else _fixed_terms(normal, moment, held)
    )
    likelihood = -0.5 * float(np.sum(solution[offsets] ** 2)) / noise.index_variance
    likelihood -= 0.5 * layout.runs * float(np.log(noise.index_variance))
    for sums, places in ((capture, layout.capture()), (reference, layout.reference())):
        if sums is not None:
            square = sums.residual_square(solution[places])
            likelihood -= 0.5 * (square + sums.log_determinant)
    shared = slice(0, layout.shared)
    return Solution(
        terms=tuple(terms),
        observations=observations,
        context=context,
        widths=tuple(widths),
        coefficients=solution[shared],
        covariance=covariance[shared, shared],
        run_offsets_arcsec=solution[offsets],
        reference_offset_arcsec=float(solution[-1]),
        noise=noise,
        log_likelihood=likelihood,
        rank=rank,
        condition=condition,
    )


def context_of(solution: Solution) -> FitContext:
    """Return ε(ψ) of the disc-fixed terms of a solution, for columns that depend on it.

    Each coefficient is its posterior mean P·c/(P + σ²). The rows bound the prior variance P: by
    Parseval's theorem, the mean square of an order is at most P/2, the mean square of the measured
    error. Some orders are hardly determined by the heads' difference and the polygon's stations.
    Without this limit, the slope of such an order would be many times too large, and columns that
    depend on it would fit any noise.
    """
    bound = _largest_square_arcsec2(solution.observations)
    variance = np.maximum(np.diag(solution.covariance), 0.0)
    mean = solution.coefficients * (bound / (bound + variance) if bound > 0.0 else 1.0)
    places = range(len(solution.terms))
    return context_of_terms(solution.terms, [mean[solution.part(index)] for index in places])


def _largest_square_arcsec2(observations: Observations) -> float:
    """Return twice the mean square of the measured error in the channel where it is larger."""
    measured = [
        rows.measured_arcsec
        for rows in (observations.capture, observations.reference)
        if rows is not None and rows.run.size
    ]
    return max((2.0 * float(np.var(values)) for values in measured), default=0.0)


def context_of_terms(terms: Sequence[Term], coefficients: Sequence[Matrix]) -> FitContext:
    """Return ε(ψ) from the disc-fixed terms among ``terms``; ``coefficients`` has the values of
    each term."""
    orders: list[int] = []
    cosines: list[float] = []
    sines: list[float] = []
    at_angle: list[bool] = []
    known: dict[str, NDArray[np.float64]] = {}
    for term, values in zip(terms, coefficients, strict=True):
        found = term.effect.disc_orders(term.nonlinear)
        if term.effect.depends_on_model:
            known[term.effect.name] = values
        for place, order in enumerate(found):
            orders.append(order)
            cosines.append(float(values[2 * place]))
            sines.append(float(values[2 * place + 1]))
            at_angle.append(not term.effect.at_reading)
    return FitContext(
        np.array(cosines),
        np.array(sines),
        np.array(orders, dtype=np.int64),
        np.array(at_angle, dtype=np.bool_),
        known,
    )


def _joint_uncertainty(solution: Solution) -> tuple[Matrix, list[dict[str, float]]]:
    """Return the covariance of all coefficients, and the σ of the search parameters of each term.

    The coefficients' covariance includes the uncertainty of the search parameters: the phase of a
    line is less certain if its frequency is uncertain too. A search parameter that is an integer
    (an order, a run) has no σ.
    """
    covariance = solution.covariance
    sigmas: list[dict[str, float]] = [{} for _ in solution.terms]
    if solution.held:
        return covariance, sigmas
    joint, size = solution.with_tangents.covariance, sum(solution.widths)
    covariance = joint[:size, :size]
    spread = np.sqrt(np.maximum(np.diag(joint), 0.0))
    for term, own, of_term in zip(solution.terms, solution.searched_parts, sigmas, strict=True):
        for name, sigma in zip(refined_names(term.effect), spread[own].tolist(), strict=True):
            # A zero on the diagonal means that the data do not determine the parameter.
            of_term[name] = sigma or float("nan")
    for index, term in enumerate(solution.terms):
        if term.effect.step_at is not None:
            _, instant = term.effect.step_at
            sigmas[index][instant] = _instant_sigma_s(solution, index)
    return covariance, sigmas


def _instant_sigma_s(solution: Solution, index: int) -> float:
    """Return the σ of a step's instant: the standard deviation of the number of the sample at which
    the step occurs, times the time between two samples."""
    step = float(solution.coefficients[solution.part(index)][0])
    of_rows = solution.noise.capture
    noise = 0.0 if of_rows is None else of_rows.white_rms_arcsec
    scatter = position_sigma_samples(abs(step), noise)
    within_s = float(np.hypot(scatter, np.sqrt(1.0 / 12.0)) * solution.observations.sample_period_s)
    # σ is at most the standard deviation of an instant that is equally probable anywhere in the
    # run.
    return min(within_s, solution.observations.longest_run_s / float(np.sqrt(12.0)))
