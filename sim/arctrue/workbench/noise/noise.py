"""The noise of a set: both channels, and the index of the capture's runs."""

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
"""The ±1 count of an index that no set tells of weighs like the scatter of so many runs."""


@dataclass(frozen=True)
class FittedGroup:
    """Runs that share a spectrum, with the uncertainty of its variances."""

    channel: str
    runs: tuple[int, ...]
    fit: SpectrumFit
    rows: int


@dataclass(frozen=True)
class Noise:
    """What makes rows of one set differ from any model of it."""

    capture: RowNoise | None
    reference: RowNoise | None
    index_variance: float
    """Of a run's offset, arcsec²."""
    capture_law: NoiseLaw | None = None
    reference_law: NoiseLaw | None = None
    groups: tuple[FittedGroup, ...] = ()
    index_freedom: float = INDEX_FREEDOM
    """Runs' worth of knowledge that the index variance rests on before the set's own runs."""

    def part(
        self, keep_capture: NDArray[np.bool_] | None, keep_reference: NDArray[np.bool_] | None
    ) -> Noise:
        """The noise of some of the rows."""
        capture, reference = self.capture, self.reference
        if capture is not None and keep_capture is not None:
            capture = capture.part(keep_capture)
        if reference is not None and keep_reference is not None:
            reference = reference.part(keep_reference)
        return replace(self, capture=capture, reference=reference)

    def white_part(self) -> Noise:
        """The same without what is coloured."""
        return replace(
            self,
            capture=None if self.capture is None else self.capture.white_part(),
            reference=None if self.reference is None else self.reference.white_part(),
            capture_law=None if self.capture_law is None else self.capture_law.white_part(),
            reference_law=None if self.reference_law is None else self.reference_law.white_part(),
            groups=(),
        )

    def on(self, observations: Observations) -> Noise:
        """The same laws for the rows of other observations of the same table."""
        capture, reference = observations.capture, observations.reference
        laws = [self.capture_law or self.reference_law, self.reference_law or self.capture_law]
        assert laws[0] is not None
        assert laws[1] is not None
        return replace(
            self,
            capture=None if capture is None else laws[0].on_capture(capture),
            reference=None if reference is None else laws[1].on_reference(reference),
        )
