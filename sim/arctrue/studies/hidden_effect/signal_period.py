"""Computes the error of a signal over one period of the grating, without the errors of low orders
per turn."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from arctrue.base.units import ARCSEC_PER_TURN
from arctrue.instrument import EdgeTrack

Float = NDArray[np.float64]

PHASE_BINS = 64
SLOW_ORDERS = 12
MOST_EDGES = 100_000
SIGNAL_MULTIPLES = (1, 2, 3, 4)


@dataclass(frozen=True, slots=True)
class SignalPeriod:
    """Error over one period of head 1's signal, averaged over all periods of a turn; arcseconds."""

    mean_arcsec: Float
    """Mean error at each phase, shape ``(64,)``."""
    amplitude_arcsec: Float
    """Amplitudes of the harmonics 1 to 4 of the period, shape ``(4,)``."""

    def as_json(self) -> dict[str, Any]:
        """Return errors and amplitudes as plain values."""
        return {
            "mean_arcsec": self.mean_arcsec.tolist(),
            "amplitude_arcsec": self.amplitude_arcsec.tolist(),
        }


def signal_period(track: EdgeTrack, head1: EdgeTrack, lines: int) -> SignalPeriod:
    """Average the error at the kept edges of ``track`` by the phase of ``head1``'s signal.

    ``track`` is ``head1`` itself or the output.
    """
    # With an odd step, the kept edges cover every phase of the signal period.
    step = track.position.size // MOST_EDGES | 1
    angle, position = track.true_angle_rad[::step], track.position[::step]
    error = position - angle * (track.counts_per_rev / (2 * np.pi))
    error_arcsec = (error - float(np.mean(error))) * (ARCSEC_PER_TURN / track.counts_per_rev)
    side = 1 if track.true_angle_rad[-1] > track.true_angle_rad[0] else -1
    reading = np.interp(angle, head1.true_angle_rad[::side], head1.position[::side])
    phase = np.mod(reading * (lines / track.counts_per_rev), 1.0)
    columns = _waves(angle, np.arange(1, SLOW_ORDERS + 1))
    quick = error_arcsec - columns @ np.linalg.lstsq(columns, error_arcsec, rcond=None)[0]
    waves = _waves(2 * np.pi * phase, np.array(SIGNAL_MULTIPLES))
    fast = np.linalg.lstsq(waves, quick, rcond=None)[0]
    place = np.minimum((phase * PHASE_BINS).astype(np.int64), PHASE_BINS - 1)
    met = np.maximum(np.bincount(place, minlength=PHASE_BINS), 1)
    return SignalPeriod(
        np.bincount(place, quick, PHASE_BINS) / met,
        np.asarray(np.hypot(fast[1::2], fast[2::2]), dtype=np.float64),
    )


def _waves(angle_rad: Float, orders: NDArray[np.int64]) -> Float:
    """Return a constant, then cos and sin of each order, shape ``(n, 1 + 2·orders)``."""
    columns = [np.ones_like(angle_rad)]
    for order in orders.tolist():
        columns += [np.cos(order * angle_rad), np.sin(order * angle_rad)]
    return np.stack(columns, axis=1)
