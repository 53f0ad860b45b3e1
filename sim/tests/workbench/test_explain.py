"""Tests of ``arctrue explain`` on measurement sets that this module simulates, with causes of known
size."""

from __future__ import annotations

import json
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from sim.tests.command_line import arctrue as _run
from sim.tests.workbench.noisy_logs import clock, ornstein_uhlenbeck, with_lines
from sim.tests.workbench.small_sets import measurement_set, paper_error

from arctrue.measurement import MeasurementSet, Reference, Table, write_measurement_set
from arctrue.workbench.effects.registry import built_in
from arctrue.workbench.model import explain as explain_module
from arctrue.workbench.model.model import default_model
from arctrue.workbench.model.model_file import read_model
from arctrue.workbench.observations.build import observations_of

EFFECTS = built_in()
SIDEREAL_DEG_S = 360.0 / 86_164.1
TEETH = 180.0
WORM_S = 86_164.1 / TEETH


def _log(folder: Path, lines: list[tuple[float, float]], seed: int) -> float:
    """Write the log of a guide star over half an hour; return the RMS of its noise in arcseconds.
    ``lines`` gives the amplitude in arcseconds and the period in seconds of each sine."""
    random = np.random.default_rng(seed)
    time_s = clock(random, 1600, 1.2, "jitter")
    noise = 0.8 * ornstein_uhlenbeck(random, time_s, 20.0) + 0.4 * random.normal(size=time_s.size)
    reference = Reference(
        target_deg=SIDEREAL_DEG_S * time_s,
        error_arcsec=with_lines(time_s, lines) + noise,
        time_s=time_s,
        run=np.zeros(time_s.size, dtype=np.int64),
    )
    table = Table(drive_gear_teeth=TEETH)
    write_measurement_set(folder, MeasurementSet(table, None, reference, title="star"))
    return float(np.std(noise))


def _explained(folder: Path, *more: object) -> dict[str, Any]:
    file = folder.parent / "explained.json"
    done = _run("explain", folder, "--json", file, *more)
    assert done.exit_code == 0, done.output
    found: dict[str, Any] = json.loads(file.read_text(encoding="utf-8"))
    return found


@pytest.mark.large
def test_two_regular_causes_are_added_and_listed_by_size(tmp_path: Path) -> None:
    folder, model = tmp_path / "log", tmp_path / "model.toml"
    noise = _log(folder, [(8.0, WORM_S), (3.0, 131.0)], 1)
    found = _explained(folder, "--model", model)
    assert [cause["effect"] for cause in found["causes"]] == ["drive_gear_error", "periodic_error"]
    worm, gear = (cause["taken_arcsec"]["reference"] for cause in found["causes"])
    # The RMS of a sine is its amplitude divided by √2; slow noise of 0.9″ changes the RMS by about
    # a tenth.
    assert worm == pytest.approx(8.0 / np.sqrt(2.0), rel=0.1)
    assert gear == pytest.approx(3.0 / np.sqrt(2.0), rel=0.1)
    period = found["causes"][1]["parameters"]["period_time"]
    assert abs(period["value"] - 131.0) < 4.0 * period["sigma"]
    # The columns of the fit absorb some of the slow noise.
    assert found["left_arcsec"]["reference"] == pytest.approx(noise, rel=0.1)
    stored = read_model(model)
    # Over this arc of 8° the default model has no order of the disc.
    assert stored.names() == ["drive_gear_error", "periodic_error"]
    assert [step.action for step in stored.history] == ["fit", "add", "add"]
    assert dict(stored.history[-1].rms_arcsec) == pytest.approx(found["left_arcsec"], rel=1e-6)


def test_noise_alone_gets_nothing(tmp_path: Path) -> None:
    folder = tmp_path / "log"
    _log(folder, [], 2)
    found = _explained(folder)
    assert (found["causes"], found["dropped"]) == ([], [])
    assert found["diagnosis"]["verdict"] != "named"


@pytest.mark.large
def test_a_table_that_warms_is_explained_and_what_is_left_is_adequate(tmp_path: Path) -> None:
    """The explanation of a warming table leaves an adequate model: the set has the paper's error,
    and order 1 changes by 0.4″/K while the temperature varies."""

    def warm(disc: Any, temperature: Any, speed: Any) -> Any:
        return paper_error(disc, temperature, speed) + 0.4 * (temperature - 20.0) * np.cos(
            disc + 0.7
        )

    folder = tmp_path / "warm"
    write_measurement_set(folder, measurement_set(warm))
    found = _explained(folder)
    (cause,) = found["causes"]
    assert cause["effect"] == "thermal_eccentricity"
    amplitude = cause["parameters"]["amplitude"]
    assert abs(amplitude["value"] - 0.4) < 4.0 * amplitude["sigma"]
    assert found["diagnosis"]["verdict"] in {"adequate", "cannot_tell"}


