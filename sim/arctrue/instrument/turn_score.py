"""Computes the error of a signal over a turn from its edges and the true angle."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from arctrue.base.json_text import plain
from arctrue.base.units import ARCSEC_PER_TURN
from arctrue.instrument.errors import InstrumentError
from arctrue.instrument.recording import EdgeTrack

BINS = 720
"""Number of bins in a turn; each bin is half a degree wide."""
FINE_BINS = 7200
MOST_ORDER = 64
TURN_RAD = 2 * np.pi

Float = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class TurnScore:
    """Error of one signal over one turn in arcseconds, with the mean of the turn removed."""

    error_arcsec: Float
    """Mean error in each half degree of the true angle, shape ``(720,)``; NaN in a half degree
    without an edge."""
    lowest_edge_arcsec: Float
    """Lowest error of an edge in each half degree, shape ``(720,)``."""
    highest_edge_arcsec: Float
    mean_arcsec: float
    """Mean of the turn, which was removed; it is relative to the mean of the recording's first
    turn, because two heads cannot determine the absolute mean."""
    edges_rms_arcsec: float
    """Root mean square error of the single edges, arcseconds. It includes errors finer than half a
    degree, the noise of the readings and the steps of the counts. NaN if no single edge was
    kept."""
    amplitude_arcsec: Float
    """Amplitudes of orders 1, 2, …, shape ``(64,)`` unless another number of orders is requested.
    NaN if a half degree has no edge."""
    edges: int

    @classmethod
    def of_edges(cls, true_angle_rad: Float, error_arcsec: Float, zero_arcsec: float = 0.0) -> Self:
        """Return the score of a turn from all its edges, arrays ``(n,)``; the mean is relative to
        ``zero_arcsec``."""
        place = np.floor(np.mod(true_angle_rad, TURN_RAD) * (BINS / TURN_RAD)).astype(np.int64)
        place = np.minimum(place, BINS - 1)
        edges = np.bincount(place, minlength=BINS)
        with np.errstate(invalid="ignore"):
            bins = np.bincount(place, error_arcsec, BINS) / edges
        lowest, highest = np.full(BINS, np.inf), np.full(BINS, -np.inf)
        np.minimum.at(lowest, place, error_arcsec)
        np.maximum.at(highest, place, error_arcsec)
        empty = edges == 0
        lowest[empty] = highest[empty] = np.nan
        mean = float(np.nanmean(bins))
        return cls(
            error_arcsec=bins - mean,
            lowest_edge_arcsec=lowest - mean,
            highest_edge_arcsec=highest - mean,
            mean_arcsec=mean - zero_arcsec,
            edges_rms_arcsec=float(np.sqrt(np.mean((error_arcsec - mean) ** 2))),
            amplitude_arcsec=amplitudes(bins),
            edges=error_arcsec.size,
        )

    @classmethod
    def of_even_readings(cls, error_arcsec: Float, most_order: int = MOST_ORDER) -> Self:
        """Return the score of n readings at the true angles (k + ½)/n of a turn; each reading
        counts as an edge.

        ``error_arcsec`` (n,) contains the errors at k = 0 … n − 1; n is a multiple of 720 and above
        twice ``most_order``. The amplitudes are computed from the readings themselves; means over
        half degrees would reduce them.
        """
        parts = error_arcsec.reshape(BINS, -1)
        mean = float(error_arcsec.mean())
        spectrum = np.abs(np.fft.rfft(error_arcsec)[1 : most_order + 1])
        return cls(
            error_arcsec=parts.mean(axis=1) - mean,
            lowest_edge_arcsec=parts.min(axis=1) - mean,
            highest_edge_arcsec=parts.max(axis=1) - mean,
            mean_arcsec=0.0,
            edges_rms_arcsec=float(error_arcsec.std()),
            amplitude_arcsec=np.asarray(2 * spectrum / error_arcsec.size),
            edges=error_arcsec.size,
        )

    @classmethod
    def of_means(cls, error_arcsec: Float, mean_arcsec: float, edges_rms_arcsec: float) -> Self:
        """Return the score of a turn of which only the means of the half degrees are known."""
        return cls(
            error_arcsec,
            error_arcsec,
            error_arcsec,
            mean_arcsec,
            edges_rms_arcsec,
            amplitudes(error_arcsec),
            int(np.isfinite(error_arcsec).sum()),
        )

    @property
    def angle_rad(self) -> Float:
        """Middle of each half degree, shape ``(720,)``."""
        return np.asarray((np.arange(BINS) + 0.5) * (TURN_RAD / BINS))

    @property
    def lowest_arcsec(self) -> float:
        """Smallest mean of a half degree."""
        return float(np.nanmin(self.error_arcsec))

    @property
    def highest_arcsec(self) -> float:
        """Largest mean of a half degree."""
        return float(np.nanmax(self.error_arcsec))

    @property
    def reach_arcsec(self) -> float:
        """Largest absolute mean of a half degree."""
        return max(-self.lowest_arcsec, self.highest_arcsec)

    @property
    def rms_arcsec(self) -> float:
        """Root mean square of the means of the half degrees."""
        return float(np.sqrt(np.nanmean(self.error_arcsec**2)))

    @property
    def every_edge_arcsec(self) -> tuple[float, float]:
        """Smallest error and largest error of all edges."""
        lowest, highest = self.lowest_edge_arcsec, self.highest_edge_arcsec
        return float(np.nanmin(lowest)), float(np.nanmax(highest))

    @property
    def edges_reach_arcsec(self) -> float:
        """Largest absolute error of any edge."""
        lowest, highest = self.every_edge_arcsec
        return max(-lowest, highest)

    @property
    def largest_order(self) -> int:
        """Order that has the largest amplitude."""
        return int(np.argmax(self.amplitude_arcsec)) + 1

    def as_json(self) -> dict[str, Any]:
        """Return the score as JSON values; NaN becomes None, null in the file."""
        found = {
            "lowest_arcsec": self.lowest_arcsec,
            "highest_arcsec": self.highest_arcsec,
            "rms_arcsec": self.rms_arcsec,
            "every_edge_arcsec": self.every_edge_arcsec,
            "edges_rms_arcsec": self.edges_rms_arcsec,
            "mean_arcsec": self.mean_arcsec,
            "edges": self.edges,
            "amplitude_arcsec": self.amplitude_arcsec,
        }
        return {name: plain(value) for name, value in found.items()}

    def curve_as_json(self) -> dict[str, list[float | None]]:
        """Return the means of the half degrees, None for one without an edge; callers store these
        long lists apart from the figures."""
        return {
            "angle_deg": plain(np.rad2deg(self.angle_rad)),
            "error_arcsec": plain(self.error_arcsec),
        }


def amplitudes(means: Float) -> Float:
    """Return the amplitudes of orders 1 to 64 from means of equal parts of a turn; NaN if a mean is
    NaN.

    The mean over a part reduces order n by sinc(n / parts); the function divides by this factor.
    """
    if np.isnan(means).any():
        return np.full(MOST_ORDER, np.nan)
    spectrum = np.fft.rfft(means)[1 : MOST_ORDER + 1]
    lowered = np.sinc(np.arange(1, MOST_ORDER + 1) / means.size)
    return np.asarray(2 * np.abs(spectrum) / (means.size * lowered))


def score_turn(track: EdgeTrack) -> TurnScore:
    """Return the score of a turn that was recorded in bins of half a degree or less; single edges
    may be kept as well.

    Raises InstrumentError if a bin contains no edge, or if the number of bins is not a multiple of
    720.
    """
    parts = track.bin_edges.size
    if not parts or parts % BINS or not track.bin_edges.all():
        raise InstrumentError("the recording does not hold a whole turn")
    scale = ARCSEC_PER_TURN / track.counts_per_rev
    edges = track.bin_edges.reshape(BINS, -1)
    weighted: Float = track.bin_mean_counts.reshape(edges.shape) * edges
    coarse = weighted.sum(axis=1) / edges.sum(axis=1)
    mean = float(coarse.mean())
    lowest: Float = track.bin_lowest_counts.reshape(edges.shape).min(axis=1)
    highest: Float = track.bin_highest_counts.reshape(edges.shape).max(axis=1)
    single = float("nan")
    if track.position.size:
        angle = track.true_angle_rad * (track.counts_per_rev / TURN_RAD)
        single = float(np.sqrt(np.mean((track.position - angle - mean) ** 2))) * scale
    return TurnScore(
        error_arcsec=(coarse - mean) * scale,
        lowest_edge_arcsec=(lowest - mean) * scale,
        highest_edge_arcsec=(highest - mean) * scale,
        mean_arcsec=0.0,
        edges_rms_arcsec=single,
        amplitude_arcsec=amplitudes(track.bin_mean_counts) * scale,
        edges=track.edges,
    )


def score_turns(track: EdgeTrack, travel_turns: Float, turns: int) -> list[TurnScore | None]:
    """Return the score of each turn of travel from the kept edges; None for a turn without an edge.

    ``travel_turns`` (n,) is the travel at each kept edge, which never decreases; the first turn is
    0 to 1.
    """
    position_counts = track.position - track.true_angle_rad * (track.counts_per_rev / TURN_RAD)
    error_arcsec = position_counts * (ARCSEC_PER_TURN / track.counts_per_rev)
    ends = np.searchsorted(travel_turns, np.arange(turns + 1))
    found: list[TurnScore | None] = []
    zero: float | None = None
    for number in range(turns):
        within = slice(ends[number], ends[number + 1])
        known = np.isfinite(error_arcsec[within])
        error, angle = error_arcsec[within][known], track.true_angle_rad[within][known]
        if not error.size:
            found.append(None)
            continue
        score = TurnScore.of_edges(angle, error, zero or 0.0)
        if zero is None:
            zero = score.mean_arcsec
            score = replace(score, mean_arcsec=0.0)
        found.append(score)
    return found
