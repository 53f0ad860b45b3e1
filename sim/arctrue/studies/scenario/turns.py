"""Turns of a recording: the error of each against the true angle."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from arctrue.instrument import EdgeTrack
from arctrue.instrument.recording import ARCSEC_A_TURN

BINS = 720
"""Half a degree."""
MOST_ORDER = 64
TURN_RAD = 2 * np.pi

Float = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class TurnError:
    """Error of one signal over one turn, the turn's own mean removed; seconds of arc."""

    bins_arcsec: Float
    """Mean of each half a degree of the true angle, shape ``(720,)``; NaN where no edge was."""
    mean_arcsec: float
    """The mean itself, against that of the first turn."""
    edges_rms_arcsec: float
    """Root mean square of single edges: with what is finer than half a degree, with the noise of
    the readings and the steps of the counts."""

    @property
    def lowest_arcsec(self) -> float:
        """Lowest mean of half a degree."""
        return float(np.nanmin(self.bins_arcsec))

    @property
    def highest_arcsec(self) -> float:
        """Highest mean of half a degree."""
        return float(np.nanmax(self.bins_arcsec))

    @property
    def reach_arcsec(self) -> float:
        """Largest error of either sign."""
        return max(-self.lowest_arcsec, self.highest_arcsec)

    @property
    def rms_arcsec(self) -> float:
        """Root mean square of the means of half a degree."""
        return float(np.sqrt(np.nanmean(self.bins_arcsec**2)))

    @property
    def amplitude_arcsec(self) -> Float:
        """Of orders 1, 2, …, shape ``(64,)``; NaN where the turn is not whole."""
        if np.isnan(self.bins_arcsec).any():
            return np.full(MOST_ORDER, np.nan)
        spectrum = np.fft.rfft(self.bins_arcsec)[1 : MOST_ORDER + 1]
        return np.asarray(2 * np.abs(spectrum) / BINS)


def turn_errors(track: EdgeTrack, travel_turns: Float, turns: int) -> list[TurnError | None]:
    """The error of each turn of travel; None where a turn holds no edge.

    ``travel_turns`` (n,) is the travel at each kept edge: 0 to 1 is the first turn.
    """
    position_counts = track.position - track.true_angle_rad * (track.counts_per_rev / TURN_RAD)
    error_arcsec = position_counts * (ARCSEC_A_TURN / track.counts_per_rev)
    place = np.floor(np.mod(track.true_angle_rad, TURN_RAD) * (BINS / TURN_RAD)).astype(np.int64)
    place = np.minimum(place, BINS - 1)
    turn = np.floor(travel_turns).astype(np.int64)
    found: list[TurnError | None] = []
    zero: float | None = None
    for number in range(turns):
        here = (turn == number) & np.isfinite(error_arcsec)
        if not here.any():
            found.append(None)
            continue
        edges = np.bincount(place[here], minlength=BINS)
        with np.errstate(invalid="ignore"):
            bins = np.bincount(place[here], error_arcsec[here], BINS) / edges
        mean = float(np.nanmean(bins))
        zero = mean if zero is None else zero
        single = float(np.sqrt(np.mean((error_arcsec[here] - mean) ** 2)))
        found.append(TurnError(bins - mean, mean - zero, single))
    return found
