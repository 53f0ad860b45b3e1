"""Tests that the diagnosis states when a reference or a head jumped, and by how much.

The sets are computed from the definitions (``small_sets``, or plain numpy in this module).
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from arctrue.measurement import MeasurementSet, Reference, Table
from arctrue.studies.benchmark.independent.sets import independent_set
from arctrue.workbench.diagnose.regular import detections_of
from arctrue.workbench.diagnose.report import sentences
from arctrue.workbench.effects.registry import built_in
from arctrue.workbench.inference.fit import fit
from arctrue.workbench.model.model import default_model
from arctrue.workbench.observations.build import observations_of
from tests.workbench.base_diagnosis import diagnosis_of
from tests.workbench.small_sets import REFERENCE_NOISE, measurement_set

EFFECTS = built_in()
WITHIN_U = 4.0
"""Accepted deviation of a size in standard uncertainties; a normal value exceeds it with a
probability of 6·10⁻⁵."""
STATION_S = 6.0


def _stations(
    error_arcsec: np.ndarray, stations: int, *, timed: bool = True, two_ways: bool = False
) -> MeasurementSet:
    """Return a set with only a reference: it visits some stations in cycles, on a table with errors
    of orders 1 and 3."""
    count = error_arcsec.size
    place = np.arange(count) % stations
    cycle = np.arange(count) // stations
    up = np.ones(count)
    if two_ways:
        up = np.where(cycle % 2 == 0, 1.0, -1.0)
        place = np.where(up > 0, place, stations - 1 - place)
    angle = 2.0 * np.pi * place / stations
    return MeasurementSet(
        table=Table(),
        reference=Reference(
            target_deg=np.degrees(angle),
            error_arcsec=30.0 * np.cos(angle + 0.3) + np.cos(3.0 * angle) + error_arcsec,
            run=np.zeros(count, dtype=np.int64),
            time_s=np.arange(count) * STATION_S if timed else None,
            direction=up if two_ways else None,
        ),
    )


@pytest.mark.parametrize(
    "size_arcsec",
    [
        1.0,
        pytest.param(-3.0, marks=pytest.mark.large),
        pytest.param(1800.0, marks=pytest.mark.large),
    ],
)
def test_a_knock_of_the_stand_with_a_capture(size_arcsec: float) -> None:
    """The diagnosis finds a jump after 60 % of the 288 readings of a polygon; the tested sizes are
    7 σ of a reading, 20 σ, and half a degree."""
    measured = measurement_set(seed=4)
    assert measured.reference is not None
    count = measured.reference.error_arcsec.size
    after = np.arange(count) >= int(0.6 * count)
    error = measured.reference.error_arcsec + size_arcsec * after
    found = diagnosis_of(
        replace(measured, reference=replace(measured.reference, error_arcsec=error))
    )
    assert found.verdict == "unknown"
    (jump,) = found.detections.steps
    assert jump.time_s == pytest.approx(4.0 * int(0.6 * count), abs=8.0)
    assert abs(jump.size_arcsec - size_arcsec) < WITHIN_U * jump.sigma_arcsec
    # Only about 115 of the 288 readings with 0.15″ of noise come after the step, and a drift is
    # fitted together with the step. The search for the noise stops at a ten-thousandth of the
    # scatter that was estimated without the step.
    most = max(3.0 * REFERENCE_NOISE / np.sqrt(115.0), 2e-4 * abs(size_arcsec))
    assert jump.sigma_arcsec < most
    assert any("something jumped at" in text for text in sentences(found)[:1])


@pytest.mark.parametrize(("stations", "two_ways"), [(36, False), (36, True), (12, False)])
def test_a_knock_in_stations_alone(stations: int, two_ways: bool) -> None:
    """The diagnosis finds a jump of 4″ in noise of 0.4″ without a capture, although most effects
    cannot be tested then."""
    random = np.random.default_rng((6, stations))
    count = 4 * stations
    at = int(0.4 * count) + 1
    error = 0.4 * random.normal(size=count) + 4.0 * (np.arange(count) >= at)
    found = diagnosis_of(_stations(error, stations, two_ways=two_ways))
    assert found.verdict == "unknown"
    (jump,) = found.detections.steps
    assert jump.time_s == pytest.approx(at * STATION_S, abs=STATION_S)
    assert abs(jump.size_arcsec - 4.0) < WITHIN_U * jump.sigma_arcsec


def test_a_slip_that_ends_with_its_run() -> None:
    """The diagnosis finds a slip that ends with its run: head 1 slips by 19.8″ in the second of
    four runs, and passes its index before the third run."""
    random = np.random.default_rng(7)
    run = np.arange(144) // 36
    error = 0.2 * random.normal(size=144) + 19.8 * ((run == 1) & (np.arange(144) >= 48))
    measured = _stations(error, 36)
    assert measured.reference is not None
    found = diagnosis_of(replace(measured, reference=replace(measured.reference, run=run)))
    assert found.verdict == "unknown"
    (jump,) = found.detections.steps
    assert jump.time_s == pytest.approx(48 * STATION_S, abs=STATION_S)
    assert abs(jump.size_arcsec - 19.8) < WITHIN_U * jump.sigma_arcsec


def test_without_times_the_row_is_said() -> None:
    random = np.random.default_rng(8)
    error = 0.3 * random.normal(size=144) + 5.0 * (np.arange(144) >= 80)
    found = diagnosis_of(_stations(error, 36, timed=False))
    (jump,) = found.detections.steps
    assert (jump.time_s, jump.turns, jump.row) == (None, None, 80)
    assert "something jumped at row 80 by" in jump.words()


def test_the_row_of_a_jump_counts_the_rows_that_are_not_used() -> None:
    """The stated row is the row of the file: the set does not use the rows 10 to 39, and the
    readings jump at row 150."""
    random = np.random.default_rng(8)
    rows = np.arange(252)
    measured = _stations(0.3 * random.normal(size=252) + 5.0 * (rows >= 150), 36, timed=False)
    assert measured.reference is not None
    mask = (rows >= 10) & (rows < 40)
    observations = observations_of(
        replace(measured, reference=replace(measured.reference, mask=mask))
    )
    solution = fit(default_model().terms(EFFECTS), observations)
    (jump,) = detections_of(solution, EFFECTS).steps
    assert jump.row == 150
    assert "something jumped at row 150 by" in jump.words()


@pytest.mark.large
def test_what_a_named_effect_makes_is_no_jump() -> None:
    """The steps of the residual that a delay causes, where the speed of the table changes, are no
    jumps."""
    measured, _ = independent_set("moving_reference", "hidden", 101, 1500)
    found = diagnosis_of(measured)
    assert found.named is not None
    assert found.named.name == "latency"
    assert found.detections.steps == ()


def test_a_reversal_error_of_one_reversal_is_no_jump() -> None:
    """The reversal error of a single reversal is no jump: all stations are visited first upwards
    and then downwards, and an effect of the direction changes only once, between the two."""
    random = np.random.default_rng(9)
    count = 144
    measured = _stations(0.3 * random.normal(size=count), 36)
    assert measured.reference is not None
    up = np.where(np.arange(count) < 72, 1.0, -1.0)
    changed = replace(
        measured.reference,
        direction=up,
        error_arcsec=measured.reference.error_arcsec + 2.0 * up,
    )
    assert diagnosis_of(replace(measured, reference=changed)).detections.steps == ()


@pytest.mark.large
def test_an_excursion_of_slow_noise_is_no_jump() -> None:
    """In 30 logs with Ornstein-Uhlenbeck noise and white noise, a jump is found at most once.

    Each log may show a false jump with a probability of 1 %; two or more then have one of 4 %.
    """
    rows, found = 400, 0
    time_s = 0.5 * np.arange(rows)
    kept = np.exp(-0.5 / (0.15 * time_s[-1]))
    angle = 4.0 * np.pi * np.arange(rows) / rows
    for seed in range(30):
        random = np.random.default_rng(seed)
        slow = np.empty(rows)
        slow[0] = random.normal()
        for row in range(1, rows):
            slow[row] = kept * slow[row - 1] + np.sqrt(1.0 - kept**2) * random.normal()
        error = 20.0 * np.cos(angle) + 0.7 * slow + 0.7 * random.normal(size=rows)
        run = np.zeros(rows, dtype=np.int64)
        reference = Reference(np.degrees(angle), error, time_s=time_s, run=run)
        found += bool(diagnosis_of(MeasurementSet(Table(), reference=reference)).detections.steps)
    assert found <= 1
