"""Tests of a line (a sine wave) of integer order whose amplitude and phase depend on the direction;
this module makes the logs."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest

from arctrue.measurement import MeasurementSet, Reference, Table
from arctrue.workbench.diagnose.candidates import looked_for, regular_candidates
from arctrue.workbench.diagnose.detections import RegularCause
from arctrue.workbench.diagnose.diagnosis import diagnose
from arctrue.workbench.diagnose.report import sentences
from arctrue.workbench.effects.base import Effect
from arctrue.workbench.effects.registry import built_in
from arctrue.workbench.inference.design_matrix import Term
from arctrue.workbench.inference.fit import fit
from arctrue.workbench.inference.forward.search import Line
from arctrue.workbench.inference.residuals import Residuals
from arctrue.workbench.model.growth import fitted
from arctrue.workbench.model.model import ModelEffect, default_model
from arctrue.workbench.observations.build import observations_of

EFFECTS = built_in()
STEP_DEG, NOISE_ARCSEC = 1.0, 0.4
TERMS = [Term(EFFECTS["graduation_harmonics"](orders=[1, 2, 3]), {})]


def _log(
    order: float, up: tuple[float, float], down: tuple[float, float], seed: int = 1
) -> MeasurementSet:
    """Return a log of turns up and down at three speeds; each direction has an amplitude (″) and a
    phase (°)."""
    random = np.random.default_rng(seed)
    columns: dict[str, list[np.ndarray]] = {
        key: [] for key in ("at", "error", "time", "run", "way")
    }
    start_s = 0.0
    for run, (speed, way) in enumerate((s, w) for s in (2.0, 4.0, 6.0) for w in (1, -1)):
        at = np.arange(0.0, 360.0, STEP_DEG)[::way]
        amplitude, phase = up if way > 0 else down
        error = amplitude * np.cos(order * np.radians(at) + np.radians(phase))
        columns["at"].append(at)
        columns["error"].append(error + random.normal(0.0, NOISE_ARCSEC, at.size))
        columns["time"].append(start_s + np.arange(at.size) * STEP_DEG / speed)
        columns["run"].append(np.full(at.size, run))
        columns["way"].append(np.full(at.size, way))
        start_s = columns["time"][-1][-1] + 20.0
    joined = {key: np.concatenate(values) for key, values in columns.items()}
    rows = Reference(
        target_deg=joined["at"],
        error_arcsec=joined["error"],
        time_s=joined["time"],
        run=joined["run"],
        direction=joined["way"],
    )
    return MeasurementSet(Table(), None, rows, title="stiction")


def _found(made: MeasurementSet) -> tuple[Effect, dict[str, float], Residuals]:
    residuals = Residuals(fit(TERMS, observations_of(made)))
    found = looked_for(EFFECTS["periodic_error"](), residuals)
    assert found is not None
    return found[0], dict(found[1]), residuals


def test_a_second_search_keeps_the_order_whole() -> None:
    """`explain` searches again with the setting that the first search chose."""
    residuals = Residuals(fit(TERMS, observations_of(_log(72.0, (6.0, 4.0), (6.0, 95.0)))))
    found = looked_for(EFFECTS["periodic_error"](by_direction=True), residuals)
    assert found is not None
    assert dict(found[1])["order"] == 72.0


@pytest.mark.parametrize(
    ("up", "down"),
    [((6.0, 4.0), (6.0, 95.0)), ((6.0, 10.0), (2.0, 10.0)), ((3.0, 0.0), (3.0, 40.0))],
)
def test_an_order_that_depends_on_direction_is_a_whole_one(
    up: tuple[float, float], down: tuple[float, float]
) -> None:
    effect, place, residuals = _found(_log(72.0, up, down))
    assert effect.settings == {"by_direction": True}
    assert place["order"] == 72.0
    score = residuals.score(effect, place)
    found = residuals.solution_with(effect, place, score).parameters()[-1]
    assert found["order"].sigma == 0.0
    for way, (amplitude, phase) in (("up", up), ("down", down)):
        # With 1080 rows per direction, σ·√(2/n) is the uncertainty of the amplitude; divided by the
        # amplitude it is the uncertainty of the phase. The tolerance is five σ.
        sigma = NOISE_ARCSEC * np.sqrt(2.0 / 1080.0)
        assert found[f"{way}_amplitude"].value == pytest.approx(amplitude, abs=5.0 * sigma)
        degrees = np.degrees(sigma / amplitude)
        assert found[f"{way}_phase"].value == pytest.approx(phase, abs=5.0 * degrees)
    words = effect.describe_values(found)
    assert words.startswith("A line in the reference run of order 72, up ")
    assert f"∠ {found['down_phase'].value:.0f}°" in words


@pytest.mark.parametrize("order", [72.0, 72.04, 72.3, 71.6])
def test_a_line_that_is_the_same_both_ways_stays_one_line(order: float) -> None:
    effect, place, residuals = _found(_log(order, (6.0, 30.0), (6.0, 30.0), seed=2))
    assert effect.settings == {"by_direction": False}
    # The order of one line over one turn has the uncertainty √6·σ/(π·a·√n·turns) (Rife and
    # Boorstyn). The tolerance is nine σ; it is also a hundredth of the resolution of a turn, to
    # which the search finds the order.
    assert place["order"] == pytest.approx(order, abs=0.01)
    assert residuals.score(effect, place).gain > 100.0


def test_a_line_of_the_forward_search_is_asked_for_its_directions_too() -> None:
    """The forward search fits one wave to both directions and finds its rate next to the integer
    order; the effect must then find the integer order with a wave for each direction."""
    residuals = Residuals(fit(TERMS, observations_of(_log(72.0, (6.0, 4.0), (6.0, 95.0)))))
    line = Line(72.03, 5.0, 0.0, 3.5, 0.9, 300.0, 200.0, 432.0, 180.0)
    place = {"order": line.rate, "frequency": 0.0, "in_time": 0.0, "in_capture": 0.0}
    cause = RegularCause(EFFECTS["periodic_error"](), place, (line,), False, None)
    (found,) = regular_candidates(residuals, [cause], tests=19)
    assert found.effect.settings == {"by_direction": True}
    assert found.nonlinear["order"] == 72.0
    assert found.regular is cause


def test_the_diagnosis_says_both_directions() -> None:
    found = diagnose(observations_of(_log(72.0, (6.0, 4.0), (6.0, 95.0))), TERMS, EFFECTS)
    assert found.named is not None
    assert found.named.name == "periodic_error"
    said = " ".join(sentences(found))
    assert re.search(
        r"of order 72, up (6\.\d+|5\.9\d*)″ ∠ [345]°, down (6\.\d+|5\.9\d*)″ ∠ 9[456]°", said
    )


def test_a_model_file_keeps_both_directions() -> None:
    observations = observations_of(_log(72.0, (6.0, 4.0), (6.0, 95.0)))
    model = default_model()
    model = replace(model, effects=[*model.effects, ModelEffect(name="periodic_error")])
    grown, solution = fitted(model, observations, EFFECTS)
    assert grown.effects[-1].settings == {"by_direction": True}
    again, same = fitted(grown, observations, EFFECTS)
    assert again.effects[-1].search == grown.effects[-1].search
    np.testing.assert_allclose(same.coefficients, solution.coefficients, rtol=1e-3, atol=1e-3)
