"""Calculates the motion of the axis that does not repeat from turn to turn (asynchronous error
motion, ISO 230-7) from turns of four heads, with the equations of the firmware.

Simultaneous readings of four heads give the displacement c = x + jy of the axis at every sample.
The running mean of its lines at the orders −N to N is the motion that repeats. The mean square of
the remainder, minus the share of the noise, is the square of the result. The mean has the relative
variance v, so the squared difference between a line and the mean is on average 1 + v times the
variance of the line; it is divided by 1 + v. Motion of the axis above order N and a drift from turn
to turn count as motion that does not repeat. Errors of the disc above order N appear as noise of
the parity and make the result too small.

The firmware forms the same sums sample by sample: firmware/calibration/axis_motion.c.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Float = NDArray[np.float64]
Complex = NDArray[np.complex128]

KEEP = 0.95
"""Weight of the former turns at each new turn; the mean then covers 20 turns."""


@dataclass(frozen=True)
class AxisTurn:
    """One turn, arcseconds.

    ``unit`` (n,): e^{jR₁}. ``share`` (n,): share of the turn that belongs to each sample.
    ``residuals`` (H, n): readings minus the fit. ``sight`` (H,): ρᵢ·e^{jpᵢ}. ``off_arcsec`` (H,):
    offsets minus the nominal places; they contain the motion at order 0. ``forward`` and
    ``backward``: motion at the orders 1 and −1 that the fit contains. ``gain`` (N,): noise gain of
    each order of the disc, infinite if the heads do not determine the order; order 1 is not used.
    ``variance``: of one reading. ``colour``: power of the noise at the disc's orders divided by its
    mean power.
    """

    unit: Complex
    share: Float
    residuals: Float
    places_rad: Float
    sight: Complex
    off_arcsec: Float
    forward: complex
    backward: complex
    gain: Float
    variance: float
    colour: float


@dataclass(frozen=True)
class AxisMean:
    """Mean of the lines at the orders −N to N. ``turns``: sum of the weights of all turns;
    ``variance``: variance of the mean divided by the variance of one turn."""

    lines: Complex
    turns: float
    variance: float


@dataclass(frozen=True)
class Asynchronous:
    """RMS of the motion that does not repeat, over both directions, arcseconds at the disc, with
    its standard uncertainty."""

    arcsec: float
    u_arcsec: float


def turn_shares(counts: NDArray[np.int64], counts_per_rev: int) -> Float:
    """Return the share of the turn that belongs to each sample: half the angle between its
    neighbours."""
    whole = int(np.sign(np.median(np.diff(counts)))) * counts_per_rev
    closed = np.concatenate((counts[-1:] - whole, counts, counts[:1] + whole))
    return np.asarray(0.5 * (closed[2:] - closed[:-2]) / whole)


def add_turn(turn: AxisTurn, mean: AxisMean | None) -> tuple[AxisMean, Asynchronous | None]:
    """Add a turn to the mean of the former turns. The result is None for the first turn."""
    heads, samples = turn.residuals.shape
    orders = np.arange(-turn.gain.size, turn.gain.size + 1)
    design = np.column_stack((np.ones(heads), turn.sight.imag, turn.sight.real))
    inverse = np.linalg.pinv(design)[1:]
    by = inverse[0] + 1j * inverse[1]
    motion = by @ turn.residuals
    lines = (turn.share * motion) @ turn.unit[:, None] ** -orders
    left = float(turn.share @ np.abs(motion) ** 2 - np.sum(np.abs(lines) ** 2))
    fitted = {0: complex(by @ turn.off_arcsec), 1: turn.forward, -1: turn.backward}
    for order, value in fitted.items():
        lines[turn.gain.size + order] += value
    if mean is None or mean.lines.size != lines.size:
        return AxisMean(lines, 1.0, 1.0), None
    share = 1.0 / (KEEP * mean.turns + 1.0)
    v = mean.variance
    after = AxisMean(
        mean.lines + share * (lines - mean.lines), 1.0 / share, (1.0 - share) ** 2 * v + share**2
    )
    changed = float(np.sum(np.abs(lines - mean.lines) ** 2)) / (1.0 + v)
    covariance = inverse @ inverse.T
    noise = turn.variance * float(np.trace(covariance))
    at = np.exp(1j * np.multiply.outer(np.arange(2, turn.gain.size + 1), turn.places_rad))
    seen = np.isfinite(turn.gain[1:])
    squares = np.abs(at @ by) ** 2 + np.abs(at.conj() @ by) ** 2
    of_disc = float(np.sum(turn.gain[1:][seen] ** 2 * squares[seen])) * turn.colour / samples
    square = max(left + changed - noise - turn.variance * of_disc, 0.0)
    of_noise = 2.0 * turn.variance**2 * float(np.sum(covariance**2)) + 2.0 * noise * square
    variance = of_noise / samples + 2.0 * noise**2 / (samples - 2.0 * turn.gain.size)
    variance += v * (2.0 + v) * (changed / (1.0 + v)) ** 2
    root = float(np.sqrt(square))
    return after, Asynchronous(root, float(np.sqrt(square + np.sqrt(variance))) - root)
