"""Tests that the heads' readings determine the phase of a line (one harmonic) over many turns,
although the line's order is not an integer and changes at random."""

from __future__ import annotations

import numpy as np
import pytest

from arctrue.calibration.line_phase import LineFinder

ALPHA = np.radians(33.0)
ARCSEC = np.pi / 648_000.0
SAMPLES = 1_500
NOISE_ARCSEC = 0.14
TURNS = 1_000


class Slipping:
    """A disc with integer orders and a line whose order changes at random by the share ``slip``
    (RMS) of its value.

    The slips are correlated over ``memory`` turns; with 0 the slips of different turns are
    independent.
    """

    def __init__(
        self, order: float, amplitude_arcsec: float, seed: int, slip: float, memory: float = 0.0
    ) -> None:
        self.order, self.amplitude = order, amplitude_arcsec
        self.random = np.random.default_rng(seed)
        keep = np.exp(-1.0 / memory) if memory else 0.0
        drawn = self.random.standard_normal(TURNS + 8)
        for turn in range(1, drawn.size):
            drawn[turn] = keep * drawn[turn - 1] + np.sqrt(1.0 - keep**2) * drawn[turn]
        # Phase at the start of each turn; the slip of a turn is spread evenly over the turn.
        steps = order * (1.0 + slip * drawn)
        self.phase = 0.17 + np.concatenate([[0.0], np.cumsum(steps)])

    def line(self, place: np.ndarray) -> np.ndarray:
        """Return the line in arcseconds at these places, which are in turns."""
        phase = np.interp(place, np.arange(self.phase.size), self.phase)
        return np.asarray(self.amplitude * np.cos(2.0 * np.pi * phase))

    def error(self, place: np.ndarray) -> np.ndarray:
        theta = 2.0 * np.pi * place
        whole = 150.0 * np.cos(theta + 0.4) + 6.0 * np.cos(2.0 * theta + 4.2)
        return np.asarray(whole + 1.2 * np.cos(7.0 * theta + 2.9) + self.line(place))

    def turn(self, first: float) -> tuple[np.ndarray, np.ndarray]:
        """Return the reading of head 1 in turns, and the difference of the heads in arcseconds."""
        place = first + np.arange(SAMPLES) / SAMPLES
        ahead = place + ALPHA / (2.0 * np.pi)
        noise = self.random.normal(0.0, NOISE_ARCSEC, SAMPLES)
        reading = place + self.error(place) * ARCSEC / (2.0 * np.pi)
        return reading, self.error(ahead) - self.error(place) + noise


@pytest.mark.parametrize(
    ("order", "amplitude", "memory"),
    [(0.42, 4.0, 50.0), (0.5, 4.0, 50.0), (7.3, 4.0, 0.0), (7.3, 4.0, 50.0)],
    ids=["cage", "half order", "ball pass", "ball pass, slow slip"],
)
@pytest.mark.parametrize("follows", [True, pytest.param(False, marks=pytest.mark.large)])
def test_a_slipping_line_is_followed_to_a_quarter(
    order: float, amplitude: float, memory: float, follows: bool
) -> None:
    """If the correction of each turn uses the phase from the preceding turn, at most a quarter of
    the line (RMS) remains in 1,000 turns.

    A phase that is determined once and then kept leaves a much larger error.
    """
    disc = Slipping(order, amplitude, 5, 0.001, memory)
    finder = LineFinder(order, amplitude)
    left, seen, phase = 0.0, 0, None
    for number in range(TURNS):
        # Each capture starts 0.37 of a turn after the zero.
        reading, difference = disc.turn(number + 0.37)
        if phase is not None:
            place = number + 1.0 + np.linspace(0.0, 1.0, 64)
            lane = amplitude * np.cos(2.0 * np.pi * (order * place + phase))
            left += float(np.mean((disc.line(place) - lane) ** 2))
            seen += 1
        turn = np.floor(reading).astype(np.int64)
        finder.add(
            reading - turn, turn, difference, separation_rad=ALPHA, noise_arcsec=NOISE_ARCSEC
        )
        if finder.is_known and (follows or phase is None):
            phase = finder.phase_turns
    assert seen > 0.97 * TURNS
    share = float(np.sqrt(2.0 * left / seen)) / amplitude
    assert share <= 0.25 if follows else share > 0.3, share


def test_a_disc_without_the_line_gives_no_phase() -> None:
    disc = Slipping(7.3, 0.0, 6, 0.0)
    finder = LineFinder(7.3, 4.0)
    for number in range(40):
        reading, difference = disc.turn(number + 0.37)
        turn = np.floor(reading).astype(np.int64)
        finder.add(
            reading - turn, turn, difference, separation_rad=ALPHA, noise_arcsec=NOISE_ARCSEC
        )
        assert not finder.is_known
    assert np.hypot(*finder.state[2:]) < 0.2
