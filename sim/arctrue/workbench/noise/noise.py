"""Describes the noise of a set: the noise of the rows of both channels, and the scatter of the
index mark, which shifts each run of the capture."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from arctrue.workbench.noise.law import NoiseLaw
from arctrue.workbench.noise.row_noise import RowNoise
from arctrue.workbench.noise.spectrum_fit import SpectrumFit
from arctrue.workbench.observations import Observations

Float = NDArray[np.float64]

INDEX_FREEDOM = 6.0
"""Weight, as a number of runs, of the assumption that an index repeats to ±1 count, if the set does
not state its repeatability."""


STATED_INDEX_FREEDOM = 60.0
"""Weight, as a number of runs, of an index repeatability that the set states."""


@dataclass(frozen=True)
class FittedGroup:
    """Runs that share a spectrum, with the uncertainty of its variances."""

    channel: str
    runs: tuple[int, ...]
    fit: SpectrumFit
    rows: int


@dataclass(frozen=True)
class Noise:
    """Noise of a set: covariance of the rows of each channel, and variance of a run's offset."""

    capture: RowNoise | None
    reference: RowNoise | None
    index_variance: float
    """Variance of a run's offset, arcsec²."""
    capture_law: NoiseLaw | None = None
    reference_law: NoiseLaw | None = None
    groups: tuple[FittedGroup, ...] = ()
    index_freedom: float = INDEX_FREEDOM
    """Weight of the prior of the index variance, as a number of runs."""

    def part(
        self, keep_capture: NDArray[np.bool_] | None, keep_reference: NDArray[np.bool_] | None
    ) -> Noise:
        """Return the noise of the rows that are kept."""
        capture, reference = self.capture, self.reference
        if capture is not None and keep_capture is not None:
            capture = capture.part(keep_capture)
        if reference is not None and keep_reference is not None:
            reference = reference.part(keep_reference)
        return replace(self, capture=capture, reference=reference)

    def with_offsets(self, observations: Observations, offsets: Float) -> Noise:
        """Return the noise with the index variance that follows from these offsets of the runs."""
        if not observations.runs:
            return self
        variance, freedom = index_variance(observations, offsets)
        return replace(self, index_variance=variance, index_freedom=freedom)

    def white_part(self) -> Noise:
        """Return the noise without its coloured parts."""
        return replace(
            self,
            capture=None if self.capture is None else self.capture.white_part(),
            reference=None if self.reference is None else self.reference.white_part(),
            capture_law=None if self.capture_law is None else self.capture_law.white_part(),
            reference_law=None if self.reference_law is None else self.reference_law.white_part(),
            groups=(),
        )

    def on(self, observations: Observations) -> Noise:
        """Apply the same laws to the rows of other observations of the same table.

        A channel that has no law gets the law of the other channel.
        """
        capture, reference = observations.capture, observations.reference
        laws = [self.capture_law or self.reference_law, self.reference_law or self.capture_law]
        assert laws[0] is not None
        assert laws[1] is not None
        return replace(
            self,
            capture=None if capture is None else laws[0].on(capture),
            reference=None if reference is None else laws[1].on(reference),
        )


def index_variance(observations: Observations, offsets: Float) -> tuple[float, float]:
    """Return the variance of a run's offset (arcsec²), and the weight of its prior in runs.

    The prior variance (±1 count per head, or the repeatability that the set states) has the weight
    of a number of runs. The result is the weighted mean of the prior variance and of the squared
    offsets of the set's own runs.
    """
    stated = observations.index_repeatability_counts is not None
    freedom = STATED_INDEX_FREEDOM if stated else INDEX_FREEDOM
    prior = observations.index_sigma_arcsec**2
    total = freedom * prior + float(offsets @ offsets)
    return total / (freedom + offsets.size), freedom
