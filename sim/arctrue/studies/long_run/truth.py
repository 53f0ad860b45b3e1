"""The table's own error in each turn of a scenario, and what coefficients leave of it."""

from __future__ import annotations

import dataclasses

import numpy as np
from msgspec import structs
from numpy.typing import NDArray

from arctrue.base.units import ARCSEC_PER_RAD, arcsec_per_count
from arctrue.studies.scenario import Scenario, ScenarioTurn

Float = NDArray[np.float64]

PLACES = 360
"""In a turn: three times the highest order that is asked for, and more."""
TURN_RAD = 2.0 * np.pi


class Truth:
    """By the geometry of the table, without noise and without steps of counts."""

    def __init__(self, scenario: Scenario) -> None:
        """Of head 1; the zero is left out, as two heads do not see it."""
        quiet = structs.replace(scenario.errors, noise_arcsec=0.0)
        self._table = dataclasses.replace(scenario, errors=quiet).table()
        self._course = scenario.course()
        self._count_arcsec = arcsec_per_count(scenario.scale.counts_per_rev)

    def _turn(self, number: int) -> tuple[Float, Float]:
        """Reading in radians and error in arcsec, (PLACES,), at even instants of a turn."""
        begin, end = (self._course.time_at_turn(float(turn)) for turn in (number - 1, number))
        places: Float = (np.arange(PLACES) + 0.5) / PLACES
        instants: Float = begin + places * (end - begin)
        state = self._course.state(instants)
        reading = self._table.reading_rad(0, state)
        error = (reading - state.angle_rad) * ARCSEC_PER_RAD
        return reading, error - error.mean()

    def error_arcsec(self, number: int) -> Float:
        """Reading less true angle in turn ``number`` (first: 1), its mean removed, (PLACES,)."""
        return self._turn(number)[1]

    def left_arcsec(self, turn: ScenarioTurn) -> float:
        """RMS of what the coefficients at the end of a turn leave of that turn's error."""
        reading, error = self._turn(turn.number)
        if turn.bank is not None:
            bank = turn.bank
            lanes = bank.amplitudes_counts[:, None] * np.cos(
                np.outer(bank.orders, reading) + bank.phases_rad[:, None]
            )
            correction = lanes.sum(axis=0) * self._count_arcsec
            error = error - (correction - correction.mean())
        return float(np.sqrt(np.mean(error**2)))
