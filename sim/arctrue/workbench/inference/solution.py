"""The fit of a model to both channels, as one likelihood.

y = X·b + run offsets + noise. The offsets of the runs are random with the index repeatability
as their prior (±1 count of each head, so what lives on the level of runs is judged against the
runs); the noise is normal with one standard deviation a channel, taken where the likelihood of
that channel has its maximum.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from arctrue.workbench.effects.base import FitContext, Parameter
from arctrue.workbench.inference.normal import (
    ChannelSums,
    Matrix,
    Term,
    capture_columns,
    capture_sums,
    reference_columns,
    reference_sums,
    row_blocks,
    term_widths,
)
from arctrue.workbench.inference.symmetric import solve_symmetric
from arctrue.workbench.observations import Observations

NOISE_ROUNDS = 12
NOISE_FLOOR_ARCSEC = 1e-6


@dataclass(frozen=True)
class Solution:
    """A fitted model."""

    terms: tuple[Term, ...]
    observations: Observations
    context: FitContext
    widths: tuple[int, ...]
    coefficients: Matrix
    """Of all terms, in their order."""
    covariance: Matrix
    run_offsets_arcsec: Matrix
    reference_offset_arcsec: float
    capture_sigma_arcsec: float | None
    reference_sigma_arcsec: float | None
    log_likelihood: float
    rank: int
    """Number of combinations of coefficients that the data determine."""
    condition: float
    every_row: bool = False
    """The coefficients come from every row of a capture of which only a part is worked on."""
    held: bool = False
    """The coefficients are those of another set: only offsets were fitted to this one."""

    def part(self, index: int) -> slice:
        """Where the coefficients of one term are."""
        start = sum(self.widths[:index])
        return slice(start, start + self.widths[index])

    @property
    def bic(self) -> float:
        """Bayesian information criterion; each search parameter counts as one more."""
        rows = self.observations.rows
        searched = sum(len(term.nonlinear) for term in self.terms)
        return float((self.rank + searched) * np.log(rows) - 2.0 * self.log_likelihood)

    def parameters(self) -> list[dict[str, Parameter]]:
        """Of every term, as people read them."""
        covariance, searched = self._uncertainty
        found = []
        for index, term in enumerate(self.terms):
            part = self.part(index)
            own = term.effect.parameters(
                self.coefficients[part],
                covariance[part, part],
                term.nonlinear,
                self.observations,
            )
            for name, sigma in searched[index].items():
                if name in own:
                    own[name] = replace(own[name], sigma=sigma)
            found.append(own)
        return found

    @cached_property
    def _uncertainty(self) -> tuple[Matrix, list[dict[str, float]]]:
        from arctrue.workbench.inference.search_parameters import joint_uncertainty

        return joint_uncertainty(self)

    def capture_prediction_arcsec(self, with_offsets: bool = True) -> NDArray[np.float64]:
        """R₂ − R₁ − α that the model gives for every capture row."""
        rows = self.observations.capture
        assert rows is not None
        total = np.empty(rows.run.size)
        for block in row_blocks(total.size):
            columns, part = capture_columns(
                self.terms, self.widths, self.observations, block, self.context
            )
            total[block] = columns @ self.coefficients
            if with_offsets:
                total[block] += self.run_offsets_arcsec[part.run]
        return total

    def reference_prediction_arcsec(self) -> NDArray[np.float64]:
        """ε that the model gives for every reference row."""
        rows = self.observations.reference
        assert rows is not None
        total = np.empty(rows.run.size)
        for block in row_blocks(total.size):
            columns = reference_columns(
                self.terms, self.widths, self.observations, block, self.context
            )
            total[block] = columns @ self.coefficients + self.reference_offset_arcsec
        return total

    def capture_residual_arcsec(self, with_offsets: bool = True) -> NDArray[np.float64] | None:
        """Measured less model; None without a capture."""
        rows = self.observations.capture
        if rows is None:
            return None
        return rows.difference_arcsec - self.capture_prediction_arcsec(with_offsets)

    def reference_residual_arcsec(self) -> NDArray[np.float64] | None:
        """Measured less model; None without a reference."""
        rows = self.observations.reference
        return None if rows is None else rows.error_arcsec - self.reference_prediction_arcsec()


@dataclass(frozen=True)
class _Layout:
    """Where each channel's columns lie in the joint system: terms, run offsets, constant."""

    shared: int
    runs: int

    @property
    def size(self) -> int:
        return self.shared + self.runs + 1

    def capture(self) -> NDArray[np.int64]:
        return np.arange(self.shared + self.runs)

    def reference(self) -> NDArray[np.int64]:
        return np.append(np.arange(self.shared), self.shared + self.runs)