@pytest.mark.large
def test_what_cannot_be_separated_is_said_with_the_measurement_that_would(tmp_path: Path) -> None:
    """The explanation names the measurement that separates two causes: at one speed, an oscillation
    of 3.3 Hz may depend on the time or on the angle."""
    folder, model = tmp_path / "line", tmp_path / "model.toml"
    made = measurement_set(
        runs=1,
        reference=False,
        head2_only=lambda time, speed: 0.6 * np.cos(2.0 * np.pi * 39.75 / 12.0 * time),
    )
    write_measurement_set(folder, made)
    file = tmp_path / "explained.json"
    done = _run("explain", folder, "--json", file, "--model", model)
    assert done.exit_code == 0, done.output
    (unclear,) = json.loads(file.read_text(encoding="utf-8"))["not_separated"]
    assert {"vibration", "bearing_ball_pass"} <= set(unclear["effects"])
    assert "speed" in unclear["next_measurement"]
    said = f"This set cannot distinguish between {', '.join(unclear['effects'])}"
    assert said in " ".join(done.output.split())
    head = model.read_text(encoding="utf-8").splitlines()[0]
    assert head.startswith(f"# {said}")
    assert unclear["next_measurement"] in head
    assert read_model(model).names() == ["graduation_harmonics"]


def _verdict(name: str | None, similar: str, measurement: str) -> SimpleNamespace:
    """Return the parts of a diagnosis that ``explain`` reads: the named effect, and an effect that
    looks like it."""
    named = None if name is None else SimpleNamespace(name=name, effect=EFFECTS[name]())
    return SimpleNamespace(
        verdict="adequate" if name is None else "named",
        named=named,
        instead=None,
        decision=SimpleNamespace(look_alikes={similar: 1.0}, unconfirmed=None),
        effect_class=[] if name is None else [name],
        description=None,
        next_measurement=measurement,
        next_measurement_kind=None,
    )


def test_each_of_two_causes_of_one_name_keeps_its_alternatives(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Two causes with one name, here two lines, keep their own alternatives, which are listed in
    the order of the causes: the larger line is found first."""
    random = np.random.default_rng(6)
    target = np.arange(720.0)
    phase = np.radians(target)
    error = np.cos(phase) + 0.4 * np.cos(37.43 * phase) + 0.6 * np.cos(61.8 * phase)
    reference = Reference(target, error + random.normal(0.0, 0.2, target.size), time_s=target)
    observations = observations_of(MeasurementSet(Table(), None, reference))
    verdicts = iter(
        [
            _verdict("periodic_error", "vibration", "a faster run"),
            _verdict("periodic_error", "hysteresis", "a run in both directions"),
            _verdict(None, "", ""),
        ]
    )
    monkeypatch.setattr(explain_module, "_verdict", lambda *arguments: next(verdicts))
    found = explain_module.explain(default_model(), observations, EFFECTS, "two lines")
    orders = [cause.entry.search["order"] for cause in found.causes]
    assert orders == pytest.approx([61.8, 37.43], abs=0.02)
    assert [(item.effects, item.next_measurement) for item in found.similar] == [
        (("periodic_error", "vibration"), "a faster run"),
        (("periodic_error", "hysteresis"), "a run in both directions"),
    ]


def test_a_refused_effect_does_not_end_the_explanation(monkeypatch: pytest.MonkeyPatch) -> None:
    """If the rules refuse the best effect, ``explain`` adds the effect that they would name
    instead, here a line of order 61.8."""
    random = np.random.default_rng(7)
    target = np.arange(720.0)
    error = 0.6 * np.cos(61.8 * np.radians(target)) + random.normal(0.0, 0.2, target.size)
    observations = observations_of(
        MeasurementSet(Table(), None, Reference(target, error, time_s=target))
    )
    line = SimpleNamespace(name="periodic_error", effect=EFFECTS["periodic_error"]())
    refused = _verdict(None, "", "")
    refused.verdict, refused.instead = "unknown", line
    verdicts = iter([refused, _verdict(None, "", "")])
    monkeypatch.setattr(explain_module, "_verdict", lambda *arguments: next(verdicts))
    found = explain_module.explain(default_model(), observations, EFFECTS, "line")
    assert [cause.entry.name for cause in found.causes] == ["periodic_error"]
