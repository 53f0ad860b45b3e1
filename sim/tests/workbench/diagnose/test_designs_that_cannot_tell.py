"""Tests of sets in which two conditions changed together, and of sets whose readings a display
rounded."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from sim.tests.workbench.small_sets import (
    ALPHA,
    ARCSEC,
    COUNTS_PER_REV,
    LINES,
    measurement_set,
    paper_error,
)

from arctrue.measurement import Capture, MeasurementSet, Reference, Table
from arctrue.studies.benchmark.diagnosis import diagnosed
from arctrue.workbench.diagnose.parts_scan import best_parts
from arctrue.workbench.diagnose.report import sentences
from arctrue.workbench.effects.part_conditions import settling_condition
from arctrue.workbench.effects.registry import built_in
from arctrue.workbench.inference.design_matrix import Term
from arctrue.workbench.inference.fit import fit
from arctrue.workbench.inference.residuals import Residuals
from arctrue.workbench.observations.build import observations_of
from arctrue.workbench.observations.display_step import display_step


def _warming(seed: int, *, cools: bool = False) -> MeasurementSet:
    """Return a set with one run, in which head 2 drifts with time by 1.2″ while the table warms by
    3 K.

    With ``cools`` the table warms and cools again, which separates temperature and time.
    """
    random = np.random.default_rng(seed)
    size, turns = 6000, 5
    angle = 0.3 + np.arange(size) * 2.0 * np.pi * turns / size
    time = np.arange(size) * 0.01
    share = time / time[-1]
    warm = 20.0 + 3.0 * (np.sin(np.pi * share) if cools else share)
    readings = []
    for offset, drift in ((0.0, 0.0), (ALPHA, 0.02)):
        value = angle + offset + paper_error(angle + offset, warm, 1.0) * ARCSEC
        value = value + drift * time * ARCSEC + random.normal(0.0, 0.1 * ARCSEC, size)
        readings.append(np.round(value / (2.0 * np.pi) * COUNTS_PER_REV).astype(np.int64))
    capture = Capture(np.zeros(size, dtype=np.int64), time, *readings, temperature_c=warm)
    table = Table(
        counts_per_rev=COUNTS_PER_REV,
        grating_lines=LINES,
        disc_diameter_mm=107.95,
        head_separation_deg=33.0,
    )
    return MeasurementSet(table, capture, None, title="one run")


@pytest.mark.parametrize(
    "seed", [*(pytest.param(seed, marks=pytest.mark.large) for seed in range(3)), 3]
)
def test_a_run_that_warms_evenly_does_not_tell_temperature_from_time(seed: int) -> None:
    _, found = diagnosed(_warming(seed))
    assert found.verdict == "ambiguous"
    assert found.effect_class == ["thermal_head_drift"]
    assert found.described is not None
    assert found.described.effect.parts == ["time", "head2"]  # type: ignore[attr-defined]
    # Temperature and time explain the drift equally well, and the requested measurement separates
    # them.
    share = found.probability["thermal_head_drift"], found.probability["unknown"]
    assert share[0] == pytest.approx(share[1], abs=0.05)
    assert found.measurement is not None
    assert found.measurement.kind is not None
    assert "time × head2" in found.measurement.words
    assert "time" in " ".join(sentences(found))


@pytest.mark.large
def test_a_run_that_warms_and_cools_tells_them_apart() -> None:
    _, found = diagnosed(_warming(0, cools=True))
    assert "thermal_head_drift" not in found.effect_class


def _displayed(seed: int, step: float, reversal: float) -> MeasurementSet:
    """Return a reference run over 24 stations, five times up and down, with 0.15″ of noise and
    rounded to ``step``."""
    random = np.random.default_rng(seed)
    up = np.arange(24) * 15.0
    target = np.tile(np.concatenate([up, up[::-1]]), 5)
    side = np.tile(np.repeat([1, -1], 24), 5)
    angle = np.radians(target)
    error = 40.0 * np.cos(angle + 0.4) + 2.0 * np.cos(2.0 * angle) + 0.5 * reversal * side
    error = np.round((error + random.normal(0.0, 0.15, angle.size)) / step) * step
    reference = Reference(
        target,
        error,
        run=np.zeros(angle.size, dtype=np.int64),
        time_s=np.arange(angle.size) * 5.0,
        cycle=np.repeat(np.arange(5), 48),
        direction=side,
    )
    return MeasurementSet(Table(), None, reference, title="display")


@pytest.mark.parametrize(
    "step",
    [pytest.param(0.1, marks=pytest.mark.large), pytest.param(0.5, marks=pytest.mark.large), 1.0],
)
def test_readings_that_a_display_rounds_are_no_faulty_rows(step: float) -> None:
    for seed in range(3):
        observations, found = diagnosed(_displayed(seed, step, 0.0))
        assert observations.masked == ()
        assert found.verdict not in ("bad_data", "named", "ambiguous")
    _, found = diagnosed(_displayed(0, step, 1.0))
    assert found.named is not None
    assert found.named.name == "hysteresis"
    size = found.named.parameters()["reversal_error"]
    # The tolerance is 0.06″ for 0.15″ of noise in 240 rows, plus a tenth of the step for the
    # rounding, which the 24 stations partly average.
    assert abs(size.value) == pytest.approx(1.0, abs=0.06 + 0.1 * step)


def test_the_step_of_a_display_is_found_and_noise_has_none() -> None:
    values = np.random.default_rng(2).normal(0.0, 3.0, 300)
    assert display_step(values) == 0.0
    assert display_step(np.round(values * 2.0) / 2.0) == pytest.approx(0.5)
    # The six decimals of a file are no step of a display.
    assert display_step(np.round(values, 6)) == 0.0


def _drifts(zero_s: float) -> MeasurementSet:
    """Return a set whose order 2 grows by 0.3″ within a minute; its times begin at ``zero_s``."""
    random = np.random.default_rng(7)
    size, turns = 6000, 5
    angle = 0.3 + np.arange(size) * 2.0 * np.pi * turns / size
    share = np.arange(size) / size
    readings = []
    for offset in (0.0, ALPHA):
        disc = angle + offset
        error = paper_error(disc, 20.0 + 0.0 * share, 1.0) + 0.3 * share * np.cos(2.0 * disc)
        value = disc + (error + random.normal(0.0, 0.1, size)) * ARCSEC
        readings.append(np.round(value / (2.0 * np.pi) * COUNTS_PER_REV).astype(np.int64))
    capture = Capture(np.zeros(size, dtype=np.int64), zero_s + 60.0 * share, *readings)
    table = Table(counts_per_rev=COUNTS_PER_REV, head_separation_deg=33.0)
    return MeasurementSet(table, capture, None, title="order 2 drifts")


def test_the_zero_of_the_clock_changes_no_product() -> None:
    """Times from 0 s, of a day and of 1970 give the same product with the same gain."""
    gains = []
    for zero_s in (0.0, 5e4, 1.76e9):
        term = Term(built_in()["graduation_harmonics"](), {})
        best = best_parts(Residuals(fit([term], observations_of(_drifts(zero_s)))))[0]
        assert best.effect.parts == ["time", "order:2", "disc"], zero_s
        gains.append(best.gain)
    np.testing.assert_allclose(gains, gains[0], rtol=1e-4)
    assert gains[0] > 50.0


def test_the_reference_shares_the_start_of_the_set() -> None:
    """A settling from the start of the set counts from the capture's first row also in a reference
    that begins ten minutes later, on a clock that is five seconds slow."""
    measured = measurement_set()
    capture, reference = measured.capture, measured.reference
    assert capture is not None
    assert reference is not None
    assert reference.time_s is not None
    later = capture.time_s[0] + 600.0 + np.arange(reference.time_s.size) * 10.0
    moved = replace(reference, time_s=later - 5.0, clock_offset_s=5.0)
    found = observations_of(replace(measured, reference=moved)).reference
    assert found is not None
    values = settling_condition(300.0, each_run=False).values(found)
    assert values is not None
    np.testing.assert_allclose(values, np.exp(-(later - capture.time_s[0]) / 300.0), rtol=1e-12)


def _on_a_display(faces_arcsec: float, seed: int) -> MeasurementSet:
    """Return ten visits of 24 faces with errors, 0.1″ of noise and a display step of 1″."""
    random = np.random.default_rng(seed)
    up = np.arange(24) * 15.0
    target = np.tile(up, 10)
    error = paper_error(np.radians(up), 20.0 + 0.0 * up, 0.0) + faces_arcsec * random.normal(
        size=24
    )
    shown = np.round(np.tile(error, 10) + random.normal(0.0, 0.1, target.size))
    rows = Reference(
        target_deg=target,
        error_arcsec=shown,
        run=np.zeros(target.size, dtype=np.int64),
        cycle=np.repeat(np.arange(10), 24),
        faces=24,
    )
    measured = measurement_set(turns=2)
    return replace(measured, reference=rows)


@pytest.mark.large
@pytest.mark.parametrize("seed", [1, 2])
def test_the_rounding_of_a_display_is_no_face_error(seed: int) -> None:
    """A step of 1″ leaves 0.29″ RMS at each face, which 0.1″ of noise does not average out."""
    _, found = diagnosed(_on_a_display(0.0, seed))
    assert found.verdict in ("adequate", "cannot_tell")
    _, found = diagnosed(_on_a_display(2.0, seed))
    assert found.named is not None
    assert found.named.name == "polygon_face_error"


@pytest.mark.parametrize("seed", range(2))
def test_a_model_with_a_coefficient_for_each_row_has_no_lack_of_fit(seed: int) -> None:
    # The set has one pass over 36 faces, with a stated uncertainty. The constant and the orders 1
    # to 18 fit all 36 rows, so that the residuals are rounding errors; their pattern must not
    # decide.
    random = np.random.default_rng(seed)
    target = np.arange(36) * 10.0
    error = 5.0 * np.cos(np.radians(target)) + random.normal(0.0, 0.2, 36)
    reference = Reference(
        target,
        error,
        run=np.zeros(36, dtype=np.int64),
        time_s=5.0 * np.arange(36),
        direction=np.ones(36, dtype=np.int64),
        faces=36,
        standard_uncertainty_arcsec=0.2,
    )
    _, found = diagnosed(MeasurementSet(Table(), None, reference, title="one pass"))
    assert found.channels["reference"].residual_rms_arcsec < 1e-9
    assert found.channels["reference"].lack_of_fit_p == 1.0
    assert found.verdict == "cannot_tell"
