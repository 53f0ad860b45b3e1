"""Compares a model with a measurement set: the size of the residuals, and the conditions on which
they depend."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from arctrue.workbench.compare.findings import ExcessOf, Finding, ranked_findings
from arctrue.workbench.compare.maps import ResidualMap, residual_maps
from arctrue.workbench.diagnose.survey import fit_of_channels
from arctrue.workbench.inference.every_row import channel_figures
from arctrue.workbench.inference.residuals import Residuals
from arctrue.workbench.inference.solution import Solution
from arctrue.workbench.noise.repeats import row_noise_arcsec
from arctrue.workbench.noise.whiteness import noise_data


@dataclass(frozen=True)
class ChannelComparison:
    """Size of the residuals in one channel, and the noise of this channel."""

    rows: int
    rms_arcsec: float
    peak_arcsec: float
    noise_arcsec: float
    lack_of_fit_p: float

    @property
    def excess_arcsec(self) -> float:
        """RMS of the residual without the noise: √(RMS² − noise²), at least 0."""
        return float(np.sqrt(max(self.rms_arcsec**2 - self.noise_arcsec**2, 0.0)))


@dataclass(frozen=True)
class ModelComparison:
    """Comparison of both channels, with the maps and the findings; each finding comes before the
    weaker findings that resemble it (its shadows)."""

    channels: dict[str, ChannelComparison]
    maps: list[ResidualMap]
    findings: list[Finding]
    noise: dict[str, Any]
    """White and coloured noise of each channel, and the results of the tests of the whitened
    residuals."""


def compare(solution: Solution, seed: int) -> ModelComparison:
    """Compare the residuals of a fitted (or stored) model with every condition of the set."""
    residuals = Residuals(solution)
    channels: dict[str, ChannelComparison] = {}
    for channel, item in fit_of_channels(residuals).items():
        figures = channel_figures(solution, channel)
        values = residuals.capture_arcsec if channel == "capture" else residuals.reference_arcsec
        assert figures is not None
        assert values is not None
        channels[channel] = ChannelComparison(
            figures.rows,
            figures.rms_arcsec,
            figures.peak_arcsec,
            row_noise_arcsec(residuals.observations, values, channel, figures.rms_arcsec),
            1.0 if item.lack_of_fit_p is None else item.lack_of_fit_p,
        )
    maps = residual_maps(residuals, np.random.default_rng(seed))
    excess = {
        name: ExcessOf(item.rows, item.rms_arcsec, item.excess_arcsec)
        for name, item in channels.items()
    }
    tests = (residuals.capture_whiteness, residuals.reference_whiteness)
    findings = ranked_findings(residuals, maps, excess)
    return ModelComparison(channels, maps, findings, noise_data(solution.noise, tests))
