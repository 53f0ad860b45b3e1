"""Tests that the export writes a reversal error, a latency, and products with direction or speed to
lanes of the gateware. A lane corrects one order; its amplitude follows one of these conditions."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from sim.tests.command_line import arctrue as _run

from arctrue.calibration.acceptance import of_limits
from arctrue.device.load import load_frames
from arctrue.gateware.amplitude_sweep import Modulators, modulated
from arctrue.gateware.capability import EVERYTHING
from arctrue.gateware.coefficient_bounds import MOST_SPEED_FEEDBACK, speed_feedback
from arctrue.gateware.coefficient_file import CoefficientFileError, read_coefficient_file
from arctrue.gateware.coefficients import Coefficients
from arctrue.gateware.extension import FOLLOWED_LANES_MOST
from arctrue.gateware.table_conditions import MODULATOR_ONE
from arctrue.measurement import MeasurementSet, write_measurement_set
from arctrue.workbench.effects.base import ConditionedLane, Lane
from arctrue.workbench.effects.catalogue.latency import Latency
from arctrue.workbench.effects.catalogue.periodic_error import PeriodicError
from arctrue.workbench.effects.product_of_parts import ProductOfParts
from arctrue.workbench.model.export import Export, export_model
from arctrue.workbench.model.followed_lanes import ConditionSettings
from arctrue.workbench.model.model import Model, ModelEffect
from arctrue.workbench.model.model_file import write_model
from arctrue.workbench.model.taken_away import outcome
from arctrue.workbench.observations.build import observations_of

from .reversal_sets import REVERSAL, reversal_set

COUNTS = 1 << 20
ARCSEC_PER_WORD = 1_296_000 / COUNTS / 2048
"""Arcseconds of the last bit of an amplitude."""


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
    """The reversal error becomes a lane of order 0 with half of the error times the direction. The
    file needs MODULATORS, and the reader reads it back."""
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
    """The export refuses a change of 50″ within 0.02°, a slope of 0.69; the limit is 0.5."""
    words = ("export", folder, "--model", model, "--out", tmp_path, "--modulators")
    answer = _run(*words, "--reversal-width", "0.02")
    assert answer.exit_code != 0
    assert "--reversal-width" in answer.stderr
    assert "the limit is 0.5" in " ".join(answer.stderr.split())


def test_latency_is_order_0_times_speed(made: MeasurementSet) -> None:
    """The latency τ becomes a lane of order 0 times speed with ε = −ωτ: 20 µs give −4.125″ at 1
    rad/s."""
    lanes = Latency().conditioned_lanes(np.array([20.0]), {}, observations_of(made))
    assert [one.condition for one in lanes] == ["speed"]
    assert lanes[0].lane.order == 0
    assert lanes[0].lane.cosine_arcsec == pytest.approx(-20e-6 * 180 * 3600 / np.pi)


@pytest.mark.parametrize(
    ("delay_us", "clock_hz", "is_written"),
    [(61.0, 1e8, True), (62.0, 1e8, False), (62.0, 5e7, True), (-62.0, 1e8, False)],
)
def test_a_latency_beyond_the_feedback_is_refused(
    made: MeasurementSet, delay_us: float, clock_hz: float, is_written: bool
) -> None:
    """The export refuses a latency of more than 3/8 of a window of 2¹⁴ clocks: the measurement of
    the speed in the corrected angle would become unstable."""
    model = Model([ModelEffect("latency", {}, coefficients=[delay_us])])

    def written() -> Coefficients:
        return export_model(
            model,
            observations_of(made),
            {"latency": Latency},
            lanes=4,
            temperature_c=None,
            conditions=ConditionSettings(clock_hz=clock_hz, nominal_deg_per_s=90.0),
        ).coefficients

    if is_written:
        expected = abs(delay_us) * 1e-6 * clock_hz / (1 << 14)
        assert speed_feedback(written(), clock_hz) == pytest.approx(expected, rel=1e-3)
    else:
        limit = f"the limit is {MOST_SPEED_FEEDBACK:g} .a delay of 61 µs"
        with pytest.raises(ValueError, match=limit):
            written()


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
    """Return the exported coefficients of a model with order 1 and with ``order`` × direction."""
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
    """If an order has a modulated lane, the file also has a lane of this order without a modulator.
    Otherwise the calibration would fit this order itself, and its result would be right only for
    the direction of the fitted turn."""
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
    """The file has no lane with amplitude 0 and without a modulator, because order 3 × direction
    and order 1 use both lanes."""
    held = exported(made, 3, 2)
    assert held.orders.tolist() == [1, 3]
    assert (held.amplitudes != 0).all()


BY_DIRECTION = {"order": 5.0, "frequency": 0.0, "in_time": 0.0, "in_capture": 0.0}
UP, DOWN = (3.0, 4.0), (1.0, -2.0)


@pytest.mark.parametrize("with_modulators", [True, False])
def test_a_line_of_each_direction_is_a_plain_lane_and_one_with_the_direction(
    made: MeasurementSet, with_modulators: bool
) -> None:
    """The mean of both directions is a plain lane, and half of their difference a lane with the
    modulator direction: in each direction, the correction is the line of that direction. Without
    modulators half of the difference remains, and the export names the option."""
    model = Model(
        [
            ModelEffect(
                "periodic_error", {"by_direction": True}, BY_DIRECTION, coefficients=[*UP, *DOWN]
            )
        ]
    )
    observations, effects = observations_of(made), {"periodic_error": PeriodicError}
    result = export_model(
        model,
        observations,
        effects,
        lanes=4,
        temperature_c=None,
        conditions=ConditionSettings() if with_modulators else None,
    )
    became = outcome(model, observations, effects, result.coefficients, temperature_c=None)
    if not with_modulators:
        assert any("--modulators" in text for text in result.left_out)
        assert became.effects[0].by == "lanes"
        half = np.hypot(UP[0] - DOWN[0], UP[1] - DOWN[1]) / 2.0
        assert became.left_arcsec == pytest.approx(half / np.sqrt(2.0), rel=0.05)
        return
    counts = np.arange(0, COUNTS, 997)
    angle = 5.0 * counts * 2.0 * np.pi / COUNTS
    for sign, (cosine, sine) in ((1, UP), (-1, DOWN)):
        held = modulated(result.coefficients, Modulators(sign * MODULATOR_ONE))
        exact = (cosine * np.cos(angle) + sine * np.sin(angle)) * COUNTS / 1_296_000
        # Amplitudes and phases of two lanes are rounded. From the angle to the reading, an order
        # changes by the share n·A/2 at most, where A is the line itself.
        bound = 2.0 * 2.0**-11 + 5.0 * 7.3**2 * np.pi / 648_000.0 * COUNTS / 1_296_000
        assert np.abs(held.error_counts(counts) - exact).max() < bound
    assert became.effects[0].by == "lanes by condition"
    assert became.left_arcsec < 5.0 * 5.0**2 * np.pi / 648_000.0 + 2.0 * ARCSEC_PER_WORD


@pytest.mark.parametrize(
    ("settings", "said"),
    [
        ({"orders": [2.5], "condition": "direction"}, "not an integer and a condition"),
        ({"orders": [2.5], "condition": "temperature"}, "not an integer and a condition"),
        ({"orders": [], "condition": "temperature"}, "an order of 1 or more"),
        ({"orders": [3.0], "condition": "|speed|"}, "speed squared"),
        ({"orders": [3.0], "fixed_to": "reference"}, "on disc, stator or head 1"),
    ],
)
def test_a_product_without_lanes_has_a_reason(
    made: MeasurementSet, settings: dict[str, object], said: str
) -> None:
    """The firmware can load no lane for these products: the export and its table give the
    reason."""
    settings = {"fixed_to": "disc", **settings}
    values = [0.3, -0.4] if settings["orders"] else [0.3]
    entry = ModelEffect("product_of_parts", settings, coefficients=values)
    observations, effects = observations_of(made), {"product_of_parts": ProductOfParts}
    result = export_model(
        Model([entry]),
        observations,
        effects,
        lanes=4,
        temperature_c=None,
        conditions=ConditionSettings(),
        with_real_orders=True,
    )
    (reason,) = [text for text in result.left_out if text.startswith("product_of_parts: ")]
    assert said in reason
    became = outcome(Model([entry]), observations, effects, result.coefficients, temperature_c=None)
    # The set has no temperature, so that some of these products have no columns in it.
    assert became.effects[0].by in ("nothing", "not in the output")
    assert became.effects[0].note in reason
    # The diagnosis says "The gateware cannot compensate it" for this kind.
    is_never = settings["orders"] != [3.0]
    assert (entry.effect(effects).compensation == "none") == is_never


def test_the_firmware_holds_eight_lanes_with_a_modulator(made: MeasurementSet) -> None:
    """Of ten orders × direction the eight largest get a lane, and the export names the others."""
    sizes = np.linspace(1.0, 0.1, 10)
    entry = ModelEffect(
        "product_of_parts",
        {"fixed_to": "disc", "orders": [float(n) for n in range(1, 11)], "condition": "direction"},
        coefficients=[value for size in sizes.tolist() for value in (size, 0.0)],
    )
    result = export_model(
        Model([entry]),
        observations_of(made),
        {"product_of_parts": ProductOfParts},
        lanes=32,
        temperature_c=None,
        conditions=ConditionSettings(),
    )
    extension = result.coefficients.extension
    assert extension is not None
    assert len(extension.modulators) == FOLLOWED_LANES_MOST
    kept = sorted(int(result.coefficients.orders[lane]) for lane, _ in extension.modulators)
    assert kept == list(range(1, 9))
    assert of_limits(result.coefficients) == []
    assert [text for text in result.left_out if "at most 8" in text] == [
        "order 9 × direction (0.200″): the firmware holds at most 8 lanes that follow a condition",
        "order 10 × direction (0.100″): the firmware holds at most 8 lanes that follow a condition",
    ]


def with_columns(made: MeasurementSet, names: tuple[str, ...]) -> MeasurementSet:
    """Return the set with a load from 20 to 60 in the reference run, in a separate column for each
    name."""
    assert made.reference is not None
    load = np.linspace(20.0, 60.0, made.reference.target_deg.size)
    return replace(made, reference=replace(made.reference, conditions=dict.fromkeys(names, load)))


def column_export(made: MeasurementSet, names: tuple[str, ...]) -> Export:
    """Export a model that has, for each name, order 3 × (column − 40) with 0.3″ and −0.4″ per
    unit."""
    entries = [
        ModelEffect(
            "product_of_parts",
            {"fixed_to": "disc", "orders": [3.0], "column": name, "column_zero": 40.0},
            coefficients=[0.3, -0.4],
        )
        for name in names
    ]
    return export_model(
        Model(entries),
        observations_of(with_columns(made, names)),
        {"product_of_parts": ProductOfParts},
        lanes=4,
        temperature_c=None,
        conditions=ConditionSettings(),
    )


def test_a_product_with_a_column_follows_a_word_of_the_host(made: MeasurementSet) -> None:
    """A product with a column follows a word of the host. The load differs by at most 20 from its
    zero at 40. The word has the value 1 at a load of 40 + 30, where the amplitude is 0.5″ · 30."""
    result = column_export(made, ("load_n",))
    held = result.coefficients
    assert held.extension is not None
    ((lane, name),) = held.extension.modulators
    assert (name, held.orders[lane]) == ("word_a", 3)
    counts = 15.0 * COUNTS / 1_296_000
    assert held.amplitudes_counts[lane] == pytest.approx(counts, abs=2.0**-11)
    assert result.followed == [
        "order 3 × load_n: 15″ at load_n = 70, where word a is 1; it is 0 at 40"
    ]
    # At a load of 55 the host writes 0.5, with which the gateware removes the error of the model.
    at_55 = modulated(held, Modulators(word_a=MODULATOR_ONE // 2))
    counts_seen = np.arange(0, COUNTS, 997)
    angle = 3.0 * counts_seen * 2.0 * np.pi / COUNTS
    expected = (0.3 * np.cos(angle) - 0.4 * np.sin(angle)) * 15.0 * COUNTS / 1_296_000
    # The tolerance is one step of the amplitude, plus one step of the phase, 2π/2^24, at an
    # amplitude of 6 counts.
    assert np.abs(at_55.error_counts(counts_seen) - expected).max() < 2.0**-10


def test_two_columns_have_a_word_and_a_third_has_none(made: MeasurementSet) -> None:
    held = column_export(made, ("load_n", "torque_nm", "current_a")).coefficients
    assert held.extension is not None
    assert [name for _, name in held.extension.modulators] == ["word_a", "word_b"]


def test_what_words_take_away_is_counted(made: MeasurementSet) -> None:
    result = column_export(made, ("load_n",))
    model = Model(
        [
            ModelEffect(
                "product_of_parts",
                {"fixed_to": "disc", "orders": [3.0], "column": "load_n", "column_zero": 40.0},
                coefficients=[0.3, -0.4],
            )
        ]
    )
    became = outcome(
        model,
        observations_of(with_columns(made, ("load_n",))),
        {"product_of_parts": ProductOfParts},
        result.coefficients,
        temperature_c=None,
    )
    assert became.effects[0].by == "lanes by condition"
    assert became.effects[0].part_arcsec > 1.0
    # The lane acts at the reading, up to 0.5″ · 20 away from the angle: on this distance
    # a wave of order 3 and 10″ changes by 3 · 10″ · 10″ in radians.
    assert became.left_arcsec < 3.0 * 10.0 * 10.0 * np.pi / 648_000.0


def test_the_file_states_the_scale_of_a_word(made: MeasurementSet, tmp_path: Path) -> None:
    write_measurement_set(tmp_path / "set", with_columns(made, ("load_n",)))
    (tmp_path / "load_wave.py").write_text(
        "from arctrue.workbench.effects.product_of_parts import ProductOfParts\n\n\n"
        "class LoadWave(ProductOfParts):\n"
        '    name = "load_wave"\n'
        "    needs_settings = False\n"
        "    defaults = {**ProductOfParts.defaults, 'orders': [3.0], 'column': 'load_n',\n"
        "                'column_zero': 40.0}\n",
        encoding="utf-8",
    )
    model = tmp_path / "model.toml"
    entry = ModelEffect("load_wave", columns=["cos 3", "sin 3"], coefficients=[0.3, -0.4])
    write_model(model, Model([entry]))
    words = ("export", tmp_path / "set", "--model", model, "--effects", tmp_path)
    answer = _run(*words, "--out", tmp_path, "--modulators")
    assert answer.exit_code == 0, answer.output
    text = (tmp_path / "coefficients.toml").read_text(encoding="utf-8")
    assert 'title = "reversal; order 3 × load_n: 15″ at load_n = 70, where word a is 1' in text
    read_coefficient_file(tmp_path / "coefficients.toml", EVERYTHING)
