"""Tests of the angles at which three and four heads are placed, against stated figures and against
random places."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from arctrue.calibration.head_weights import mean_weights
from arctrue.cli import main
from arctrue.studies.head_angle.places import (
    NOISE_LIMIT,
    _noise_of_three,
    best_places,
    judged_places,
)

ROOT = Path(__file__).resolve().parents[4]
FOUND = json.loads((ROOT / "docs" / "data" / "alpha.json").read_text(encoding="utf-8"))
PLACES_DEG = (0.0, 64.3, 177.0, 257.9)


def test_stated_places_have_the_stated_figures() -> None:
    one = judged_places(PLACES_DEG, 64)
    assert round(one.worst_gain, 1) == 2.7
    assert round(max(one.noise_without), 2) == 0.82
    assert round(judged_places((0.0, 33.0, 162.5, 300.5), 64).worst_gain, 1) == 11.2


def test_the_noise_of_three_heads_is_that_of_their_weights() -> None:
    random = np.random.default_rng(2)
    places = np.radians(random.uniform(0.0, 360.0, (50, 3)))
    found = [np.linalg.norm(mean_weights(one, noise_limit=np.inf)) for one in places
             if np.all(np.abs(mean_weights_of(one)) < 1.9)]  # fmt: skip
    kept = [bool(np.all(np.abs(mean_weights_of(one)) < 1.9)) for one in places]
    np.testing.assert_allclose(_noise_of_three(places)[kept], found, rtol=1e-9)


def mean_weights_of(places: np.ndarray) -> np.ndarray:
    """Return the weights that numpy finds from the three equations."""
    return np.linalg.solve(np.array([np.ones(3), np.cos(places), np.sin(places)]), [1.0, 0.0, 0.0])


def test_no_drawn_places_beat_those_that_were_found() -> None:
    best = best_places(3, 20)
    assert best == sorted(best, key=lambda one: one.worst_gain)
    random = np.random.default_rng(7)
    drawn = [
        judged_places((0.0, *sorted(random.uniform(20.0, 340.0, 2).round(1))), 20)
        for _ in range(400)
    ]
    allowed = [one.worst_gain for one in drawn if one.mean_noise <= NOISE_LIMIT]
    assert len(allowed) > 50
    assert best[0].worst_gain < min(allowed)
    assert all(one.mean_noise <= NOISE_LIMIT + 1e-3 for one in best)


def test_places_on_the_page_outlive_any_one_head() -> None:
    for choice in FOUND["places"]:
        for one in choice["best"]:
            again = judged_places(tuple(one["places_deg"]), choice["most_order"])
            assert again.worst_gain == pytest.approx(one["worst_gain"])
            if choice["heads"] == 4:
                assert max(again.noise_without) <= NOISE_LIMIT + 1e-3
    four = next(c for c in FOUND["places"] if c["heads"] == 4 and c["most_order"] == 64)
    assert four["best"][0]["worst_gain"] <= judged_places(PLACES_DEG, 64).worst_gain


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--places", "0,33"], "--heads 3 or 4"),
        (["--heads", "3", "--places", "0,33"], "expected one for each of 3 heads"),
        (["--heads", "4", "--places", "10,33,90,200"], "expected 0 for head 1"),
    ],
)
def test_places_that_are_not_as_asked_for_are_refused(words: list[str], said: str) -> None:
    answer = CliRunner().invoke(main, ["alpha", *words])
    assert answer.exit_code != 0
    assert said in answer.output
