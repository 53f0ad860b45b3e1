"""Tests that the registry finds a cause in the cause's own file, and refuses two recipes with the
same name or rank."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from arctrue.table import causes
from arctrue.table.registry import CAUSES, REGISTRY, declared, ranked

NEW_CAUSE = """
from dataclasses import dataclass

from arctrue.table.cause import Cause
from arctrue.table.declaration import Declaration, Recipe


@dataclass(frozen=True, slots=True)
class ConstantShift(Cause):
    shift_m: float

    def disc_shift_m(self, state):
        return self.shift_m


DECLARATION = Declaration(
    ConstantShift,
    recipes=(
        Recipe(
            name="constant_shift",
            unit="um",
            low=1.0,
            high=2.0,
            draw=lambda size, random, occasion: [ConstantShift(size * 1e-6)],
            rank=1000,
            coefficients=2,
            kind="stranger",
        ),
    ),
)
"""


def test_a_new_cause_takes_one_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "constant_shift_of_this_test.py").write_text(NEW_CAUSE)
    monkeypatch.setattr(causes, "__path__", [*causes.__path__, str(tmp_path)])
    found = declared()
    assert set(found) - set(CAUSES) == {"constant_shift_of_this_test"}
    recipes = ranked(found)
    assert list(recipes) == [*REGISTRY, "constant_shift"]
    assert recipes["constant_shift"].cause == "constant_shift_of_this_test"


@pytest.mark.parametrize("key", ["name", "rank"])
def test_two_recipes_of_one_name_or_rank_are_refused(key: str) -> None:
    wind_up = CAUSES["shaft_wind_up"]
    (recipe,) = wind_up.recipes
    other = replace(recipe, name="another") if key == "rank" else replace(recipe, rank=recipe.rank)
    with pytest.raises(
        ValueError, match=r"shaft_wind_up and zz_copy declare the same name or rank"
    ):
        ranked(CAUSES | {"zz_copy": replace(wind_up, recipes=(other,))})
