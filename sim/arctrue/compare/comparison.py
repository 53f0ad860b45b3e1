"""A model beside a measurement set: how far, and where."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from arctrue.compare.maps import ResidualMap, residual_maps
from arctrue.diagnose.lack_of_fit import capture_lack_of_fit, reference_lack_of_fit
from arctrue.diagnose.noise import capture_noise_arcsec, reference_noise_arcsec
from arctrue.diagnose.parts_scan import best_parts
from arctrue.diagnose.significance import corrected_p_value
from arctrue.fit.residuals import Residuals
from arctrue.fit.solution import Solution
from arctrue.model.growth import rms_and_peak

LEAST_SHARE = 0.02
"""Shares of the excess below this are not put into words."""
SIGNIFICANCE = 0.01


@dataclass(frozen=True)
class ChannelComparison:
    """How far the model is from one channel."""

    rows: int
    rms_arcsec: float
    peak_arcsec: float
    noise_arcsec: float
    lack_of_fit_p: float

    @property
    def excess_arcsec(self) -> float:
        """RMS of what is left beyond the noise of the repeats."""
        return float(np.sqrt(max(self.rms_arcsec**2 - self.noise_arcsec**2, 0.0)))


@dataclass(frozen=True)
class Finding:
    """One sentence on where the model fails, with the share of the excess that follows it."""

    channel: str
    share: float
    text: str


@dataclass(frozen=True)
class Comparison:
    """Both channels, the maps and the findings, largest share first."""

    channels: dict[str, ChannelComparison]
    maps: list[ResidualMap]
    findings: list[Finding]


def compare(solution: Solution, seed: int) -> Comparison:
    """Residuals of a fitted (or stored) model against every condition of the set."""
    residuals = Residuals(solution)
    observations = solution.observations
    channels: dict[str, ChannelComparison] = {}
    for channel, values, noise, lack in (
        ("capture", residuals.capture_arcsec, capture_noise_arcsec, capture_lack_of_fit),
        ("reference", residuals.reference_arcsec, reference_noise_arcsec, reference_lack_of_fit),
    ):
        if values is None:
            continue
        rms, peak = rms_and_peak(values)
        p_value = lack(residuals)
        channels[channel] = ChannelComparison(
            values.size, rms, peak, noise(observations, values), 1.0 if p_value is None else p_value
        )
    maps = residual_maps(residuals, np.random.default_rng(seed))
    findings = [*_map_findings(maps, channels), *_product_findings(residuals, channels)]
    findings = sorted(findings, key=lambda item: -item.share)
    return Comparison(channels, maps, findings)


def _excess_share(
    share_of_variance: float, channel: str, channels: dict[str, ChannelComparison]
) -> float:
    """Share of the excess over the noise, from a share of the whole variance.

    When repeats scatter as much as the whole (an effect that does not repeat), the whole counts.
    """
    found = channels[channel]
    excess = found.excess_arcsec**2
    whole = found.rms_arcsec**2
    if excess < 0.05 * whole:
        excess = whole
    return min(share_of_variance * whole / max(excess, 1e-30), 1.0)


def _map_findings(maps: list[ResidualMap], channels: dict[str, ChannelComparison]) -> list[Finding]:
    found = []
    for item in maps:
        share = _excess_share(item.excess_share, item.channel, channels)
        if share >= LEAST_SHARE:
            text = f"{share:.0%} of the excess in the {item.channel} follows {item.condition}"
            found.append(Finding(item.channel, share, text))
    return found


def _product_findings(
    residuals: Residuals, channels: dict[str, ChannelComparison]
) -> list[Finding]:
    found: list[Finding] = []
    seen: set[tuple[str, ...]] = set()
    for item in best_parts(residuals):
        if corrected_p_value(item.gain, item.rank, item.trials, 1) > SIGNIFICANCE:
            continue
        channel = "reference" if item.effect.frame == "reference" else "capture"
        if channel not in channels:
            continue
        key = (channel, *item.effect.parts[:-1])
        if key in seen or len(item.effect.parts) < 2:
            continue
        seen.add(key)
        rows = channels[channel].rows
        sigma = (
            residuals.reference_sigma_arcsec
            if channel == "reference"
            else residuals.capture_sigma_arcsec
        )
        share_of_variance = (
            item.gain * sigma**2 / (rows * max(channels[channel].rms_arcsec, 1e-15) ** 2)
        )
        share = _excess_share(share_of_variance, channel, channels)
        if share < LEAST_SHARE:
            continue
        words = " × ".join(_words(part) for part in item.effect.parts[:-1]) or "a constant"
        found.append(
            Finding(channel, share, f"{share:.0%} of the excess in the {channel} follows {words}")
        )
    return found


def _words(part: str) -> str:
    kind, _, value = part.partition(":")
    if kind == "order":
        return f"order {value}"
    if kind == "electrical":
        return f"electrical phase of {value.replace('head', 'head ')}"
    if kind == "hz":
        return f"{value} Hz"
    return part.replace("^2", "²")
