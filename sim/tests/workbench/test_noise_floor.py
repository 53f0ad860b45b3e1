"""Tests that all steps of a model's history show one noise for a set, which equals the simulated
noise."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from msgspec import structs

from arctrue.cli import main
from arctrue.measurement import Capture, MeasurementSet, write_measurement_set
from arctrue.report.analysis import Analysis, analyse, with_effect, without_effect
from arctrue.report.charts.chart import Level
from arctrue.report.charts.ladder import ladder
from arctrue.report.display import DisplaySettings
from arctrue.report.sections import channels_section, ladder_section
from arctrue.workbench.effects.registry import built_in
from arctrue.workbench.model.model import HistoryStep, default_model
from arctrue.workbench.model.model_file import read_model
from arctrue.workbench.model.noise_floor import floor_of, with_one_floor
from tests.workbench.small_sets import (
    ALPHA,
    ARCSEC,
    COUNTS_PER_REV,
    LINES,
    measurement_set,
    paper_error,
)

ROWS_A_TURN = 6_000.37
"""Rows per turn. Rows are 2.7 lines apart, so that the signal phase varies and never repeats
exactly."""
NOISE = 0.1
ROW_NOISE = NOISE * np.sqrt(2.0)
"""Standard deviation of the noise of R₂ − R₁ in arcseconds."""
HIDDEN = 0.63
KNOWN_TO = 0.1
"""Relative tolerance of the noise.

