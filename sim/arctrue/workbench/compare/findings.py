"""Describes in words on which conditions the residual depends, and marks conditions that only
resemble a stronger one.

Temperature and time rise together in a warming run, so that both "explain" the same variance. The
strongest condition is removed from the residual first. The share that another condition still
explains is its share beyond the strongest. A condition with a small remaining share is a shadow.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from arctrue.base.percent import percent
from arctrue.workbench.compare.maps import ResidualMap, variance_share
from arctrue.workbench.diagnose.parts_scan import PartsCandidate, best_parts
from arctrue.workbench.effects.capture_block import capture_block
from arctrue.workbench.effects.product_of_parts import ProductOfParts
from arctrue.workbench.inference.design_matrix import row_blocks
from arctrue.workbench.inference.residuals import Residuals
from arctrue.workbench.inference.significance import corrected_p_value

Float = NDArray[np.float64]

LEAST_SHARE = 0.02
"""Smallest share of the excess that a condition must explain to be listed as a finding."""
LEAST_EXCESS = 0.05
"""Smallest share of the excess in the mean square of the residual with which a finding states its
share of the excess; below it, the finding states its share of the whole variance."""
SIGNIFICANCE = 0.01
"""Largest p of a product of parts, corrected for all products that were tried, that is listed as a
finding; it equals the limit of the diagnosis."""
SHADOW_SHARE = 0.25
"""After a stronger condition is removed from the residual, a condition is a shadow if it keeps less
than this part of its share, or if its share is below LEAST_SHARE."""
MOST_TAKEN = 4
"""Largest number of conditions that are removed from the residual one after another; the effects of
further conditions are too small to rank."""


@dataclass(frozen=True)
class ExcessOf:
    """RMS of one channel's residual, and the excess of this RMS over the noise. The share of a
    condition is a part of the excess."""

    rows: int
    rms_arcsec: float
    excess_arcsec: float

    @property
    def noise_share(self) -> float:
        """Share of the noise in the whole variance, 0 to 1."""
        whole = self.rms_arcsec**2
        return float(min(max(1.0 - self.excess_arcsec**2 / max(whole, 1e-30), 0.0), 1.0))

    @property
    def mostly_noise(self) -> bool:
        """True if the noise is almost as large as the whole residual, for example because the error
        does not repeat. A share of the excess would then mean little."""
        return self.excess_arcsec**2 < LEAST_EXCESS * self.rms_arcsec**2

    @property
    def words(self) -> str:
        """The quantity to which :meth:`share` refers."""
        return "variance" if self.mostly_noise else "excess"

    def share(self, share_of_variance: float) -> float:
        """Convert a share of the whole variance into a share of the excess over the noise; if the
        residual is mostly noise, return the share of the whole variance."""
        excess, whole = self.excess_arcsec**2, self.rms_arcsec**2
        if self.mostly_noise:
            excess = whole
        return float(min(max(share_of_variance, 0.0) * whole / max(excess, 1e-30), 1.0))


@dataclass(frozen=True)
class Finding:
    """One condition on which the residual depends, and its share."""

    channel: str
    follows: str
    """The condition, in words."""
    share: float
    """Share of the excess that the condition explains if no other condition is removed before."""
    share_beyond: float
    """Share of the excess that the condition explains after all stronger ones were removed."""
    shadow_of: str | None
    """The stronger condition that this condition resembles; None for an independent finding."""
    text: str


class _Follower(ABC):
    """A condition on which the residual may depend."""

    channel: str
    words: str

    @abstractmethod
    def variance_share(self, residuals: Residuals, whole: float) -> float:
        """Return the share of ``whole`` (initial sum of squares) that the condition explains."""

    @abstractmethod
    def taken_from(self, residuals: Residuals) -> Residuals:
        """Return the residuals without the part that the condition explains."""


class _Map(_Follower):
    def __init__(self, item: ResidualMap, noise_share: float) -> None:
        self.channel, self.words, self._map = item.channel, item.condition, item
        self._noise_share = noise_share

    def variance_share(self, residuals: Residuals, whole: float) -> float:
        values = _centred(residuals, self.channel)
        there = variance_share(values, self._map.group, self._map.bins) * float(values @ values)
        share = there / max(whole, 1e-30)
        if share <= self._map.null_share:
            return 0.0
        # Means of bins explain ``null_share`` of the noise, which is only a part of the residual.
        return share - self._map.null_share * self._noise_share

    def taken_from(self, residuals: Residuals) -> Residuals:
        values = _centred(residuals, self.channel)
        counts = np.maximum(np.bincount(self._map.group, minlength=self._map.bins), 1)
        means = np.bincount(self._map.group, weights=values, minlength=self._map.bins) / counts
        left = values - means[self._map.group]
        if self.channel == "capture":
            return residuals.with_residuals(left, residuals.reference_arcsec)
        return residuals.with_residuals(residuals.capture_arcsec, left)


class _Product(_Follower):
    def __init__(self, effect: ProductOfParts, channel: str) -> None:
        self.channel, self._effect = channel, effect
        self.words = _words(effect)

    def variance_share(self, residuals: Residuals, whole: float) -> float:
        # The share is a part of the sum of squares, not of χ².
        before = _centred(residuals, self.channel)
        after = _centred(self.taken_from(residuals), self.channel)
        return float(before @ before - after @ after) / max(whole, 1e-30)

    def taken_from(self, residuals: Residuals) -> Residuals:
        coefficients = residuals.score(self._effect, {}).coefficients
        context = residuals.solution.context
        capture, reference = residuals.capture_arcsec, residuals.reference_arcsec
        if capture is not None and residuals.observations.capture is not None:
            capture = capture.copy()
            for block in row_blocks(capture.size):
                rows = residuals.observations.capture.part(block)
                columns = capture_block(self._effect, rows, {}, context)
                if columns is not None:
                    capture[block] -= columns @ coefficients
        if reference is not None and residuals.observations.reference is not None:
            rows_there = residuals.observations.reference
            columns = self._effect.reference_columns(rows_there, {}, context)
            if columns is not None:
                reference = reference - columns @ coefficients
        return residuals.with_residuals(capture, reference)


def _centred(residuals: Residuals, channel: str) -> Float:
    values = residuals.capture_arcsec if channel == "capture" else residuals.reference_arcsec
    assert values is not None
    return np.asarray(values - values.mean())


def ranked_findings(
    residuals: Residuals, maps: Sequence[ResidualMap], excess: Mapping[str, ExcessOf]
) -> list[Finding]:
    """Return all findings: the independent findings first, each followed by its shadows."""
    found: list[Finding] = []
    products = best_parts(residuals, look_alikes=True)  # the same for both channels
    for channel, reference in excess.items():
        found += _ranked(residuals, channel, maps, reference, products)
    leaders = sorted((item for item in found if not item.shadow_of), key=lambda item: -item.share)
    ordered: list[Finding] = []
    for leader in leaders:
        ordered.append(leader)
        ordered += [
            item
            for item in found
            if item.shadow_of == leader.follows and item.channel == leader.channel
        ]
    return ordered


def _products(best: Sequence[PartsCandidate], channel: str, known: set[str]) -> list[_Follower]:
    """Return the products of parts among ``best`` that explain a significant part of the residuals,
    without those in ``known``."""
    found: list[_Follower] = []
    for item in best:
        if corrected_p_value(item.gain, item.rank, item.trials, 1) > SIGNIFICANCE:
            continue
        where = "reference" if item.effect.frame == "reference" else "capture"
        if where != channel or len(item.effect.parts) < 2:
            continue
        product = _Product(item.effect, channel)
        if product.words not in known:
            known.add(product.words)
            found.append(product)
    return found


def _ranked(
    start: Residuals,
    channel: str,
    maps: Sequence[ResidualMap],
    excess: ExcessOf,
    products: Sequence[PartsCandidate],
) -> list[Finding]:
    values = _centred(start, channel)
    whole = float(values @ values)
    known: set[str] = set()
    waiting: list[_Follower] = [
        _Map(item, excess.noise_share) for item in maps if item.channel == channel
    ]
    waiting += _products(products, channel, known)
    by_itself: dict[_Follower, float] = {}
    now: dict[_Follower, float] = {}
    found: list[Finding] = []
    residuals = start
    for _ in range(MOST_TAKEN):
        for item in waiting:
            if item not in by_itself:
                by_itself[item] = excess.share(item.variance_share(start, whole))
                now[item] = (
                    by_itself[item]
                    if residuals is start
                    else excess.share(item.variance_share(residuals, whole))
                )
        waiting = [item for item in waiting if min(by_itself[item], now[item]) >= LEAST_SHARE]
        if not waiting:
            break
        leader = max(waiting, key=lambda item: now[item])
        waiting.remove(leader)
        found.append(_finding(leader, by_itself[leader], now[leader], None, excess.words))
        residuals = leader.taken_from(residuals)
        for item in list(waiting):
            before, now[item] = now[item], excess.share(item.variance_share(residuals, whole))
            if now[item] < SHADOW_SHARE * before or now[item] < LEAST_SHARE:
                waiting.remove(item)
                found.append(_finding(item, by_itself[item], now[item], leader.words, excess.words))
        if not waiting:
            # One strong cause and its aliases may have filled the list of products. The residuals,
            # now without this cause, are therefore searched again.
            waiting = _products(best_parts(residuals, look_alikes=True), channel, known)
    rest = [item for item in waiting if item in by_itself]
    return [
        *found,
        *(_finding(item, by_itself[item], now[item], None, excess.words) for item in rest),
    ]


def _finding(
    item: _Follower, share: float, beyond: float, shadow_of: str | None, whole: str
) -> Finding:
    if shadow_of is None:
        text = f"{percent(share)} of the {whole} in the {item.channel} follows {item.words}"
        if beyond < share - LEAST_SHARE:
            text += f" ({percent(beyond)} beyond the items above)"
    else:
        text = (
            f"{item.words} resembles {shadow_of}: {percent(share)} by itself, "
            f"{percent(beyond)} beyond {shadow_of}"
        )
    return Finding(item.channel, item.words, share, beyond, shadow_of, text)


def _words(effect: ProductOfParts) -> str:
    """Return condition and wave in words, without the frame to which the wave is fixed."""
    condition = effect.condition.part.replace("^2", "²")
    if effect.electrical_head is not None:
        waves = [f"electrical phase of head {effect.electrical_head}"]
    else:
        waves = [f"order {order:g}" for order in effect.orders]
    return " × ".join([condition, *waves] if condition else waves)
