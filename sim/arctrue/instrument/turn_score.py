"""How far a signal is from the true angle over a turn."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray

from arctrue.instrument.errors import InstrumentError
from arctrue.instrument.recording import ARCSEC_A_TURN, EdgeTrack

BINS = 720
"""Half a degree."""
FINE_BINS = 7200
MOST_ORDER = 64
TURN_RAD = 2 * np.pi

Float = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class TurnScore:
    """Error of one signal over one turn, the turn's own mean removed; seconds of arc."""

    error_arcsec: Float
    """Mean of each half a degree of the true angle, shape ``(720,)``; NaN where no edge was."""
    mean_arcsec: float
    """The mean itself, which two heads cannot see; against that of the recording's first turn."""
    edges_rms_arcsec: float
    """Root mean square of single edges: with what is finer than half a degree, with the noise of
    the readings and the steps of the counts. NaN where no single edge was kept."""
    every_edge_arcsec: tuple[float, float]
    """Lowest and highest of the edges."""
    amplitude_arcsec: Float
    """Of orders 1, 2, …, shape ``(64,)``; NaN where the turn is not whole."""
    edges: int

    @classmethod
    def of_means(cls, error_arcsec: Float, mean_arcsec: float, edges_rms_arcsec: float) -> Self:
        """From the means of half a degree alone."""
        return cls(
            error_arcsec,
            mean_arcsec,
            edges_rms_arcsec,
            (float(np.nanmin(error_arcsec)), float(np.nanmax(error_arcsec))),
            amplitudes(error_arcsec),
            int(np.isfinite(error_arcsec).sum()),
        )

    @property
    def angle_rad(self) -> Float:
        """Middle of each half a degree, shape ``(720,)``."""
        return np.asarray((np.arange(BINS) + 0.5) * (TURN_RAD / BINS))

    @property
    def lowest_arcsec(self) -> float:
        """Lowest mean of half a degree."""
        return float(np.nanmin(self.error_arcsec))

    @property
    def highest_arcsec(self) -> float:
        """Highest mean of half a degree."""
        return float(np.nanmax(self.error_arcsec))

    @property
    def reach_arcsec(self) -> float:
        """Largest error of either sign."""
        return max(-self.lowest_arcsec, self.highest_arcsec)

    @property
    def rms_arcsec(self) -> float:
        """Root mean square of the means of half a degree."""
        return float(np.sqrt(np.nanmean(self.error_arcsec**2)))


def amplitudes(error_arcsec: Float) -> Float:
    """Amplitude of orders 1 to 64 of errors at even places of a turn; NaN where one is missing."""
    if np.isnan(error_arcsec).any():
        return np.full(MOST_ORDER, np.nan)
    spectrum = np.fft.rfft(error_arcsec)[1 : MOST_ORDER + 1]
    return np.asarray(2 * np.abs(spectrum) / error_arcsec.size)


def score_turn(track: EdgeTrack) -> TurnScore:
    """The score of a turn recorded in FINE_BINS bins, of which no edge need be kept.

    Raises InstrumentError where a bin holds no edge.
    """
    if track.bin_edges.size != FINE_BINS or not track.bin_edges.all():
        raise InstrumentError("the recording does not hold a whole turn")
    fine = track.bin_error_arcsec()
    edges = track.bin_edges.reshape(BINS, -1)
    weighted: Float = fine.reshape(edges.shape) * edges
    coarse = weighted.sum(axis=1) / edges.sum(axis=1)
    return TurnScore(
        error_arcsec=coarse - float(coarse.mean()),
        mean_arcsec=0.0,
        edges_rms_arcsec=float("nan"),
        every_edge_arcsec=track.extremes_arcsec(),
        amplitude_arcsec=amplitudes(fine),
        edges=track.edges,
    )


def score_turns(track: EdgeTrack, travel_turns: Float, turns: int) -> list[TurnScore | None]:
    """The score of each turn of travel from the kept edges; None where a turn holds no edge.

    ``travel_turns`` (n,) is the travel at each kept edge, which never falls: 0 to 1 is the first
    turn.
    """
    position_counts = track.position - track.true_angle_rad * (track.counts_per_rev / TURN_RAD)
    error_arcsec = position_counts * (ARCSEC_A_TURN / track.counts_per_rev)
    place = np.floor(np.mod(track.true_angle_rad, TURN_RAD) * (BINS / TURN_RAD)).astype(np.int64)
    place = np.minimum(place, BINS - 1)
    ends = np.searchsorted(travel_turns, np.arange(turns + 1))
    found: list[TurnScore | None] = []
    zero: float | None = None
    for number in range(turns):
        within = slice(ends[number], ends[number + 1])
        known = np.isfinite(error_arcsec[within])
        error, bin_number = error_arcsec[within][known], place[within][known]
        if not error.size:
            found.append(None)
            continue
        edges = np.bincount(bin_number, minlength=BINS)
        with np.errstate(invalid="ignore"):
            bins = np.bincount(bin_number, error, BINS) / edges
        mean = float(np.nanmean(bins))
        zero = mean if zero is None else zero
        single = error - mean
        found.append(
            TurnScore(
                error_arcsec=bins - mean,
                mean_arcsec=mean - zero,
                edges_rms_arcsec=float(np.sqrt(np.mean(single**2))),
                every_edge_arcsec=(float(single.min()), float(single.max())),
                amplitude_arcsec=amplitudes(bins - mean),
                edges=error.size,
            )
        )
    return found
