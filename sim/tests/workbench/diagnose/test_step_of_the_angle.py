"""Tests that an error which steps at one angle and returns over the turn, such as that of the joint
of a tape, is stated as a step, and not as a single station that is off."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from arctrue.measurement import MeasurementSet, Reference, Table
from arctrue.workbench.diagnose.report import sentences
from arctrue.workbench.diagnose.report_json import diagnosis_data
from arctrue.workbench.effects.registry import built_in
from arctrue.workbench.inference.design_matrix import Term
from arctrue.workbench.inference.fit import fit
from arctrue.workbench.inference.repeated_error import RepeatedError, Spot
from arctrue.workbench.inference.visits_of_places import visits_of
from arctrue.workbench.observations.build import observations_of
from tests.workbench.base_diagnosis import diagnosis_of

Float = NDArray[np.float64]
JOINT_DEG, STEP_ARCSEC = 221.3, -14.0
NOISE_ARCSEC = 0.6


def _saw(angle_deg: Float) -> Float:
    """Return an error that steps by STEP_ARCSEC at the joint and returns evenly over the turn."""
    return -STEP_ARCSEC * (np.mod(angle_deg - JOINT_DEG, 360.0) / 360.0 - 0.5)


def _turns(
    of_angle: Float, angle_deg: Float, seed: int, *, turns: int, dt_s: float
) -> MeasurementSet:
    """Return turns in one direction, each a run, over the same angles."""
    random = np.random.default_rng([33, seed])
    at = np.radians(np.tile(angle_deg, turns))
    error = 9.0 * np.cos(at - 0.4) + 4.0 * np.cos(2.0 * at + 1.0) + 2.0 * np.sin(3.0 * at)
    error += np.tile(of_angle, turns) + random.normal(0.0, NOISE_ARCSEC, at.size)
    run = np.repeat(np.arange(turns), angle_deg.size)
    reference = Reference(
        target_deg=np.degrees(at),
        error_arcsec=error,
        run=run,
        time_s=np.arange(at.size) * dt_s + 20.0 * run,
        direction=np.ones(at.size, dtype=np.int64),
    )
    return MeasurementSet(Table(), None, reference)


def _repeated(made: MeasurementSet) -> RepeatedError | None:
    base = [Term(built_in()["graduation_harmonics"](), {})]
    visits = visits_of(fit(base, observations_of(made)))
    assert visits is not None
    return visits.repeated()


def _step(made: MeasurementSet) -> Spot | None:
    found = _repeated(made)
    return None if found is None else found.step


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_the_joint_of_a_tape_in_a_log(seed: int) -> None:
    """The log has 450 rows a turn, 0.8° apart; they do not determine where between two rows the
    step is."""
    angle = 0.8 * np.arange(450)
    step = _step(_turns(_saw(angle), angle, seed, turns=3, dt_s=0.04))
    assert step is not None
    assert step.angle_deg == pytest.approx(JOINT_DEG, abs=0.8)
    # Orders above 20 of a saw tooth of height 1 have the mean square Σ 1/(2π²k²) = 0.0025: 1350
    # rows of 0.6″ give u = 0.6/√(1350·0.0025) = 0.33″. The repeats give u with a scatter of 5 %.
    assert step.sigma_arcsec == pytest.approx(0.33, rel=0.3)
    # A step within a row lowers the fitted size by at most 5 %.
    assert step.size_arcsec == pytest.approx(STEP_ARCSEC, abs=3.0 * 0.33 + 0.7)


def test_the_diagnosis_states_the_step() -> None:
    angle = 5.0 * np.arange(72)
    found = diagnosis_of(_turns(_saw(angle), angle, 4, turns=4, dt_s=10.0))
    assert found.verdict == "unknown"
    text = " ".join(sentences(found))
    assert "the error steps at 222.5° by -1" in text
    assert "single station" not in text
    assert "graduation_defect" not in diagnosis_data(found, [])["look_alikes"]
    step = diagnosis_data(found, [])["findings"]["repeated_at_places"]["step"]
    # The step is between the stations at 220° and 225°.
    assert step["angle_deg"] == pytest.approx(222.5)
    # Seven orders below the stations' limit of 36 are left, so that u is about 1″.
    assert step["size_arcsec"] == pytest.approx(STEP_ARCSEC, abs=3.0 * step["sigma_arcsec"])


@pytest.mark.parametrize("width_deg", [0.5, 2.5, 4.0])
@pytest.mark.parametrize("seed", [1, 2])
def test_a_bump_is_no_step(width_deg: float, seed: int) -> None:
    """A bump of 14″ that is a few degrees wide has equal levels on its two sides."""
    angle = 0.8 * np.arange(450)
    aside = np.mod(angle - JOINT_DEG + 180.0, 360.0) - 180.0
    bump = 14.0 * np.exp(-0.5 * (aside / width_deg) ** 2)
    assert _step(_turns(bump, angle, seed, turns=3, dt_s=0.04)) is None


@pytest.mark.parametrize("seed", [1, 2])
def test_independent_errors_of_the_stations_are_no_step(seed: int) -> None:
    off = np.random.default_rng([34, seed]).normal(0.0, 3.0, 72)
    assert _step(_turns(off, 5.0 * np.arange(72), seed, turns=4, dt_s=10.0)) is None


@pytest.mark.parametrize("seed", [1, 2])
def test_an_error_that_begins_anew_with_each_turn_is_no_step(seed: int) -> None:
    """Each run turns from 0° to 355°, and the error grows evenly with the travel: no run shows
    that the error steps from 355° to 0°."""
    angle = 5.0 * np.arange(72)
    assert _step(_turns(0.04 * angle, angle, seed, turns=4, dt_s=10.0)) is None


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_a_level_over_a_part_of_the_turn_is_no_joint(seed: int) -> None:
    """A level has two edges; a step that returns evenly over the turn has one. Without a search for
    the second edge, five of 8 levels of 3″ in noise of 0.5″ were stated as a step."""
    angle = np.arange(360.0)
    level = np.where((angle >= 100.0) & (angle < 200.0), 3.5, 0.0)
    assert _step(_turns(level, angle, seed, turns=3, dt_s=10.0)) is None