The scatter comes from about 6,000 differences that share rows; four standard deviations of it are 5
%. Phases that differ by up to 0.02 of a period leave 2π·0.02·0.63″/√3, another 5 % of the noise.
"""
SHAKE_HZ = 7.0


def hidden_capture(seed: int = 4) -> MeasurementSet:
    """Return a set of three turns; both heads have an interpolation error."""
    random = np.random.default_rng(seed)
    size = int(3 * ROWS_A_TURN)
    angle = 0.3 + np.arange(size) * 2.0 * np.pi / ROWS_A_TURN
    readings = []
    for offset, phase in ((0.0, 0.2), (ALPHA, 1.9)):
        value = angle + offset + paper_error(angle + offset, angle * 0.0, 0.0) * ARCSEC
        value = value + HIDDEN * np.cos(LINES * value + phase) * ARCSEC
        value = value + random.normal(0.0, NOISE * ARCSEC, size)
        readings.append(np.round(value / (2.0 * np.pi) * COUNTS_PER_REV).astype(np.int64))
    time = np.arange(size) * 12.0 / ROWS_A_TURN
    capture = Capture(np.zeros(size, dtype=np.int64), time, *readings)
    table = measurement_set(runs=1, cycles=1, turns=1).table
    return MeasurementSet(table=table, capture=capture)


@pytest.fixture(scope="module")
def hidden() -> MeasurementSet:
    return hidden_capture()


@pytest.fixture(scope="module")
def before(hidden: MeasurementSet) -> Analysis:
    return analyse(hidden, "hidden", default_model(), built_in())


@pytest.fixture(scope="module")
def after(before: Analysis) -> Analysis:
    return with_effect(before, "subdivision_error", {})


def test_an_error_within_the_signal_period_is_no_noise(before: Analysis) -> None:
    (first,) = before.model.history
    assert first.rms_arcsec["capture"] > 3.0 * ROW_NOISE
    assert first.noise_arcsec["capture"] == pytest.approx(ROW_NOISE, rel=KNOWN_TO)


def test_it_does_not_fall_with_what_is_added(before: Analysis, after: Analysis) -> None:
    own = [step.noise_arcsec["capture"] for step in after.model.history]
    assert own[1] == pytest.approx(own[0], rel=KNOWN_TO)
    assert floor_of(after.model.history)["capture"] == pytest.approx(
        floor_of(before.model.history)["capture"], rel=KNOWN_TO
    )


def test_it_does_not_lie_above_what_an_adequate_model_leaves(after: Analysis) -> None:
    last = after.model.history[-1]
    floor = floor_of(after.model.history)["capture"]
    assert last.rms_arcsec["capture"] == pytest.approx(ROW_NOISE, rel=0.05)
    assert ROW_NOISE * (1.0 - KNOWN_TO) < floor <= last.rms_arcsec["capture"]


def test_a_few_rows_leave_no_less_than_the_noise() -> None:
    """The stated noise must not exceed the residual of a fit, although with many coefficients this
    residual may be smaller than the noise of a row."""
    for seed in range(1, 5):
        made = measurement_set(paper_error, seed=seed, runs=1, cycles=2, turns=1)
        seen = analyse(made, "", default_model(), built_in())
        (step,) = seen.model.history
        for channel, rms in step.rms_arcsec.items():
            assert step.noise_arcsec[channel] <= rms


@pytest.mark.large
def test_chart_table_and_json_have_one_figure(
    after: Analysis, hidden: MeasurementSet, tmp_path: Path
) -> None:
    history = without_effect(after, "subdivision_error").model.history
    assert len(history) == 3
    (value,) = {step.noise_arcsec["capture"] for step in with_one_floor(history)}
    layers = {layer.name: layer for layer in ladder(history).panels[0].layers}  # type: ignore[union-attr]
    drawn = layers["noise"]
    assert isinstance(drawn, Level)
    assert drawn.value == value
    assert {row["noise"] for row in ladder_section(after, DisplaySettings())} == {
        f"{floor_of(after.model.history)['capture']:.4f}″"
    }
    assert channels_section(after, DisplaySettings())[0]["noise"] == (
        f"{floor_of(after.model.history)['capture']:.3f}″"
    )

    write_measurement_set(tmp_path / "set", hidden)
    model = tmp_path / "m.toml"
    words = ["add", "subdivision_error", str(tmp_path / "set"), "--model", str(model)]
    said = CliRunner().invoke(main, [*words, "--json", str(tmp_path / "a.json")])
    assert said.exit_code == 0, said.output
    words = ["history", "--model", str(model), "--json", str(tmp_path / "h.json")]
    said = CliRunner().invoke(main, words)
    assert said.exit_code == 0, said.output
    reported = json.loads((tmp_path / "h.json").read_text(encoding="utf-8"))["history"]
    floor = floor_of(read_model(model).history)
    assert [step["noise_arcsec"] for step in reported] == [floor, floor]
    assert json.loads((tmp_path / "a.json").read_text("utf-8"))["noise_arcsec"] == floor
    assert said.output.count(f"{floor['capture']:.4f}") >= 2


def test_what_does_not_repeat_is_noise_until_it_is_known() -> None:
    def shake(time: np.ndarray, speed: float) -> np.ndarray:
        return 0.5 * np.cos(2.0 * np.pi * SHAKE_HZ * time)

    made = measurement_set(paper_error, head2_only=shake, runs=1, cycles=1, reference=False)
    first = analyse(made, "", default_model(), built_in())
    # The repeats scatter as much as the whole residual.
    (step,) = first.model.history
    assert step.noise_arcsec["capture"] <= step.rms_arcsec["capture"]
    last = with_effect(first, "vibration", {})
    floors = {step.noise_arcsec["capture"] for step in with_one_floor(last.model.history)}
    assert len(floors) == 1
    assert floors.pop() <= last.model.history[-1].rms_arcsec["capture"]


def test_steps_on_another_set_have_its_own_noise() -> None:
    def step(noise: float, measurement: str, digest: str) -> HistoryStep:
        return HistoryStep(
            measurement=measurement,
            measurement_sha256=digest,
            rms_arcsec={"capture": 1.0},
            noise_arcsec={"capture": noise},
        )

    history = [step(0.5, "a", "1"), step(0.2, "b", "2"), step(0.3, "a", "1"), step(0.4, "a", "")]
    assert [item.noise_arcsec["capture"] for item in with_one_floor(history)] == [
        0.3, 0.2, 0.3, 0.3,
    ]  # fmt: skip
    # A changed set with an unchanged name counts as another set.
    changed = [*history[:3], structs.replace(history[3], measurement_sha256="3")]
    assert floor_of(changed) == {"capture": 0.4}
