"""Tests that a line which is too fast for the averaged rows of a search gives no detection at its
alias. The logs are made in this module: a motor that turns to and fro, in coloured noise."""

from __future__ import annotations

import numpy as np
import pytest

from arctrue.measurement import MeasurementSet, Reference, Table
from arctrue.workbench.diagnose.report import sentences
from arctrue.workbench.effects.registry import built_in
from arctrue.workbench.inference.fit import fit
from arctrue.workbench.inference.forward import record as record_module
from arctrue.workbench.inference.forward.fast_lines import changes_evenly, fast_lines
from arctrue.workbench.inference.forward.of_solution import records_of
from arctrue.workbench.inference.forward.oscillation import oscillation_of
from arctrue.workbench.inference.forward.record import (
    MOST_ROWS,
    Record,
    averaged_fast_lines,
    record_of,
)
from arctrue.workbench.inference.forward.search import search_lines
from arctrue.workbench.model.growth import settle
from arctrue.workbench.model.model import default_model
from arctrue.workbench.observations.build import observations_of
from tests.workbench.base_diagnosis import diagnosis_of
from tests.workbench.noisy_logs import ornstein_uhlenbeck

ROWS_A_TURN, TURNS, TURN_S = 400, 4, 4.0
FAST = 110.0
"""Order of the fast line: 3.6 rows a period, and 1.2 averaged rows a period."""
SIZE_ARCSEC, NOISE_ARCSEC = 8.0, 2.0


