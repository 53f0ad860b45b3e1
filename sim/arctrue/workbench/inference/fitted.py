"""Holds the values of a fit, without the figures that are computed from them."""

from __future__ import annotations

from dataclasses import dataclass

from arctrue.workbench.effects.base import FitContext
from arctrue.workbench.inference.design_matrix import Term
from arctrue.workbench.noise.noise import Noise
from arctrue.workbench.numeric.least_squares import Matrix
from arctrue.workbench.observations import Observations


@dataclass(frozen=True)
class Fitted:
    """Terms fitted to a set: coefficients, covariance and noise."""

    terms: tuple[Term, ...]
    observations: Observations
    context: FitContext
    widths: tuple[int, ...]
    coefficients: Matrix
    """Coefficients of all terms, in the order of the terms."""
    covariance: Matrix
    run_offsets_arcsec: Matrix
    reference_offset_arcsec: float
    noise: Noise
    log_likelihood: float
    rank: int
    """Number of combinations of coefficients that the data determine."""
    condition: float
    every_row: bool = False
    """True if the coefficients are fitted to every row of a set, while the statistics use only a
    part of its rows."""
    held: bool = False
    """True if the coefficients were fitted to another set: only offsets were fitted to this set."""
    unknown_noise: frozenset[str] = frozenset()
    """Channels that have too few rows for their coefficients, so that the rows do not show their
    scatter."""

    def part(self, index: int) -> slice:
        """Return the slice of one term's coefficients."""
        start = sum(self.widths[:index])
        return slice(start, start + self.widths[index])
