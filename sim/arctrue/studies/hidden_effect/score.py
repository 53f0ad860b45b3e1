"""A turn of a signal, edge by edge against the true angle."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from arctrue.instrument import EdgeTrack, InstrumentError

Float = NDArray[np.float64]

PHASE_BINS = 64
SLOW_ORDERS = 12
MOST_EDGES = 100_000
SIGNAL_MULTIPLES = (1, 2, 3, 4)


@dataclass(frozen=True, slots=True)
class SignalScore:
    """Error of one signal over a turn, its mean removed; arcseconds."""

    lowest_arcsec: float
    """Of every edge, as the two below."""
    highest_arcsec: float
    rms_arcsec: float
    angle_rad: Float
    """Middle of each part of the turn, shape ``(bins,)``; the errors in it, same shape."""
    bin_lowest_arcsec: Float
    bin_highest_arcsec: Float
    bin_mean_arcsec: Float
    phase_arcsec: Float
    """Mean error at each phase of head 1's signal period, without the slow errors, shape (64,)."""
    order_arcsec: Float
    """Amplitude of orders 1, 2, …, shape ``(12,)``."""
    signal_arcsec: Float
    """Amplitude of 1, 2, … periods in a period of the signal, shape ``(4,)``."""

    def as_json(self) -> dict[str, Any]:
        """Everything as plain values."""
        return {
            name: value.tolist() if isinstance(value, np.ndarray) else value
            for name in self.__slots__
            for value in (getattr(self, name),)
        }


def score(track: EdgeTrack, head1: EdgeTrack, lines: int) -> SignalScore:
    """The score of ``track``, which is ``head1`` itself or the output beside it.

    Raises InstrumentError where a part of the turn holds no edge.
    """
    if not track.bin_edges.size or not track.bin_edges.all():
        raise InstrumentError("the recording does not hold a whole turn")
    scale = 1_296_000.0 / track.counts_per_rev
    # An odd step meets every phase of the signal period.
    step = track.position.size // MOST_EDGES | 1
    angle, position = track.true_angle_rad[::step], track.position[::step]
    error = position - angle * (track.counts_per_rev / (2 * np.pi))
    middle = float(np.mean(track.bin_mean_counts))
    error_arcsec = (error - middle) * scale
    side = 1 if track.true_angle_rad[-1] > track.true_angle_rad[0] else -1
    reading = np.interp(angle, head1.true_angle_rad[::side], head1.position[::side])
    phase = np.mod(reading * (lines / track.counts_per_rev), 1.0)
    columns = _waves(angle, np.arange(1, SLOW_ORDERS + 1))
    slow = np.linalg.lstsq(columns, error_arcsec, rcond=None)[0]
    quick = error_arcsec - columns @ slow
    waves = _waves(2 * np.pi * phase, np.array(SIGNAL_MULTIPLES))
    fast = np.linalg.lstsq(waves, quick, rcond=None)[0]
    place = np.minimum((phase * PHASE_BINS).astype(np.int64), PHASE_BINS - 1)
    met = np.maximum(np.bincount(place, minlength=PHASE_BINS), 1)
    low, high = track.extremes_arcsec()
    return SignalScore(
        lowest_arcsec=low,
        highest_arcsec=high,
        rms_arcsec=float(np.std(error_arcsec)),
        angle_rad=track.bin_angle_rad,
        bin_lowest_arcsec=(track.bin_lowest_counts - middle) * scale,
        bin_highest_arcsec=(track.bin_highest_counts - middle) * scale,
        bin_mean_arcsec=(track.bin_mean_counts - middle) * scale,
        phase_arcsec=np.bincount(place, quick, PHASE_BINS) / met,
        order_arcsec=_amplitudes(slow),
        signal_arcsec=_amplitudes(fast),
    )


def _waves(angle_rad: Float, orders: NDArray[np.int64]) -> Float:
    """A constant, then cos and sin of each order, shape ``(n, 1 + 2·orders)``."""
    columns = [np.ones_like(angle_rad)]
    for order in orders.tolist():
        columns += [np.cos(order * angle_rad), np.sin(order * angle_rad)]
    return np.stack(columns, axis=1)


def _amplitudes(solution: NDArray[np.floating]) -> Float:
    return np.asarray(np.hypot(solution[1::2], solution[2::2]), dtype=np.float64)