def _motor(
    runs: int, order: float = FAST, turned_rad: float = 0.0
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Return time, turns, run and error of runs to and fro; ``turned_rad`` changes the phase of the
    line on the way back."""
    random = np.random.default_rng((16, runs))
    rows = ROWS_A_TURN * TURNS
    run = np.repeat(np.arange(runs), rows)
    time_s = TURN_S / ROWS_A_TURN * np.arange(runs * rows) + 20.0 * run
    way = np.arange(rows) / ROWS_A_TURN
    turns = np.concatenate([way if one % 2 == 0 else way[::-1] for one in range(runs)])
    noise = NOISE_ARCSEC * ornstein_uhlenbeck(random, time_s, 0.03)
    phase = 2.0 * np.pi * order * turns + 1.0 + turned_rad * (run % 2)
    return time_s, turns, run, SIZE_ARCSEC * np.cos(phase) + noise


def _record(runs: int, turned_rad: float, *, in_time: bool) -> Record:
    time_s, turns, run, error = _motor(runs, turned_rad=turned_rad)
    none = np.zeros((run.size, 0))
    assert run.size > MOST_ROWS
    fast = averaged_fast_lines([turns, time_s], run, error)
    place = time_s if in_time else turns
    return record_of(time_s, place, run, error, none, in_time=in_time, fast=fast)


@pytest.mark.parametrize("in_time", [False, True])
@pytest.mark.parametrize("turned_rad", [0.0, 2.0])
def test_the_averaged_rows_show_no_alias(turned_rad: float, in_time: bool) -> None:
    """A mean of three rows keeps sin(0.825π)/(3·sin(0.275π)) = 23 % of order 110, 1.8″, and shows
    it at order 133.3 − 110 = 23.3. The base contains the line with a phase for each sense of
    motion, so that the search finds neither a line nor an oscillation."""
    found = search_lines(_record(2, turned_rad, in_time=in_time))
    assert found.lines == ()
    assert oscillation_of(found, "reference") is None


@pytest.mark.parametrize("back", [False, True])
def test_white_noise_has_no_fast_line(back: bool) -> None:
    """One record in a hundred may show a line: more than three of 40 do so with a probability of
    10⁻³."""
    rows, found = 3000, 0
    number = np.arange(rows) // (rows // 2) if back else np.zeros(rows, dtype=np.int64)
    place = np.arange(rows) / 400.0
    place = np.where(number == 1, place[-1] - place, place)
    for seed in range(40):
        noise = np.random.default_rng((17, seed)).normal(size=rows)
        found += bool(list(fast_lines(place, number, noise, 5.0)))
    assert found <= 3


@pytest.mark.parametrize(
    ("sway_deg", "searches"),
    [(0.0, 1), (3.0, 2)],
    ids=["at one speed", "at a changing speed"],
)
def test_each_coordinate_is_searched_once(
    monkeypatch: pytest.MonkeyPatch, sway_deg: float, searches: int
) -> None:
    """At one speed, the angle and the time show the same fast lines, so that one search serves both
    records; at a changing speed each coordinate has its own search."""
    time_s = 0.05 * np.arange(4000)
    target_deg = 9.0 * time_s + sway_deg * np.sin(2.0 * np.pi * time_s / 97.0)
    error = np.random.default_rng(18).normal(size=time_s.size)
    reference = Reference(target_deg, error, time_s=time_s, direction=np.ones(time_s.size))
    observations = observations_of(MeasurementSet(Table(), None, reference))
    solution = fit(settle(default_model(), observations, built_in()), observations)
    seen = []

    def counted(*given: object) -> object:
        seen.append(given)
        return fast_lines(*given)  # type: ignore[arg-type]

    monkeypatch.setattr(record_module, "fast_lines", counted)
    assert records_of(solution, None)
    assert len(seen) == searches


def test_coordinates_that_change_evenly() -> None:
    """A row may deviate by 0.5 % of a period at the highest rate; this period has two rows, so that
    the limit is 0.01 rows."""
    one, row = np.zeros(1000, dtype=np.int64), np.arange(1000.0)
    moved = row + np.where(row == 500.0, 0.02, 0.0)
    assert changes_evenly(-3.0 * row + 7.0, row, one)
    assert not changes_evenly(moved, row, one)


def test_the_fast_line_is_removed_from_the_averaged_rows() -> None:
    """Only the noise remains: its mean over three rows, with a correlation of e^(−1/3) between
    neighbours, has √((3 + 4·0.717 + 2·0.513)/9) = 0.87 of the RMS of a row."""
    record = _record(2, 0.0, in_time=False)
    left = record.rows().left()
    assert float(np.sqrt(np.mean(left**2))) == pytest.approx(0.87 * NOISE_ARCSEC, rel=0.1)


def test_a_slower_line_stays_in_the_search() -> None:
    """Order 20 has 6.7 averaged rows a period and is found; nothing is removed from the record."""
    time_s, turns, run, error = _motor(2, order=20.0)
    none = np.zeros((run.size, 0))
    fast = averaged_fast_lines([turns, time_s], run, error)
    assert fast.columns.shape[1] == 0
    record = record_of(time_s, turns, run, error, none, in_time=False, fast=fast)
    found = search_lines(record)
    assert [line.rate for line in found.lines] == pytest.approx([20.0], abs=0.01)
    assert found.lines[0].amplitude_arcsec == pytest.approx(SIZE_ARCSEC, rel=0.05)


@pytest.mark.large
def test_the_report_states_line_and_reversal_but_no_alias() -> None:
    """The report names the line, states the reversal error of ±4″ (which two passes cannot confirm)
    and the RMS that remains, but no oscillation.

    A drift in the model leaves a quarter of the sum of squares of the column of the direction. The
    size of the reversal error, twice the coefficient, therefore has the standard uncertainty
    2·2″·√(6/3,200)/√(1/4) = 0.35″, where 6 rows are the correlation length of the noise (3 rows on
    each side).
    """
    time_s, turns, run, error = _motor(2)
    direction = np.where(run % 2 == 0, 1.0, -1.0)
    table = 60.0 * np.cos(2.0 * np.pi * turns) + 12.0 * np.cos(4.0 * np.pi * turns + 0.5)
    reference = Reference(
        target_deg=360.0 * turns,
        error_arcsec=error + table + 4.0 * direction,
        run=run,
        time_s=time_s,
        direction=direction,
    )
    found = diagnosis_of(MeasurementSet(Table(), None, reference))
    assert found.named is not None
    assert found.named.name == "periodic_error"
    words = " ".join(sentences(found))
    assert "oscillation" not in words
    assert "With the named effect in the model an error remains: reference 4." in words
    assert "Up and down differ by" in words
    reversal = found.detections.reversal
    assert reversal is not None
    assert not reversal.confirmed
    assert reversal.size_arcsec == pytest.approx(8.0, abs=4.0 * 0.35)
