"""Tests that the export writes harmonics of non-integer orders to lanes of the gateware (one lane
per harmonic) whose phase continues from turn to turn."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from sim.tests.command_line import arctrue as _run

from arctrue.calibration.acceptance import of_limits
from arctrue.gateware.capability import EVERYTHING
from arctrue.gateware.coefficient_file import (
    CoefficientFileError,
    read_coefficient_file,
    write_coefficient_file,
)
from arctrue.gateware.compensation_pipeline import compensate
from arctrue.gateware.extension import REAL_LANES_MOST
from arctrue.gateware.phase_sources import with_phase_from_probe
from arctrue.measurement import MeasurementSet, write_measurement_set
from arctrue.workbench.effects.base import FitContext, RealLane
from arctrue.workbench.effects.catalogue.bearing_ball_pass import BearingBallPass
from arctrue.workbench.effects.catalogue.drive_gear_error import DriveGearError
from arctrue.workbench.effects.catalogue.periodic_error import PeriodicError
from arctrue.workbench.effects.product_of_parts import ProductOfParts
from arctrue.workbench.model.export import Export, export_model
from arctrue.workbench.model.model import Model, ModelEffect
from arctrue.workbench.model.model_file import write_model
from arctrue.workbench.model.taken_away import outcome
from arctrue.workbench.observations import Observations
from arctrue.workbench.observations.build import observations_of

from .reversal_sets import reversal_set

COUNTS = 1 << 20
ARCSEC_PER_COUNT = 1_296_000 / COUNTS
EFFECTS = {
    "periodic_error": PeriodicError,
    "drive_gear_error": DriveGearError,
    "product_of_parts": ProductOfParts,
}
LINE = {"order": 0.5, "frequency": 0.0, "in_time": 0.0, "in_capture": 0.0}


@pytest.fixture(scope="module")
def made() -> MeasurementSet:
    made = reversal_set(varies=0.0)
    return replace(made, table=replace(made.table, counts_per_rev=COUNTS, drive_gear_teeth=71.4))


@pytest.fixture(scope="module")
def observations(made: MeasurementSet) -> Observations:
    return observations_of(made)


def model() -> Model:
    """Return a model with a belt, an eccentric gear, and a sine that is fixed to the disc."""
    sides = {"multiples": [1], "below": [1], "above": [1]}
    wave = {"orders": [2.75], "fixed_to": "disc"}
    return Model(
        [
            ModelEffect("periodic_error", {}, LINE, ["cos", "sin"], [12.0, -5.0]),
            ModelEffect("drive_gear_error", sides, coefficients=[8.0, 6.0, 2.0, 0.5, -1.0, 3.0]),
            ModelEffect("product_of_parts", wave, coefficients=[4.0, 3.0]),
        ]
    )


def exported(observations: Observations, **options: bool) -> Export:
    return export_model(
        model(),
        observations,
        EFFECTS,
        lanes=8,
        temperature_c=None,
        **options,  # type: ignore[arg-type]
    )


def error_arcsec(angle_rad: np.ndarray) -> np.ndarray:
    """Return the error of the model in float64, over any number of turns."""
    total = np.zeros(angle_rad.size)
    for order, cosine, sine in (
        (0.5, 12.0, -5.0),
        (71.4, 8.0, 6.0),
        (70.4, 2.0, 0.5),
        (72.4, -1.0, 3.0),
        (2.75, 4.0, 3.0),
    ):
        total += cosine * np.cos(order * angle_rad) + sine * np.sin(order * angle_rad)
    return total


def test_every_line_has_a_lane_with_its_turn_step(observations: Observations) -> None:
    held = exported(observations, with_real_orders=True).coefficients
    assert held.extension is not None
    orders = sorted(float(held.real_orders[lane]) for lane, _ in held.extension.turn_steps)
    # A turn step is rounded by at most 2⁻⁴⁹.
    assert orders == pytest.approx([0.5, 2.75, 70.4, 71.4, 72.4], abs=2.0**-48)


@pytest.mark.parametrize("turn", [0, 1, -1, 1000, -1_000_000])
def test_the_gateware_takes_the_model_away_in_every_turn(
    observations: Observations, turn: int
) -> None:
    """The bit-true pipeline removes the model in each of these turns: the phase must not drift."""
    held = exported(observations, with_real_orders=True).coefficients
    angles = np.arange(0, COUNTS, 4099)
    turns = np.full(angles.size, turn)
    found = compensate(angles, angles, held, turns=turns).correction / 2048.0
    total_rad = 2.0 * np.pi * (turn + angles / COUNTS)
    exact = error_arcsec(total_rad) / ARCSEC_PER_COUNT
    # Phases (to 2⁻²⁴ turn), cosines and amplitudes are rounded; with amplitudes of 27 counts in
    # total, the error stays far below a tenth of a count.
    assert np.abs(found - exact).max() < 0.02
    seen = held.error_counts(angles + turn * COUNTS)
    assert np.abs(seen - exact).max() < 0.02


def test_the_bank_of_another_turn(observations: Observations) -> None:
    """The coefficients are right if the first turn of the set is turn 5 of the gateware."""
    held = exported(observations, with_real_orders=True).coefficients
    angles = np.arange(0, COUNTS, 40_009)
    first = compensate(angles, angles, held, turns=np.zeros(angles.size, dtype=np.int64))
    moved = held.from_turn(5)
    later = compensate(angles, angles, moved, turns=np.full(angles.size, 5))
    # If turn 0 is another turn, the gateware rounds the phase offset twice, by up to 2⁻²⁵ turn, at
    # amplitudes of 27 counts in total.
    assert np.abs(first.correction - later.correction).max() <= 1


def test_the_phase_at_an_index_of_the_drive(observations: Observations) -> None:
    """The phase is right if it refers to an index of the drive: a pinion with 21 teeth makes 3.4
    turns per turn of the table and has an index in each of its turns."""
    gear = export_model(
        Model(model().effects[1:2]),
        observations,
        EFFECTS,
        lanes=8,
        temperature_c=None,
        with_real_orders=True,
    ).coefficients
    edge_turns = 0.7
    held = with_phase_from_probe(gear, edge_turns, 3.4)
    assert held.extension is not None
    values = {70.4: (2.0, 0.5), 71.4: (8.0, 6.0), 72.4: (-1.0, 3.0)}
    sides = {}
    for lane, source in held.extension.phase_sources:
        order = round(float(held.real_orders[lane]), 6)
        sides[order] = source.side
        cosine, sine = values[order]
        for index in range(-5, 6):
            place = edge_turns + index / 3.4
            angle = 2.0 * np.pi * order * place
            exact = cosine * np.cos(angle) + sine * np.sin(angle)
            phase = 2.0 * np.pi * (source.probe_phase / 2**24 + source.side * place)
            # The phases of lane and probe are each rounded to 2⁻²⁴ turn.
            assert np.hypot(cosine, sine) * np.cos(phase) == pytest.approx(exact, abs=1e-5)
    assert sides == {70.4: -1, 71.4: 0, 72.4: 1}
    with pytest.raises(ValueError, match=r"order 0\.5: for no side from -8 to 8"):
        with_phase_from_probe(exported(observations, with_real_orders=True).coefficients, 0.7, 3.4)


def test_the_firmware_holds_eight_lanes_of_real_orders(observations: Observations) -> None:
    """A gear with three multiples and their sides has nine lines; the smallest line has no lane,
    the export states this, and the remaining error is this line."""
    listed = {"multiples": [1, 2, 3], "below": [1, 2, 3], "above": [1, 2, 3]}
    sizes = [0.8, 0.4, 0.2, 0.1, 0.09, 0.08, 0.07, 0.05, 0.06]
    values = [value for size in sizes for value in (size, 0.0)]
    gear = Model([ModelEffect("drive_gear_error", listed, coefficients=values)])
    result = export_model(
        gear, observations, EFFECTS, lanes=32, temperature_c=None, with_real_orders=True
    )
    held = result.coefficients
    assert held.extension is not None
    assert len(held.extension.turn_steps) == REAL_LANES_MOST
    assert of_limits(held) == []
    smallest = 2 * 71.4 + 1
    assert not np.isclose(held.real_orders[held.amplitudes != 0], smallest).any()
    assert any(
        text.startswith(f"order {smallest:g} (0.050″): the firmware holds at most 8")
        for text in result.left_out
    )
    became = outcome(gear, observations, EFFECTS, held, temperature_c=None)
    rows = observations.every_reference_row
    assert rows is not None
    line = 0.05 * np.cos(smallest * rows.angle_rad)
    # The lanes act at the reading R = θ + ε, and ε(R) − ε(θ) is at most |ε|·|ε'|.
    bound = 3.0 * 72.4 * sum(sizes) * np.pi / 648_000.0 * sum(sizes)
    assert became.left_arcsec == pytest.approx(float(line.std()), abs=bound)


def test_what_they_take_away_is_counted(observations: Observations) -> None:
    held = exported(observations, with_real_orders=True)
    became = outcome(model(), observations, EFFECTS, held.coefficients, temperature_c=None)
    assert {item.by for item in became.effects} == {"lanes of real orders"}
    # The lanes act at the reading R = θ + ε, and ε(R) − ε(θ) is at most |ε|·|ε'|.
    sizes = {0.5: 13.0, 71.4: 10.0, 70.4: np.hypot(2.0, 0.5), 72.4: np.hypot(1.0, 3.0), 2.75: 5.0}
    slope = sum(order * size for order, size in sizes.items()) * np.pi / 648_000.0
    assert became.left_arcsec < slope * sum(sizes.values())
    assert not any("REAL_ORDERS" in text for text in held.left_out)
    assert len(held.real) == 5


def test_without_the_option_they_are_left_and_said_so(observations: Observations) -> None:
    result = exported(observations)
    assert result.coefficients.extension is None
    assert any("--real-orders" in text for text in result.left_out)
    became = outcome(model(), observations, EFFECTS, result.coefficients, temperature_c=None)
    assert {item.by for item in became.effects} == {"nothing"}


def test_lines_in_time_and_of_the_capture_have_none(observations: Observations) -> None:
    values = np.array([1.0, 2.0])
    for other in ({"in_time": 1.0}, {"in_capture": 1.0}, {"order": 3.0}):
        assert PeriodicError().real_lanes(values, LINE | other, observations) == []
    elsewhere = ProductOfParts(orders=[2.75], fixed_to="reference")
    assert elsewhere.real_lanes(values, {}, observations) == []


def test_a_ball_pass_is_a_lane_where_y_is_known(observations: Observations) -> None:
    """A ball pass becomes a lane if its motion in y, which head 1 reads, is known; the last two
    coefficients are those of y."""
    values = np.array([0.3, 0.1, -2.0, 5.0])
    lanes = BearingBallPass().real_lanes(values, {"order": 7.31}, observations)
    assert lanes == [RealLane(7.31, -2.0, 5.0)]
    rows = observations.every_reference_row
    assert rows is not None
    columns = BearingBallPass().reference_columns(rows, {"order": 7.31}, FitContext())
    angle = 7.31 * rows.angle_rad
    expected = -2.0 * np.cos(angle) + 5.0 * np.sin(angle)
    assert columns @ values == pytest.approx(expected, abs=1e-9)


def test_few_counts_a_turn_are_refused(made: MeasurementSet) -> None:
    """The export refuses too few counts a turn, because at the highest speed the offset of the next
    turn would not be ready in time."""
    small = replace(made, table=replace(made.table, counts_per_rev=620))
    with pytest.raises(ValueError, match="needs 624 at least"):
        exported(observations_of(small), with_real_orders=True)


def test_the_file_reads_back_and_names_its_generic(
    observations: Observations, tmp_path: Path
) -> None:
    held = exported(observations, with_real_orders=True).coefficients
    path = tmp_path / "coefficients.toml"
    write_coefficient_file(path, held)
    assert read_coefficient_file(path, EVERYTHING) == held
    with pytest.raises(CoefficientFileError, match="REAL_ORDERS = true"):
        read_coefficient_file(path)


def test_the_command(made: MeasurementSet, tmp_path: Path) -> None:
    write_measurement_set(tmp_path / "set", made)
    write_model(tmp_path / "model.toml", Model(model().effects[:1]))
    answer = _run(
        *("export", tmp_path / "set", "--model", tmp_path / "model.toml", "--out", tmp_path),
        *("--real-orders", "--force"),
    )
    assert answer.exit_code == 0, answer.output
    assert "order 0.5: 13″" in " ".join(answer.output.split())
    assert read_coefficient_file(tmp_path / "coefficients.toml", EVERYTHING).turn_steps.any()


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (("--real-orders", "--phase-from", "heads"), '"heads"'),
        (("--real-orders", "--phase-from", "probe", "--probe", "90", "0.5"), "probe_phase = "),
        (("--real-orders", "--phase-from", "probe"), None),
        (("--phase-from", "heads"), None),
    ],
)
def test_the_command_states_where_the_phase_comes_from(
    made: MeasurementSet, tmp_path: Path, options: tuple[str, ...], said: str | None
) -> None:
    write_measurement_set(tmp_path / "set", made)
    write_model(tmp_path / "model.toml", Model(model().effects[:1]))
    answer = _run(
        *("export", tmp_path / "set", "--model", tmp_path / "model.toml", "--out", tmp_path),
        *("--force", *options),
    )
    assert (answer.exit_code == 0) == (said is not None), answer.output
    if said is not None:
        assert said in (tmp_path / "coefficients.toml").read_text("utf-8")
