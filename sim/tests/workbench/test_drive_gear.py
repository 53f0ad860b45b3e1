"""Tests of the sine errors (lines) of a gear, which a polygon measures only at its faces; the
expected orders are counted by hand."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from sim.tests.workbench.small_sets import CAPTURE_NOISE, REFERENCE_NOISE, measurement_set

from arctrue.measurement import MeasurementSet
from arctrue.workbench.diagnose.diagnosis import diagnose
from arctrue.workbench.effects.catalogue.drive_gear_error import USUAL
from arctrue.workbench.effects.registry import built_in
from arctrue.workbench.inference.design_matrix import Term
from arctrue.workbench.inference.fit import fit
from arctrue.workbench.inference.residuals import Residuals
from arctrue.workbench.model.growth import add_effect
from arctrue.workbench.model.model import Model, default_model
from arctrue.workbench.noise.fit import white_noise
from arctrue.workbench.observations.build import observations_of

EFFECTS = built_in()


def _with_lines(teeth: int, lines: dict[int, float]) -> MeasurementSet:
    measurement = measurement_set(runs=1)
    reference = measurement.reference
    assert reference is not None
    target = np.radians(reference.target_deg)
    for order, size in lines.items():
        reference.error_arcsec[:] += size * np.cos(order * target + 0.5)
    return replace(measurement, table=replace(measurement.table, drive_gear_teeth=teeth))


def _narrowed(measurement: MeasurementSet):  # type: ignore[no-untyped-def]
    observations = observations_of(measurement)
    term = Term(EFFECTS["graduation_harmonics"](), {})
    noise = white_noise(observations, (CAPTURE_NOISE * np.sqrt(2.0), REFERENCE_NOISE))
    base = fit([term], observations, noise=noise)
    return EFFECTS["drive_gear_error"]().narrowed(Residuals(base))


@pytest.mark.parametrize(
    ("lines", "expected"),
    [
        ({90: 1.0}, {"multiples": [1], "below": [], "above": []}),
        # On 24 faces 90 teeth look like order 6, and the side lines 89 and 91 like orders 7 and 5.
        ({90: 1.0, 89: 0.4, 91: 0.4}, {"multiples": [1], "below": [1], "above": [1]}),
    ],
)
def test_lines_with_the_tooth_count_are_taken_where_they_are_there(lines, expected) -> None:  # type: ignore[no-untyped-def]
    effect, _ = _narrowed(_with_lines(90, lines))
    assert effect.settings == expected


def test_a_gear_that_the_faces_divide_shows_itself_by_its_side_lines() -> None:
    """A gear with 72 = 3 × 24 teeth shows itself by its side lines, because the gear itself
    looks like a constant. The side lines 71 and 73 both look like order 1, as a lean of the
    polygon does."""
    effect, trials = _narrowed(_with_lines(72, {72: 1.0, 71: 0.3}))
    assert effect.settings["multiples"] == []
    assert sorted([effect.settings["below"], effect.settings["above"]]) == [[], [1]]
    assert trials > 1.0


@pytest.mark.large
def test_side_lines_that_only_the_noise_with_the_gear_shows_are_taken() -> None:
    """The side lines are 18 times as large as their uncertainty from the rows' noise. With the
    noise that is estimated without the gear in the model they are not significant, because this
    estimate contains the gear's error.

    Without the side lines, errors of the polygon's faces would fit better than the gear.
    """
    measurement = _with_lines(65, {65: 2.1, 64: 0.22, 66: 0.22})
    found = diagnose(observations_of(measurement), default_model().terms(EFFECTS), EFFECTS)
    assert found.candidates[0].name == "drive_gear_error"
    assert found.effect_class[0] == "drive_gear_error"
    assert found.candidates[0].effect.settings == {"multiples": [1], "below": [1], "above": [1]}


def test_lines_that_the_stations_cannot_tell_apart_are_not_both_taken() -> None:
    """Of two lines that the stations cannot separate, only one is kept: on 24 faces orders 90 and
    270 both look like order 6, with opposite signs of the sine."""
    effect, trials = _narrowed(_with_lines(90, {90: 2.2, 89: 0.3, 91: 0.3}))
    assert effect.settings == {"multiples": [1], "below": [1], "above": [1]}
    # Only the few forms in USUAL were tried; a wave with a pair of side lines, which an eccentric
    # gear causes, is one of them.
    assert trials == len(USUAL)


def test_nothing_there_leaves_the_effect_as_it_is() -> None:
    effect, trials = _narrowed(_with_lines(90, {}))
    assert effect.settings == {"multiples": [1], "below": [], "above": []}
    assert trials == 1.0


def _added(lines: dict[int, float], settings: dict[str, object]) -> tuple[Model, float]:
    """Return the model with the gear, and the RMS of the reference's residual in arcseconds."""
    observations = observations_of(_with_lines(65, lines))
    model, _ = add_effect(
        default_model(), "drive_gear_error", settings, observations, EFFECTS, "a set"
    )
    return model, model.history[-1].rms_arcsec["reference"]


@pytest.mark.parametrize(
    ("lines", "expected"),
    [
        ({}, {}),
        ({65: 2.1}, {}),
        ({65: 2.1, 64: 0.22, 66: 0.22}, {"below": [1], "above": [1]}),
        ({65: 1.0, 130: 0.5}, {"multiples": [1, 2]}),
        ({65: 0.8, 195: 0.6, 194: 0.3}, {"multiples": [1, 3], "below": [3]}),
    ],
)
def test_an_added_gear_has_the_lines_that_the_set_shows(
    lines: dict[int, float], expected: dict[str, object]
) -> None:
    """``add`` without settings adds the multiples and side lines that the set shows, so that only
    the noise remains; the RMS of 240 rows scatters by 4.6 % (1/√480), of which the bound allows
    two."""
    model, rms = _added(lines, {})
    assert model.effects[-1].settings == expected
    assert rms < 1.1 * REFERENCE_NOISE


def test_settings_that_the_user_gives_stay() -> None:
    model, rms = _added({65: 1.0, 130: 0.5}, {"multiples": [1]})
    assert model.effects[-1].settings == {"multiples": [1]}
    # A wave of 0.5″ remains.
    assert rms == pytest.approx(np.hypot(REFERENCE_NOISE, 0.5 / np.sqrt(2.0)), rel=0.1)
