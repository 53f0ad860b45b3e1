"""Holds a survey, the results of all tests with one model: the fit of the model, and the candidate
effects with their evidence."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from arctrue.workbench.diagnose.candidate import RUNS_ARE_THE_SAMPLE, Candidate
from arctrue.workbench.diagnose.detections import Detections
from arctrue.workbench.diagnose.every_pass import on_every_pass
from arctrue.workbench.diagnose.lack_of_fit import capture_lack_of_fit, reference_lack_of_fit
from arctrue.workbench.inference.held_out import holds_out
from arctrue.workbench.inference.residuals import Residuals
from arctrue.workbench.inference.significance import SIGNIFICANCE
from arctrue.workbench.inference.solution import Solution
from arctrue.workbench.noise.repeats import row_noise_arcsec

FAR_TOO_SMALL = 0.5
"""In a survey with a named effect in the model, the noise is not estimated anew for an effect whose
size is below this share of the smallest size that matters. A new estimate changes a size by less
than a factor of two."""
OF_A_CONSTANT = 0.1
"""Largest ratio of standard deviation to mean, over the rows, of a change that counts as
constant."""
LEAST_HELD_OUT = 0.5
"""Smallest share of an effect's fitted error that other blocks must predict. With a smaller share,
most of this error differs from block to block.
"""
MOST_LEFT = 0.5
"""If an effect leaves less than this share of the variance of a channel's residual, the noise is
estimated anew with this effect, even if its gain with the noise of the model is small."""
OF_A_REVERSAL = frozenset({"direction", "reference"})
"""Parts of an effect that is a constant reversal error."""


@dataclass(frozen=True)
class FitOfChannel:
    """The fit of a model to one channel."""

    residual_rms_arcsec: float
    noise_arcsec: float
    """RMS noise of the repeats."""
    lack_of_fit_p: float | None

    @property
    def excess_arcsec(self) -> float:
        """RMS of the residual beyond the noise of the repeats."""
        return float(np.sqrt(max(self.residual_rms_arcsec**2 - self.noise_arcsec**2, 0.0)))


def fit_of_channels(residuals: Residuals) -> dict[str, FitOfChannel]:
    """Return the fit of each channel that the set has."""
    found = {}
    for channel, values, lack in (
        ("capture", residuals.capture_arcsec, capture_lack_of_fit),
        ("reference", residuals.reference_arcsec, reference_lack_of_fit),
    ):
        if values is not None:
            # The constant of the reference is not observable.
            left = values - values.mean() if channel == "reference" else values
            rms = float(np.sqrt(np.mean(left**2)))
            noise = row_noise_arcsec(residuals.observations, values, channel, rms)
            found[channel] = FitOfChannel(rms, noise, lack(residuals))
    return found


@dataclass(frozen=True, eq=False)
class Survey:
    """Candidates that were tried with one model, best first, and the fit of the model."""

    residuals: Residuals
    matters_arcsec: float
    """Smallest RMS change of the prediction of an effect that is not negligible."""
    absent: int
    """Number of effects of the catalogue that the model lacks; the p of each such effect is
    corrected by this number."""
    looks: int = 1
    """Number of surveys by which every p is corrected: 1 in the first survey of a diagnosis,
    DEEPEST − 1 in a survey with further effects in the model."""
    candidates: list[Candidate] = field(default_factory=list)
    parts: list[Candidate] = field(default_factory=list)
    untestable: Mapping[str, list[str]] = field(default_factory=dict)
    channels: Mapping[str, FitOfChannel] = field(default_factory=dict)
    detections: Detections = field(default_factory=Detections)
    """Detections of a forward search with this model."""
    tested: int = 0
    """Number of effects of the catalogue that the set can test, although a test may give no
    candidate."""

    @property
    def base(self) -> Solution:
        """The model (a fitted solution) to which every candidate was added."""
        return self.residuals.solution

    @property
    def lack_of_fit(self) -> dict[str, float]:
        """p of the lack of fit of each channel that can be tested."""
        return {
            channel: item.lack_of_fit_p
            for channel, item in self.channels.items()
            if item.lack_of_fit_p is not None
        }

    def significant(self) -> list[Candidate]:
        """Return the effects of the catalogue whose corrected p is below SIGNIFICANCE."""
        return [item for item in self.candidates if item.p_corrected < SIGNIFICANCE]

    def matters(self, item: Candidate) -> bool:
        """Tell whether the effect changes the prediction by more than the negligible size."""
        return max(item.size_arcsec.values(), default=0.0) >= self.matters_arcsec

    def may_matter(self, item: Candidate) -> bool:
        """Tell whether the candidate's size is not far below the smallest size that matters.

        A size changes with the estimate of the noise.
        """
        size = max(item.size_arcsec.values(), default=0.0)
        return size >= FAR_TOO_SMALL * self.matters_arcsec

    def confirmed(self, item: Candidate) -> bool:
        """Tell whether the candidate is large enough to matter, and whether held-out rows
        (predicted by fits without them), other blocks and every pass show it; it must not be a
        constant that the model may contain (:meth:`objection`)."""
        return self.matters(item) and self.objection(item) is None

    def objection(self, item: Candidate) -> str | None:
        """Return in words which rows do not show the candidate; None if all tests confirm it.

        A reversal error that the jackknife over the passes confirms needs no held-out rows. After a
        reversal, friction takes up a part of the error slowly, so that the noise looks slow and
        neighbours predict the rows.
        """
        if item.share is not None and item.share.share <= LEAST_HELD_OUT:
            return "other blocks of the rows predict at most half of this error"
        if not (_holds_out(item) or self.is_the_reversal(item) or self._blocks_show(item)):
            return "rows that were left out of the fit do not show it"
        if not on_every_pass(item, self.base):
            return "other turns or runs do not show it"
        if self.may_be_a_constant_of_the_model(item):
            return "effects of the model may cause this constant"
        return None

    def _blocks_show(self, item: Candidate) -> bool:
        """Tell whether blocks predict the candidate and most of the error disappears with it, while
        the density of held-out rows does not fall.

        An effect whose shape differs a little from that in the catalogue leaves an error like slow
        noise, so that neighbours predict the rows.
        """
        if item.share is None or not takes_most(item.solution, self.base):
            return False
        return sum(found.gain for found in item.improvement.values()) >= 0.0

    def is_the_reversal(self, item: Candidate) -> bool:
        """Tell whether the candidate is the reversal error that the passes of the record
        confirm."""
        found = self.detections.reversal
        return found is not None and found.confirmed and set(item.effect.in_parts) == OF_A_REVERSAL

    def may_be_a_constant_of_the_model(self, item: Candidate) -> bool:
        """Tell whether the candidate is a constant of R₂ − R₁ that effects of the model may
        themselves contain."""
        base = self.base
        most = sum(
            term.effect.constant_between_heads_arcsec(base.coefficients[base.part(index)])
            for index, term in enumerate(base.terms)
        )
        if most == 0.0 or base.observations.capture is None:
            return False
        before, after = (
            solution.capture_prediction_arcsec(False) for solution in (base, item.solution)
        )
        change = after - before
        constant = float(change.mean())
        return abs(constant) <= most and float(np.std(change)) < OF_A_CONSTANT * abs(constant)


def _holds_out(item: Candidate) -> bool:
    """Tell whether held-out rows show the candidate (:func:`holds_out`), or need not show it.

    The free offset of each run absorbs an effect that only the differences between runs show, so
    that rows of the same run cannot show it. The runs are then the sample, and the scatter of the
    index among them decides. A regular cause has passed the prediction from other blocks of the
    record in its search.
    """
    if item.regular is not None:
        return True
    if item.evidence is not None and item.evidence.index_share >= RUNS_ARE_THE_SAMPLE:
        return True
    return bool(item.improvement) and holds_out(item.improvement.values())


def takes_most(grown: Solution, base: Solution) -> bool:
    """Tell whether the effect leaves less than half of a channel's residual variance.

    While the effect is not in the model, slow noise completely absorbs a slow effect that is far
    above the scatter of the rows, so that the effect's gain with that noise is no evidence.
    """
    return any(
        float(np.mean(after**2)) < MOST_LEFT * float(np.mean(before**2))
        for after, before in (
            (grown.capture_residual_arcsec(), base.capture_residual_arcsec()),
            (grown.reference_residual_arcsec(), base.reference_residual_arcsec()),
        )
        if after is not None and before is not None
    )
