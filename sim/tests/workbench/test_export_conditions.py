"""Reversal error, latency and products with direction or speed become lanes that follow these."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from sim.tests.command_line import arctrue as _run

from arctrue.device.load import load_frames
from arctrue.gateware.capability import EVERYTHING
from arctrue.gateware.coefficient_file import CoefficientFileError, read_coefficient_file
from arctrue.gateware.coefficients import Coefficients
from arctrue.measurement import MeasurementSet, write_measurement_set
from arctrue.workbench.effects.base import ConditionedLane, Lane
from arctrue.workbench.effects.catalogue.latency import Latency
from arctrue.workbench.effects.product_of_parts import ProductOfParts
from arctrue.workbench.model.export import ConditionSettings, export_model
from arctrue.workbench.model.model import Model, ModelEffect
from arctrue.workbench.observations.build import observations_of

from .reversal_sets import REVERSAL, reversal_set

COUNTS = 1 << 20


@pytest.fixture(scope="module")
def made() -> MeasurementSet:
    made = reversal_set(varies=0.0)
    return replace(made, table=replace(made.table, counts_per_rev=COUNTS))


@pytest.fixture(scope="module")
def folder(made: MeasurementSet, tmp_path_factory: pytest.TempPathFactory) -> Path:
    place = tmp_path_factory.mktemp("reversal") / "set"
    write_measurement_set(place, made)
    return place


@pytest.fixture(scope="module")
def model(folder: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    place = tmp_path_factory.mktemp("model") / "model.toml"
    answer = _run("add", "hysteresis", folder, "--model", place)
    assert answer.exit_code == 0, answer.output
    return place


def test_a_reversal_error_is_a_lane_of_order_0(folder: Path, model: Path, tmp_path: Path) -> None:
    """Half of it, times the direction; the file needs MODULATORS and reads back."""
    answer = _run("export", folder, "--model", model, "--out", tmp_path, "--modulators")
    assert answer.exit_code == 0, answer.output
    assert "order 0 × direction" in answer.output
    assert "lanes by condition" in answer.output
    path = tmp_path / "coefficients.toml"
    with pytest.raises(CoefficientFileError, match="MODULATORS = true"):
        read_coefficient_file(path)
    held = read_coefficient_file(path, EVERYTHING)
    assert held.extension is not None
    ((lane, name),) = held.extension.modulators
    assert (name, held.orders[lane]) == ("direction", 0)
    half_counts = 0.5 * REVERSAL * COUNTS / 1_296_000
    signed = held.amplitudes_counts[lane] * np.cos(held.phases_rad[lane])
    assert signed == pytest.approx(half_counts, rel=0.01)
    assert held.extension.conditions is not None
    assert held.extension.conditions.width == round(16 * COUNTS / 360)
    frames = load_frames(held)
    assert sum(frame.startswith("load followed 0 1 0 ") for frame in frames) == 1
    assert sum(frame.startswith("load conditions ") for frame in frames) == 1


def test_without_the_flag_it_is_left_and_said_so(folder: Path, model: Path, tmp_path: Path) -> None:
    answer = _run("export", folder, "--model", model, "--out", tmp_path)
    assert answer.exit_code == 0, answer.output
    assert "--modulators" in " ".join(answer.output.split())
    assert read_coefficient_file(tmp_path / "coefficients.toml").extension is None


def test_a_steep_reversal_is_refused(folder: Path, model: Path, tmp_path: Path) -> None:
    """50″ within 0.02° is a slope of 0.69: above a half."""
    words = ("export", folder, "--model", model, "--out", tmp_path, "--modulators")
    answer = _run(*words, "--reversal-width", "0.02")
    assert answer.exit_code != 0
    assert "--reversal-width" in answer.stderr
    assert "0.5 is the limit" in " ".join(answer.stderr.split())


def test_latency_is_order_0_times_speed(made: MeasurementSet) -> None:
    """ε = −ωτ: 20 µs are −4.125″ at 1 rad/s."""
    lanes = Latency().conditioned_lanes(np.array([20.0]), {}, observations_of(made))
    assert [one.condition for one in lanes] == ["speed"]
    assert lanes[0].lane.order == 0
    assert lanes[0].lane.cosine_arcsec == pytest.approx(-20e-6 * 180 * 3600 / np.pi)


@pytest.mark.parametrize(
    ("condition", "modulator"),
    [("direction", "direction"), ("speed", "speed"), ("speed^2", "speed_squared")],
)
def test_products_keep_their_wave(made: MeasurementSet, condition: str, modulator: str) -> None:
    effect = ProductOfParts(condition=condition, orders=[3.0], fixed_to="disc")
    lanes = effect.conditioned_lanes(np.array([0.3, -0.4]), {}, observations_of(made))
    assert lanes == [ConditionedLane(modulator, Lane(3, 0.3, -0.4))]  # type: ignore[arg-type]
    real = ProductOfParts(condition=condition, orders=[2.5], fixed_to="disc")
    assert real.conditioned_lanes(np.array([0.3, -0.4]), {}, observations_of(made)) == []


def test_products_with_the_size_of_the_speed_have_no_modulator(made: MeasurementSet) -> None:
    effect = ProductOfParts(condition="|speed|", orders=[3.0], fixed_to="disc")
    assert effect.conditioned_lanes(np.array([0.3, -0.4]), {}, observations_of(made)) == []


def exported(made: MeasurementSet, order: int, lanes: int) -> Coefficients:
    """The export of order 1, and of ``order`` × direction."""
    observations = observations_of(made)
    settings = {"fixed_to": "disc"}
    plain = ModelEffect(
        "product_of_parts", {**settings, "orders": [1.0]}, coefficients=[36.0, -15.0]
    )
    loose = ModelEffect(
        "product_of_parts",
        {**settings, "orders": [float(order)], "condition": "direction"},
        coefficients=[3.0, 4.0],
    )
    return export_model(
        Model([plain, loose]),
        observations,
        {"product_of_parts": ProductOfParts},
        lanes=lanes,
        temperature_c=None,
        conditions=ConditionSettings(),
    ).coefficients


@pytest.mark.parametrize("order", [1, 3])
def test_the_plain_lane_of_a_modulated_order_is_always_in_the_file(
    made: MeasurementSet, order: int
) -> None:
    """Otherwise the calibration would fit it, with the direction of its turn in the value."""
    held = exported(made, order, 4)
    assert held.extension is not None
    ((modulated, name),) = held.extension.modulators
    assert (name, held.orders[modulated]) == ("direction", order)
    plain = [lane for lane in range(4) if held.orders[lane] == order and lane != modulated]
    assert len(plain) == 1
    assert (held.amplitudes[plain[0]] == 0) == (order == 3)
    sent = [frame.split()[3] for frame in load_frames(held) if frame.startswith("load lane ")]
    assert sent.count(str(order)) == 1


def test_a_plain_lane_of_0_takes_no_room_from_what_is_there(made: MeasurementSet) -> None:
    """Two lanes: order 3 × direction and order 1; no lane is left for the calibration either."""
    held = exported(made, 3, 2)
    assert held.orders.tolist() == [1, 3]
    assert (held.amplitudes != 0).all()
