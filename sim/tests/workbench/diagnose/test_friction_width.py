"""Tests that the diagnosis names a reversal error for any width of the transition after a reversal,
and that it finds this width."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from sim.tests.command_line import arctrue as _run

from arctrue.gateware.capability import EVERYTHING
from arctrue.gateware.coefficient_file import read_coefficient_file
from arctrue.gateware.stop_operator import StopOperator
from arctrue.measurement import write_measurement_set
from arctrue.workbench.diagnose.report import sentences
from arctrue.workbench.effects.base import FitContext
from arctrue.workbench.effects.catalogue.hysteresis import Hysteresis
from arctrue.workbench.effects.registry import built_in
from arctrue.workbench.inference.added import added
from arctrue.workbench.inference.design_matrix import Term
from arctrue.workbench.inference.fit import fit
from arctrue.workbench.inference.residuals import Residuals
from arctrue.workbench.model.model_file import read_model
from arctrue.workbench.observations import Observations
from arctrue.workbench.observations.build import observations_of
from arctrue.workbench.observations.since_reversal import since_reversal
from tests.workbench.base_diagnosis import diagnosis_of
from tests.workbench.friction_sets import HALF_ARCSEC, Form, friction_set

SIGMAS = 4.5
"""Largest deviation in standard uncertainties: 7·10⁻⁶ for one value, below 10⁻³ for all of them."""


def _of_the_model(observations: Observations) -> Residuals:
    return Residuals(fit([Term(built_in()["graduation_harmonics"](), {})], observations))


@pytest.mark.parametrize(
    ("seed", "stations", "cycles", "width_deg", "form", "beyond_deg", "start"),
    [
        (1, 24, 2, 0.0, "linear", 0.0, 1.0),
        pytest.param(2, 36, 2, 5.0, "linear", 0.0, -1.0, marks=pytest.mark.large),
        pytest.param(3, 24, 3, 20.0, "linear", 0.0, -1.0, marks=pytest.mark.large),
        pytest.param(4, 36, 2, 20.0, "exponential", 0.0, 1.0, marks=pytest.mark.large),
        pytest.param(5, 24, 2, 30.0, "linear", 0.0, 1.0, marks=pytest.mark.large),
        pytest.param(6, 72, 2, 20.0, "linear", 0.0, 1.0, marks=pytest.mark.large),
        pytest.param(7, 36, 3, 20.0, "linear", 5.0, 1.0, marks=pytest.mark.large),
        (8, 36, 2, 8.0, "linear", 30.0, 1.0),
    ],
)
def test_a_width_of_friction(
    seed: int,
    stations: int,
    cycles: int,
    width_deg: float,
    form: Form,
    beyond_deg: float,
    start: float,
) -> None:
    """After each reversal the error changes from −38″ to 38″ over a width of 0° to 30°; the noise
    is 0.5″."""
    made = friction_set(
        seed,
        stations=stations,
        cycles=cycles,
        width_deg=width_deg,
        form=form,
        beyond_deg=beyond_deg,
        start=start,
    )
    found = diagnosis_of(made)
    assert found.verdict == "named"
    assert found.effect_class[0] == "hysteresis"
    assert found.second is None
    assert found.named is not None
    assert found.covers is not None
    # The smallest reversal error B that the set would show moves each row by ±B/2, whatever the
    # form of the transition.
    smallest = found.covers.smallest["hysteresis"]
    assert smallest.size is not None
    assert smallest.size.value == pytest.approx(2.0 * smallest.rms_arcsec["reference"], rel=0.1)
    parameters = found.named.at_maximum.parameters()[-1]
    error = parameters["reversal_error"]
    assert error.value == pytest.approx(2.0 * HALF_ARCSEC, abs=SIGMAS * error.sigma)
    assert error.sigma < 0.2
    if beyond_deg > width_deg:
        assert "width" not in parameters
        return
    width = parameters["width"]
    if width_deg < 360.0 / stations:
        # The rows show only an upper limit, so that the width has a rectangular distribution
        # between 0 and the distance of the stations.
        assert width.value == pytest.approx(180.0 / stations)
        assert width.sigma == pytest.approx(360.0 / stations / np.sqrt(12.0))
        assert f"less than {360.0 / stations:.3g}° of travel" in " ".join(sentences(found))
        return
    # With 1 − 2·exp(−2·s/w), the error has decayed to 1/e after w/2.
    true = width_deg - beyond_deg if form == "linear" else 0.5 * width_deg
    assert width.value == pytest.approx(true, abs=SIGMAS * width.sigma)
    assert width.sigma < 0.5
    assert f"{width.value:.3g}° of travel (u " in " ".join(sentences(found))


def test_no_friction_is_no_hysteresis() -> None:
    made = friction_set(9, stations=36, cycles=2, width_deg=20.0, half_arcsec=0.0)
    assert "hysteresis" not in diagnosis_of(made).effect_class


def test_the_columns_are_the_stop_operator_of_the_gateware() -> None:
    """A width of 20° is W = 10° of the operator; place/W is the factor of B/2."""
    rows = observations_of(
        friction_set(1, stations=72, cycles=2, width_deg=20.0), mask_outliers=False
    ).reference
    assert rows is not None
    effect = Hysteresis(transition="linear")
    columns = effect.reference_columns(rows, {"width": 20.0}, FitContext())
    assert columns is not None
    turn = 1 << 14
    width = round(16.0 * turn / 36.0)
    operator = StopOperator(width)
    # From far below, so that the direction is known before the first row.
    position, factors = -turn, []
    for count in np.round(rows.target_rad / (2.0 * np.pi) * turn).astype(int).tolist():
        for place in range(position, count, 1 if count >= position else -1):
            operator.move(place)
        place_16, known = operator.move(count)
        assert known
        position = count
        factors.append(place_16 / width)
    # The amplitudes of the reversal error and of the transition are 1. A count is 0.002 of the
    # width W.
    assert columns @ np.array([2.0, 2.0, 0.0]) == pytest.approx(np.array(factors), abs=0.003)


def test_the_first_row_after_a_reversal_has_its_own_way() -> None:
    """With targets of one turn: up from 330° to 0°, down to 330°, and up again."""
    target = np.radians([330.0, 345.0, 0.0, 345.0, 330.0, 330.0, 345.0])
    reversals, travel, at_reversal = since_reversal(target, np.array([1, 1, 1, -1, -1, 1, 1]))
    assert reversals.tolist() == [0, 0, 0, 1, 1, 2, 2]
    assert np.degrees(travel) == pytest.approx([0.0, 15.0, 30.0, 15.0, 30.0, 0.0, 15.0], abs=1e-6)
    # The second places after the reversals have travelled 30° and 15°, so that only rows below 15°
    # are at a reversal.
    assert at_reversal.tolist() == [True, False, False, False, False, True, False]


def test_adding_finds_the_width_and_an_export_writes_it(tmp_path: Path) -> None:
    """``add`` takes the form that the diagnosis named, the model file keeps the width with its u,
    and the gateware gets half of it as W."""
    folder, model = tmp_path / "set", tmp_path / "model.toml"
    write_measurement_set(
        folder, friction_set(4, stations=36, cycles=2, width_deg=20.0, half_arcsec=HALF_ARCSEC)
    )
    answer = _run("add", "hysteresis", folder, "--model", model)
    assert answer.exit_code == 0, answer.output
    entry = read_model(model).effects[-1]
    assert entry.settings == {"transition": "linear"}
    width = entry.parameters["width"]
    assert width.value == pytest.approx(20.0, abs=SIGMAS * width.sigma)
    answer = _run("export", folder, "--model", model, "--out", tmp_path, "--modulators")
    assert answer.exit_code == 0, answer.output
    held = read_coefficient_file(tmp_path / "coefficients.toml", EVERYTHING)
    assert held.extension is not None
    assert held.extension.conditions is not None
    # Sixteenths of a count: half of the width.
    stated = held.extension.conditions.width / 16.0 / (1 << 20) * 360.0
    assert stated == pytest.approx(0.5 * width.value, rel=0.02)


def test_p_counts_every_form_and_width() -> None:
    """p is corrected for the choice among no transition, a short one, and 2 forms × 24 widths."""
    measured = friction_set(4, stations=36, cycles=2, width_deg=20.0, form="exponential")
    residuals = _of_the_model(observations_of(measured))
    form, trials = Hysteresis().narrowed(residuals)
    assert form.settings["transition"] != "none"
    rows = residuals.observations.reference
    assert rows is not None
    assert rows.travel_rad is not None
    widest = 0.125 * float(np.degrees(rows.travel_rad.max()))
    assert trials == 2.0 + 2.0 * np.count_nonzero(np.geomspace(0.05, 45.0, 24) <= widest)


def test_a_set_without_a_transition_gets_none() -> None:
    """If the table goes beyond the last station by more than the width, the rows show only the
    direction."""
    made = friction_set(8, stations=36, cycles=2, width_deg=8.0, beyond_deg=30.0)
    grown = added(Hysteresis(), _of_the_model(observations_of(made)))
    assert grown is not None
    assert grown.terms[-1].effect.settings == {"transition": "none"}
