"""Defines the quantities of a diagnosis that determine its stated probability, for calibration."""

from __future__ import annotations

from dataclasses import dataclass

from arctrue.workbench.diagnose.distance import Distance

RESTS_ON = ("resembles", "described", "seen", "undescribed")
"""Grounds of ``unknown``: a refused effect, a product of parts, a jump or an oscillation, or a lack
of fit."""


@dataclass(frozen=True, slots=True)
class Grounds:
    """Quantities that determine the stated probability of an answer; they include the distance of
    its set from the calibrated sets."""

    evidence: float
    """Probability of the answer from likelihoods, priors and rules alone."""
    log_p: float
    """log₁₀ of the corrected p value of the best candidate; 0 without one."""
    delta_bic: float
    """ΔBIC of the best candidate; 0 without one."""
    lead: float
    """ΔBIC of the best candidate minus the ΔBIC of the best candidate outside the class, which
    counts as 0 if it is negative; 0 without a candidate."""
    block_share: float | None
    """Share of the best candidate's fitted error that other blocks of the rows predict; None where
    it is not known.
    """
    lack_of_fit_log_p: float
    """log₁₀ of the smallest p value of the lack of fit over the channels."""
    class_size: int
    ways: int
    """Number of ways in which the set differs from the calibrated sets."""
    distance: Distance
    rests_on: str = ""
    """Ground of an answer ``unknown``, one of RESTS_ON; empty for another verdict."""
