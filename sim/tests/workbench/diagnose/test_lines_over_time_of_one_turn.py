"""Tests that the diagnosis names no line over time (a sine of constant frequency) in a log of one
turn in both directions, because an error that depends on the direction looks like such a line."""

from __future__ import annotations

import numpy as np

from arctrue.measurement import MeasurementSet, Reference, Table
from arctrue.workbench.diagnose.regular import findings_of
from arctrue.workbench.effects.registry import built_in
from arctrue.workbench.inference.fit import fit
from arctrue.workbench.model.model import default_model
from arctrue.workbench.observations.build import observations_of

EFFECTS = built_in()
ROWS, SWEEP_S = 120, 20.0
HIGHEST_ORDER = ROWS / 4.0
"""Highest order of the search: a period needs four rows."""


def _searched(senses: list[int], frequency_hz: float) -> bool:
    """Tell whether the diagnosis leaves a line of this frequency to the forward search, in a log of
    passes over one turn, each upward (1) or downward (-1)."""
    way = np.linspace(0.0, 1.0, ROWS, endpoint=False)
    place = np.concatenate([way if sense > 0 else way[::-1] for sense in senses])
    direction = np.repeat(senses, ROWS)
    error = np.random.default_rng(1).normal(size=place.size)
    reference = Reference(
        target_deg=360.0 * place,
        error_arcsec=error + direction * np.cos(2.0 * np.pi * 7.0 * place),
        time_s=SWEEP_S / ROWS * np.arange(place.size),
        direction=direction,
        run=np.repeat(np.arange(len(senses)), ROWS),
    )
    measured = MeasurementSet(Table(), None, reference, title="servo")
    solution = fit(default_model().terms(EFFECTS), observations_of(measured))
    place_of_line = {"in_time": 1.0, "frequency": frequency_hz, "order": 0.0, "in_capture": 0.0}
    return findings_of(solution, EFFECTS).searched(place_of_line)


def test_slow_lines_over_time_are_left_to_the_search() -> None:
    """In passes over one turn the search tests integer orders only, so that it accepts no line over
    time."""
    assert _searched([1, -1, 1], 0.22)


def test_a_line_in_one_direction_is_tested_by_the_other_searches() -> None:
    assert not _searched([1, 1, 1], 0.22)


def test_a_line_faster_than_every_order_is_no_error_of_the_direction() -> None:
    """The limit is the frequency of the highest order at the speed of the log."""
    highest_hz = HIGHEST_ORDER / SWEEP_S
    assert _searched([1, -1, 1], 0.9 * highest_hz)
    assert not _searched([1, -1, 1], 1.1 * highest_hz)
