"""Tests that every effect declares the properties that a user needs, and that a user's own effect
file works like a built-in effect."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from sim.tests.workbench.small_sets import measurement_set

from arctrue.workbench.effects.new_effect import write_new_effect
from arctrue.workbench.effects.registry import (
    ORDER,
    EffectFileError,
    EffectNotFoundError,
    built_in,
    catalogue,
    effect_class,
)
from arctrue.workbench.inference.design_matrix import Term
from arctrue.workbench.inference.fit import fit
from arctrue.workbench.inference.residuals import Residuals
from arctrue.workbench.observations.build import observations_of

EFFECTS = built_in()


def test_the_whole_catalogue_is_there() -> None:
    assert tuple(EFFECTS) == ORDER


@pytest.mark.parametrize("name", ORDER)
def test_declarations(name: str) -> None:
    effect = EFFECTS[name]
    for text in (effect.physics, effect.equation, effect.source, effect.capture_sees,
                 effect.reference_sees, effect.separated_by, effect.next_measurement,
                 effect.plausible):  # fmt: skip
        assert text.strip()
    assert effect.physics.count(". ") == 1, "physics in two sentences"
    assert effect.parameter_units
    for parameter in effect.search:
        assert parameter.low < parameter.high


@pytest.mark.parametrize("name", [name for name in ORDER if name != "graduation_harmonics"])
def test_columns_have_one_shape_in_both_channels(name: str) -> None:
    observations = observations_of(measurement_set())
    effect = EFFECTS[name]()
    if effect.missing(observations):
        pytest.skip("cannot be tested with this set")
    nonlinear = {item.name: 0.5 * (item.low + item.high) for item in effect.search}
    if "instant" in nonlinear:
        nonlinear = {"run": 0.0, "instant": 1.0}
    width = len(effect.column_names(observations))
    context = fit([Term(EFFECTS["graduation_harmonics"](), {})], observations).context
    capture, reference = observations.capture, observations.reference
    assert capture is not None
    assert reference is not None
    shown = 0
    for rows, columns in (
        (capture, effect.capture_columns(capture, nonlinear, context)),
        (reference, effect.reference_columns(reference, nonlinear, context)),
    ):
        if columns is not None:
            shown += 1
            assert columns.shape == (rows.run.size, width)
            assert np.all(np.isfinite(columns))
    assert shown


@pytest.mark.large
def test_a_new_effect_works_as_written(tmp_path: Path) -> None:
    write_new_effect("warm_ovality", tmp_path)
    done = subprocess.run(
        [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", str(tmp_path)],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    effect = catalogue([tmp_path])["warm_ovality"]()

    def error(disc, temperature, speed):  # type: ignore[no-untyped-def]
        return 60.0 * np.cos(disc) + 0.3 * (temperature - 20.0) * np.cos(2 * disc)

    observations = observations_of(measurement_set(error))
    base = fit([Term(EFFECTS["graduation_harmonics"](), {})], observations)
    score = Residuals(base).score(effect, {})
    assert np.hypot(*score.coefficients) == pytest.approx(0.3, abs=0.02)


def test_names_that_cannot_be_are_refused(tmp_path: Path) -> None:
    for name in ("hysteresis", "class", "Big", "two words", ""):
        with pytest.raises(ValueError, match="name"):
            write_new_effect(name, tmp_path)
    write_new_effect("mine", tmp_path)
    with pytest.raises(FileExistsError, match="not changed"):
        write_new_effect("mine", tmp_path)


def test_files_that_fail_are_named(tmp_path: Path) -> None:
    with pytest.raises(EffectFileError, match="no such folder"):
        catalogue([tmp_path / "nowhere"])
    (tmp_path / "broken.py").write_text("def (", encoding="utf-8")
    with pytest.raises(EffectFileError, match=r"broken\.py: line 1: SyntaxError"):
        catalogue([tmp_path])
    (tmp_path / "broken.py").write_text("x = 1", encoding="utf-8")
    with pytest.raises(EffectFileError, match="defines no effect"):
        catalogue([tmp_path])


def test_unknown_names_and_settings_say_what_there_is() -> None:
    with pytest.raises(EffectNotFoundError, match="hysteresis"):
        effect_class("hysterese", EFFECTS)
    with pytest.raises(ValueError, match="multiples"):
        EFFECTS["subdivision_error"](multiple=[1])
    with pytest.raises(ValueError, match="whole numbers"):
        EFFECTS["subdivision_error"](multiples=[0.5]).integers("multiples")
