"""Tests that every output of a diagnosis states the same values *left* (RMS of the residual) and
*held out* (RMS of rows that were left out of the fit), and that adding the effect gives these
values."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from sim.tests.workbench.small_sets import measurement_set, paper_error

from arctrue.base.figures import figure
from arctrue.cli import main
from arctrue.measurement import MeasurementSet, read_measurement_set, write_measurement_set
from arctrue.report.analysis import analyse, with_effect
from arctrue.report.display import DisplaySettings
from arctrue.report.sections import ladder_section, missing_section
from arctrue.workbench.effects.registry import built_in
from arctrue.workbench.model.growth import fitted
from arctrue.workbench.model.model import default_model
from arctrue.workbench.observations.build import observations_of

SAME = 1e-9
"""Relative tolerance of two sums over the same rows in the same order."""


def _warm(disc, temperature, speed):  # type: ignore[no-untyped-def]
    return paper_error(disc, temperature, speed) + 0.5 * (temperature - 20.0) * np.cos(disc + 0.7)


def _order_30(disc, temperature, speed):  # type: ignore[no-untyped-def]
    return paper_error(disc, temperature, speed) + 0.4 * np.cos(30 * disc + 0.2)


def _square(disc, temperature, speed):  # type: ignore[no-untyped-def]
    return paper_error(disc, temperature, speed) + 0.5 * np.sign(np.cos(7 * disc + 0.2))


SETS = {
    "nothing": {},
    "warm": {"error": _warm},
    "order 30": {"error": _order_30},
    "square wave": {"error": _square},
    "reversal": {"reversal_arcsec": 1.0},
    "reversal, no capture runs back": {"reversal_arcsec": 0.6, "runs": 1},
    "skew": {"head2_only": lambda time, speed: 0.5 * speed + 0.0 * time},
    "slip": {"head2_only": lambda time, speed: 1.2 * (time > 4.0)},
    "line": {"head2_only": lambda time, speed: 0.5 * np.cos(2.0 * np.pi * 3.3 * time)},
    "subdivision": {"electrical": lambda phase: 0.3 * np.cos(phase + 0.3)},
    "drift of a head": {"head2_only": lambda time, speed: 1e-3 * time},
    "no reference": {"error": _warm, "reference": False},
}
"""Twelve sets with at most 9,600 rows of the capture each, keyed by name."""
LARGE = tuple(name for name in SETS if name not in ("nothing", "drift of a head"))
"""Sets that only ``make test-large`` runs."""


def _made(name: str) -> MeasurementSet:
    how = {"runs": 4, "turns": 2, "cycles": 3, "seed": 7} | SETS[name]
    return measurement_set(**how)  # type: ignore[arg-type]


def _run(*words: str) -> str:
    said = CliRunner().invoke(main, list(words))
    assert said.exit_code == 0, said.output
    return said.output


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=[pytest.mark.large] * (name in LARGE)) for name in SETS]
)
def test_every_place_shows_what_adding_leaves(name: str, tmp_path: Path) -> None:
    folder, model = tmp_path / "set", tmp_path / "m.toml"
    write_measurement_set(folder, _made(name))
    table = _run("diagnose", str(folder), "--json", str(tmp_path / "d.json"))
    data = json.loads((tmp_path / "d.json").read_text("utf-8"))
    _run("compare", str(folder), "--json", str(tmp_path / "c.json"))
    compared = json.loads((tmp_path / "c.json").read_text("utf-8"))["channels"]
    # The test reads the set as it was written, rounded to the digits of the file.
    seen = analyse(read_measurement_set(folder), "", default_model(), built_in())
    first = seen.model.history[-1]
    ranking = {"diagnosis": data, "sentences": []}

    # Before an effect is added, JSON, comparison and the chart of the history agree.
    for channel, value in first.rms_arcsec.items():
        assert data["residual_rms_arcsec"][channel] == pytest.approx(value, rel=SAME)
        assert compared[channel]["rms_arcsec"] == pytest.approx(value, rel=SAME)
        assert data["noise_arcsec"][channel] == pytest.approx(first.noise_arcsec[channel], rel=SAME)
        assert compared[channel]["noise_arcsec"] == pytest.approx(
            data["noise_arcsec"][channel], rel=SAME
        )
        assert f"{channel}: left {figure(value, 4)}″ RMS" in table.replace("\n", " ")

    reported = [item for item in data["candidates"] if item["rms_after_arcsec"]]
    spoken = {data["named"], data["resembles"], *data["class"]} - {None}
    assert spoken >= {item["effect"] for item in reported}
    for item in reported:
        assert set(item["heldout_before_arcsec"]) == set(first.rms_arcsec)
        after = with_effect(seen, item["effect"], {})
        step = after.model.history[-1]
        card = _card(ranking, item["effect"], seen)
        row = ladder_section(after, DisplaySettings())[-len(step.rms_arcsec) :]
        _run("add", item["effect"], str(folder), "--model", str(model), "--json", f"{model}.json")
        added = json.loads(Path(f"{model}.json").read_text("utf-8"))
        model.unlink()
        for place, (channel, value) in enumerate(step.rms_arcsec.items()):
            left, unseen = item["rms_after_arcsec"][channel], item["heldout_after_arcsec"][channel]
            assert left == pytest.approx(value, rel=SAME)
            assert unseen == pytest.approx(step.heldout_rms_arcsec[channel], rel=SAME)
            assert added["rms_after_arcsec"][channel] == pytest.approx(left, rel=SAME)
            assert added["heldout_after_arcsec"][channel] == pytest.approx(unseen, rel=SAME)
            assert added["heldout_before_arcsec"][channel] == pytest.approx(
                item["heldout_before_arcsec"][channel], rel=SAME
            )
            assert figure(left, 4) in table
            assert figure(unseen, 4) in table
            assert row[place]["rms"] == f"{left:.4f}″"
            assert row[place]["held_out"] == f"{unseen:.4f}″"
            held = next(one for one in card["held_out"] if one["channel"] == channel)
            assert held["after"] == f"{unseen:.4f}″"
            fit = next(one for one in card["left"] if one["channel"] == channel)
            assert fit["after"] == f"{left:.4f}″"


def _card(ranking, name, seen):  # type: ignore[no-untyped-def]
    section = missing_section(seen, ranking, DisplaySettings())
    return next(card for card in (*section["cards"], *section["others"]) if card["name"] == name)


def test_left_is_the_rms_of_measured_less_predicted() -> None:
    """The stated *left* is the residual of plain least squares; this test computes the columns of
    the paper's 20 orders."""
    made = measurement_set(runs=1, turns=2, cycles=2, reference=False)
    observations = observations_of(made)
    grown, _ = fitted(default_model(), observations, built_in())
    step = analyse(made, "", grown, built_in()).model.history[-1]
    rows = observations.capture
    assert rows is not None
    angle, order = rows.angle_rad[:, np.newaxis], np.arange(1, 21)
    ahead = angle + np.radians(33.0)
    columns = np.hstack(
        [
            np.cos(order * ahead) - np.cos(order * angle),
            np.sin(order * ahead) - np.sin(order * angle),
            np.ones((rows.run.size, 1)),
        ]
    )
    measured = rows.difference_arcsec
    left = measured - columns @ np.linalg.lstsq(columns, measured, rcond=None)[0]
    # With white noise all rows have equal weights. The test uses the readings as angles, which are
    # wrong by up to 90″; this changes the residual by less than the tolerance.
    assert step.rms_arcsec["capture"] == pytest.approx(float(np.sqrt(np.mean(left**2))), rel=1e-3)
