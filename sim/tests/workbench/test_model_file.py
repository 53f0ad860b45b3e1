"""Tests that model files are read back as they were written, and that their faults are reported."""

from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from arctrue.workbench.effects.base import Parameter
from arctrue.workbench.effects.registry import built_in
from arctrue.workbench.model.model import HistoryStep, Model, ModelEffect, ModelTable
from arctrue.workbench.model.model_file import ModelFileError, read_model, write_model

NUMBERS = st.floats(allow_nan=False, allow_infinity=False, width=64)
NAMES = st.from_regex(r"[a-z][a-z_]{0,12}", fullmatch=True)
TEXTS = st.text(st.characters(categories=["L", "N", "P", "S", "Zs"]), max_size=8)
CHANNELS = st.dictionaries(st.sampled_from(["capture", "reference"]), NUMBERS)


@st.composite
def models(draw: st.DrawFn) -> Model:
    effects = []
    for name in draw(st.lists(NAMES, min_size=1, max_size=3)):
        columns = draw(st.lists(TEXTS, max_size=4))
        parameter = Parameter(draw(NUMBERS), draw(NUMBERS), "arcsec")
        effects.append(
            ModelEffect(
                name=name,
                settings=draw(st.dictionaries(NAMES, st.integers(-9, 9) | TEXTS)),
                search=draw(st.dictionaries(NAMES, NUMBERS)),
                columns=columns,
                coefficients=[draw(NUMBERS) for _ in columns],
                parameters={"size": parameter},
            )
        )
    step = HistoryStep("add", "x", "set", *(draw(CHANNELS) for _ in range(4)))
    step.date, step.program, step.measurement_sha256 = (draw(TEXTS) for _ in range(3))
    counts = draw(st.none() | st.integers(4, 2**40))
    table = draw(st.none() | st.builds(ModelTable, st.just(counts), st.none() | NUMBERS))
    return Model(effects, draw(st.lists(NAMES)), [step], draw(NUMBERS), table=table)


@settings(max_examples=60, deadline=None)
@given(model=models())
def test_what_is_written_comes_back(tmp_path_factory: pytest.TempPathFactory, model: Model) -> None:
    path = tmp_path_factory.mktemp("model") / "m.toml"
    write_model(path, model)
    assert read_model(path) == model


EFFECT = '[[effect]]\nname = "hysteresis"\n'
BAD = {
    "": "schema",
    "schema = 2": "expected 1, found 2",
    "schema = 1": r"effect: is missing: expected one \[\[effect\]\] or more",
    "schema = 1\neffect = 3": r"expected one \[\[effect\]\] or more, found 3",
    "schema = 1\n[[effect]]\n": r"effect\[1\].name: is missing",
    "schema = [": "is not TOML",
    f"schema = 1\n{EFFECT}coefficients = [1.0]": "expected as many as columns, 0, found 1",
    f'schema = 1\n{EFFECT}columns = ["a"]\ncoefficients = ["x"]': 'a finite number, found "x"',
    f'schema = 1\n{EFFECT}columns = ["a"]\ncoefficients = [nan]': "a finite number, found nan",
    f'schema = 1\n{EFFECT}[effect.parameters.size]\nvalue = 1.0\nunit = "parsec"': "found .parsec",
    f"schema = 1\n{EFFECT}[effect.parameters.size]\nvalue = 1.0": "unit: is missing: .* a unit",
    f"schema = 1\n{EFFECT}[effect.search]\norder = true": "a finite number, found true",
    f"schema = 1\neffect_folders = 3\n{EFFECT}": "expected a list of texts, found 3",
    f"schema = 1\nhistory = 3\n{EFFECT}": "history",
    f"schema = 1\ntable = 3\n{EFFECT}": r"table: expected a table \[table\], found 3",
    f"schema = 1\n[table]\ncounts_per_rev = 1.5\n{EFFECT}": "table.counts_per_rev: expected",
    f"schema = 1\n[table]\nhead_separation_deg = 'x'\n{EFFECT}": "table.head_separation_deg",
}


@pytest.mark.parametrize(("text", "said"), BAD.items())
def test_what_is_wrong_is_said_with_the_file(tmp_path: Path, text: str, said: str) -> None:
    path = tmp_path / "m.toml"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(ModelFileError, match=said) as caught:
        read_model(path)
    assert str(path) in str(caught.value)


@pytest.mark.parametrize(
    ("effect", "search", "said"),
    [
        ("vibration", {"frequncy": 3.5}, "parameter frequncy. Did you mean frequency?"),
        ("hysteresis", {"order": 3.5}, "unknown search parameter order. It has: none"),
        ("graduation_defect", {"place": 3.5}, "width is missing: give all of place, width, or"),
        ("vibration", {"frequency": -1.0}, "expected a number from 0.1 to 2000, found -1"),
    ],
)
def test_search_parameters_are_the_effects_own(
    effect: str, search: dict[str, float], said: str
) -> None:
    with pytest.raises(ValueError, match=f"^effect {effect}: ") as caught:
        ModelEffect(effect, search=search).term(built_in())
    assert said in str(caught.value)


def test_a_model_that_was_never_fitted_is_said_to_be_so() -> None:
    with pytest.raises(ValueError, match="vibration: the model has no search parameters; fit it"):
        ModelEffect("vibration").term(built_in())


def test_which_differences_of_tables_count() -> None:
    """A difference of the head separation within ±50″, the mounting tolerance, does not count. A
    value that a set does not state cannot contradict the model."""
    table = ModelTable(1 << 24, 33.0)
    assert table.differences(table) == []
    assert table.differences(ModelTable()) == []
    assert table.differences(ModelTable(1 << 24, 33.0 + 49 / 3600)) == []
    assert len(table.differences(ModelTable(1 << 24, 33.0 - 51 / 3600))) == 1
    assert len(table.differences(ModelTable(3_600_000, -33.0))) == 2


def test_a_set_without_heads_does_not_make_the_model_forget_them() -> None:
    table = ModelTable(1 << 24, 33.0)
    assert ModelTable(1 << 24, None).completed(table) == table
    assert ModelTable(None, 32.0).completed(table) == ModelTable(1 << 24, 32.0)
    assert table.completed(None) == table


@settings(max_examples=200, deadline=None)
@given(data=st.binary(max_size=200))
def test_any_bytes_give_a_model_or_a_sentence(
    tmp_path_factory: pytest.TempPathFactory, data: bytes
) -> None:
    path = tmp_path_factory.mktemp("model") / "m.toml"
    path.write_bytes(data)
    with pytest.raises(ModelFileError):
        read_model(path)


def test_a_model_that_could_not_be_read_again_is_not_written(tmp_path: Path) -> None:
    path = tmp_path / "m.toml"
    write_model(path, Model([ModelEffect("hysteresis")]))
    before = path.read_bytes()
    with pytest.raises(ModelFileError, match="printable"):
        write_model(
            path, Model([ModelEffect("hysteresis", columns=["\x1b[2J"], coefficients=[1.0])])
        )
    assert path.read_bytes() == before