def solve(
    terms: Sequence[Term],
    observations: Observations,
    context: FitContext,
    *,
    capture: ChannelSums | None,
    reference: ChannelSums | None,
    fixed_sigma: tuple[float | None, float | None] | None = None,
) -> Solution:
    """Coefficients and noise at the maximum of the likelihood, from the channels' sums.

    ``fixed_sigma`` holds the noise of (capture, reference) instead of estimating it.
    """
    widths = term_widths(terms, observations)
    layout = _Layout(sum(widths), observations.runs)
    sigma = [
        fixed if fixed is not None else _start_sigma(sums)
        for fixed, sums in zip(fixed_sigma or (None, None), (capture, reference), strict=True)
    ]
    precision = 1.0 / observations.index_sigma_arcsec**2
    for _ in range(NOISE_ROUNDS):
        normal, moment = np.zeros((layout.size, layout.size)), np.zeros(layout.size)
        for sums, places, error in (
            (capture, layout.capture(), sigma[0]),
            (reference, layout.reference(), sigma[1]),
        ):
            if sums is not None:
                normal[np.ix_(places, places)] += sums.gram / error**2
                moment[places] += sums.moment / error**2
        offsets = np.arange(layout.shared, layout.shared + layout.runs)
        normal[offsets, offsets] += precision
        solution, covariance, rank, condition = solve_symmetric(normal, moment)
        before = list(sigma)
        squares = [
            0.0 if sums is None else sums.residual_square(solution[places])
            for sums, places in ((capture, layout.capture()), (reference, layout.reference()))
        ]
        if fixed_sigma is None:
            sigma = [
                error if sums is None else _estimated_sigma(square, sums, covariance, places, error)
                for square, sums, places, error in (
                    (squares[0], capture, layout.capture(), sigma[0]),
                    (squares[1], reference, layout.reference(), sigma[1]),
                )
            ]
        if np.allclose(before, sigma, rtol=1e-6):
            break
    likelihood = -0.5 * precision * float(np.sum(solution[offsets] ** 2))
    for sums, square, error in ((capture, squares[0], sigma[0]), (reference, squares[1], sigma[1])):
        if sums is not None:
            likelihood -= sums.rows * np.log(error) + 0.5 * square / error**2
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
        capture_sigma_arcsec=None if capture is None else sigma[0],
        reference_sigma_arcsec=None if reference is None else sigma[1],
        log_likelihood=likelihood,
        rank=rank,
        condition=condition,
    )


def _start_sigma(sums: ChannelSums | None) -> float:
    if sums is None or sums.rows == 0:
        return 1.0
    solution, _, _, _ = solve_symmetric(sums.gram, sums.moment)
    return max(float(np.sqrt(sums.residual_square(solution) / sums.rows)), NOISE_FLOOR_ARCSEC)


def _estimated_sigma(
    square: float, sums: ChannelSums, covariance: Matrix, places: NDArray[np.int64], error: float
) -> float:
    """Noise with the degrees of freedom that this channel spends: trace of its hat matrix."""
    spent = float(np.sum(covariance[np.ix_(places, places)] * sums.gram)) / error**2
    freedom = max(sums.rows - spent, 1.0)
    return max(float(np.sqrt(square / freedom)), NOISE_FLOOR_ARCSEC)


def fit(
    terms: Sequence[Term],
    observations: Observations,
    context: FitContext | None = None,
    *,
    keep_capture: NDArray[np.bool_] | None = None,
    keep_reference: NDArray[np.bool_] | None = None,
    every_row: bool = False,
) -> Solution:
    """Fit terms whose search parameters are settled; columns that depend on the model iterate.

    ``keep_…`` masks leave rows out. A channel with no row left is left out. ``every_row``: all
    rows of a long capture, not only the part that the statistics work on.
    """
    present = context or FitContext()
    rounds = 2 if any(term.effect.depends_on_model for term in terms) else 1
    if context is None:
        rounds += 1 if rounds == 2 else 0
    for _ in range(rounds):
        solution = solve(
            terms,
            observations,
            present,
            capture=_unless_empty(
                capture_sums(terms, observations, present, keep_capture, every_row=every_row)
            ),
            reference=_unless_empty(reference_sums(terms, observations, present, keep_reference)),
        )
        present = context_of(solution)
    # The next effect is judged with what this model says of ε.
    return replace(solution, context=present, every_row=every_row)


def _unless_empty(sums: ChannelSums | None) -> ChannelSums | None:
    return None if sums is None or sums.rows == 0 else sums


def context_of(solution: Solution) -> FitContext:
    """ε(ψ) of the disc-fixed terms of a solution, for columns that depend on it."""
    orders: list[int] = []
    cosines: list[float] = []
    sines: list[float] = []
    for index, term in enumerate(solution.terms):
        found = term.effect.disc_orders(term.nonlinear)
        values = solution.coefficients[solution.part(index)]
        for place, order in enumerate(found):
            orders.append(order)
            cosines.append(float(values[2 * place]))
            sines.append(float(values[2 * place + 1]))
    return FitContext(np.array(cosines), np.array(sines), np.array(orders, dtype=np.int64))
