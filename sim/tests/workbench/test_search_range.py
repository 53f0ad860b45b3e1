"""Tests that a search ends at the range that the effect declares, even if the maximum lies outside
this range."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from arctrue.workbench.effects.base import Effect, SearchParameter
from arctrue.workbench.effects.catalogue.bearing_ball_pass import BearingBallPass
from arctrue.workbench.inference.design_matrix import Term
from arctrue.workbench.inference.scan.grid import grid_scan
from arctrue.workbench.inference.scan.maximum import moved_to_maximum
from arctrue.workbench.inference.scan.places import scored
from arctrue.workbench.inference.search_parameters import _moved
from arctrue.workbench.observations import Observations

LOW, HIGH = 1.0, 5.0


class _Bell(Effect):
    name = "bell"
    search = (SearchParameter("place", "1", LOW, HIGH, "of the bell", steps=9),)

    def column_names(self, observations: Observations) -> list[str]:
        return ["height"]


class _Likelihood:
    """A stand-in for the residuals; the gain is highest where the effect's place equals ``top``."""

    def __init__(self, top: float) -> None:
        self.top = top

    def score(self, effect: Effect, nonlinear: dict[str, float]) -> Any:
        gain = 100.0 * np.exp(-0.1 * (nonlinear["place"] - self.top) ** 2)
        return SimpleNamespace(gain=float(gain), own_share=1.0)

    def scores(self, asked: list[tuple[Effect, dict[str, float]]]) -> list[Any]:
        return [self.score(effect, place) for effect, place in asked]


@pytest.mark.parametrize(
    ("top", "found"), [(3.21, 3.21), (HIGH + 0.3, HIGH), (LOW - 0.3, LOW), (90.0, HIGH)]
)
def test_a_maximum_outside_the_range_is_not_found(top: float, found: float) -> None:
    (best, *_) = grid_scan(_Bell(), _Likelihood(top))  # type: ignore[arg-type]
    assert best.nonlinear["place"] == pytest.approx(found, abs=1e-3)
    assert LOW <= best.nonlinear["place"] <= HIGH


def test_places_outside_the_range_are_not_scored() -> None:
    likelihood: Any = _Likelihood(HIGH + 1.0)
    places = [{"place": value} for value in (LOW - 0.1, 2.0, HIGH, HIGH + 0.5)]
    found = scored(_Bell(), likelihood, places, 1.0)
    assert [place.nonlinear["place"] for place in found] == [HIGH, 2.0]
    moved = moved_to_maximum(_Bell(), likelihood, found, "place", 0.4)
    assert moved[0].nonlinear["place"] == pytest.approx(HIGH, abs=1e-6)
    assert scored(_Bell(), likelihood, places[:1], 1.0) == []


def test_a_refinement_ends_where_the_settings_end_the_range() -> None:
    """The refinement ends at the limit that a setting gives: the setting lowers the highest order
    of a ball pass from 60 to 10."""
    term = Term(BearingBallPass(highest_order=10), {"order": 9.9})
    assert _moved(term, np.array([0.05])).nonlinear["order"] == pytest.approx(9.95)
    assert _moved(term, np.array([0.5])).nonlinear["order"] == 10.0
    assert _moved(term, np.array([-90.0])).nonlinear["order"] == 0.2
