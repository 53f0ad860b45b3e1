"""Tracks the phase of a line (a sine in the error) of non-integer order from turn to turn, from the
difference of two heads.

The error ε of head 1 has a line Re(c e^{jνΘ}), where ν is not an integer and Θ is the angle counted
over the turns. A line that is fixed to the disc appears in head 2 minus head 1 as Re(c g e^{jνΘ})
with g = e^{jνα} − 1. Let θ = Θ modulo a turn, and w each sample's share of the turn. S = Σ w (R₂ −
R₁ − α₀) e^{−jνθ} is a sum over a turn; all integer orders and all constants contribute the same
value K to it in every turn. Only the line changes from turn to turn: S = K + (c g A + c* g* B)/2,
where A = Σ w e^{jν(Θ − θ)} and B = Σ w e^{−jν(Θ + θ)}. Two Kalman filter updates per turn, with the
real and the imaginary part of S, estimate K and c; c is modelled as a random walk, because the line
slips.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

Float = NDArray[np.float64]

SLIP = 0.001
"""Standard deviation of the slip of a line in one turn, as a share of its order."""
START_ARCSEC = 1e4
"""Standard deviation of K before the first turn, which is far larger than any error of a table."""
LEAST_TURNS = 4
"""Number of turns before a phase counts as known; two turns would already determine K and c."""
SIGMAS = 3.0
"""Number of standard uncertainties by which |c| must exceed half the loaded amplitude, so that the
phase counts as known. If |c| is less than half the loaded amplitude, the lane (the circuit that
subtracts the line with this amplitude) increases the error."""
LARGEST_SHARE = 0.125
"""Largest ratio of the standard uncertainty of c to |c| at which the phase counts as known; twice
the uncertainty is then a quarter of |c|."""


@dataclass
class LineFinder:
    """State of the filter for one line; arrays hold [Re K, Im K, Re c, Im c], arcseconds."""

    order: float
    amplitude_arcsec: float
    """Amplitude of the line in the loaded coefficients, arcseconds."""
    state: Float = field(default_factory=lambda: np.zeros(4))
    covariance: Float = field(default_factory=lambda: np.zeros((4, 4)))
    turns: int = 0
    last_turn: int = 0
    is_known: bool = False

    def add(
        self,
        theta_turns: Float,
        turn: NDArray[np.int64],
        difference_arcsec: Float,
        *,
        separation_rad: float,
        noise_arcsec: float,
    ) -> None:
        """Update the filter with the samples of one turn.

        Parameters
        ----------
        theta_turns : Float
            Angles of head 1 within the turn, in turns, shape ``(n,)``.
        turn : NDArray[np.int64]
            Number of the turn of each sample, ``(n,)``; the samples cover one turn of the angle.
        difference_arcsec : Float
            R₂ − R₁ − α₀ of each sample, ``(n,)``; α₀ is any constant.
        separation_rad : float
            Angle α between the heads.
        noise_arcsec : float
            Standard deviation of the noise of one difference, arcseconds.
        """
        place = turn + theta_turns
        way = 1.0 if place[-1] > place[0] else -1.0
        around = np.concatenate([[place[-1] - way], place, [place[0] + way]])
        share = 0.5 * way * (around[2:] - around[:-2])
        wave = np.exp(-2j * np.pi * self.order * theta_turns)
        gone_on = np.exp(2j * np.pi * np.modf(turn * math.modf(self.order)[0])[0])
        total = np.sum(share * difference_arcsec * wave)
        seen = np.exp(1j * self.order * separation_rad) - 1.0
        forward = 0.5 * seen * np.sum(share * gone_on)
        backward = 0.5 * np.conj(seen) * np.sum(share * wave**2 * np.conj(gone_on))
        cosine, sine = forward + backward, 1j * (forward - backward)
        variance = 0.5 * noise_arcsec**2 / theta_turns.size
        self._go_on(int(turn[0]), variance)
        for row, value in (
            (np.array([1.0, 0.0, cosine.real, sine.real]), total.real),
            (np.array([0.0, 1.0, cosine.imag, sine.imag]), total.imag),
        ):
            self._update(row, float(value), variance)
        self.turns += 1
        self.last_turn = int(turn[0])
        self._judge()

    def _go_on(self, turn: int, variance: float) -> None:
        """Advance K and c by their random steps since the last turn."""
        if self.turns == 0:
            size = 4.0 * self.amplitude_arcsec**2
            self.covariance = np.diag([START_ARCSEC**2, START_ARCSEC**2, size, size])
            return
        gone = abs(turn - self.last_turn)
        slip = 2.0 * np.pi * self.order * SLIP * self.amplitude_arcsec
        self.covariance += gone * np.diag([variance, variance, slip**2, slip**2])

    def _update(self, row: Float, value: float, variance: float) -> None:
        spread = self.covariance @ row
        gain = spread / (row @ spread + variance)
        self.state = self.state + gain * (value - row @ self.state)
        self.covariance = self.covariance - np.outer(gain, spread)

    def _judge(self) -> None:
        size = math.hypot(self.state[2], self.state[3])
        u = self.u_arcsec
        half = 0.5 * self.amplitude_arcsec
        if self.is_known:
            self.is_known = size >= half
        else:
            self.is_known = (
                self.turns >= LEAST_TURNS
                and size - SIGMAS * u >= half
                and u <= LARGEST_SHARE * size
            )

    @property
    def u_arcsec(self) -> float:
        """Return the standard uncertainty of a component of c, arcseconds."""
        return math.sqrt(0.5 * (self.covariance[2, 2] + self.covariance[3, 3]))

    @property
    def phase_turns(self) -> float:
        """Return the phase at angle 0 of turn 0, turns: the line is |c| cos(2π(νΘ + phase))."""
        return math.atan2(self.state[3], self.state[2]) / (2.0 * np.pi)
