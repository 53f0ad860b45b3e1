"""Computes the true error of the table in each turn of a scenario, and the error that remains after
a correction."""

from __future__ import annotations

import dataclasses

import numpy as np
from msgspec import structs
from numpy.typing import NDArray

from arctrue.base.units import ARCSEC_PER_RAD, arcsec_per_count
from arctrue.studies.scenario import Scenario, ScenarioTurn

Float = NDArray[np.float64]

PLACES = 360
"""Number of angles per turn at which the error is computed: at least three times the highest
requested order."""
TURN_RAD = 2.0 * np.pi


class Truth:
    """Computes the error from the table's geometry, without noise and quantisation."""

    def __init__(self, scenario: Scenario) -> None:
        """Build the scenario's table without noise. The class evaluates only head 1."""
        quiet = structs.replace(scenario.errors, noise_arcsec=0.0)
        self._table = dataclasses.replace(scenario, errors=quiet).table()
        self._course = scenario.course()
        self._count_arcsec = arcsec_per_count(scenario.scale.counts_per_rev)

    def _turn(self, number: int) -> tuple[Float, Float]:
        """Return readings in radians and errors in arcseconds, (PLACES,), at evenly spaced instants
        of a turn.

        The mean is removed from the errors, because two heads cannot measure the mean.
        """
        begin, end = (self._course.time_at_turn(float(turn)) for turn in (number - 1, number))
        places: Float = (np.arange(PLACES) + 0.5) / PLACES
        instants: Float = begin + places * (end - begin)
        state = self._course.state(instants)
        reading = self._table.reading_rad(0, state)
        error = (reading - state.angle_rad) * ARCSEC_PER_RAD
        return reading, error - error.mean()

    def error_arcsec(self, number: int) -> Float:
        """Return the true error in turn ``number`` (first: 1), mean removed, (PLACES,)."""
        return self._turn(number)[1]

    def left_arcsec(self, turn: ScenarioTurn) -> float:
        """Return the RMS of the error that remains in a turn with the coefficients of the turn's
        end.
        """
        reading, error = self._turn(turn.number)
        if turn.bank is not None:
            bank = turn.bank
            lanes = bank.amplitudes_counts[:, None] * np.cos(
                np.outer(bank.orders, reading) + bank.phases_rad[:, None]
            )
            correction = lanes.sum(axis=0) * self._count_arcsec
            error = error - (correction - correction.mean())
        return float(np.sqrt(np.mean(error**2)))
