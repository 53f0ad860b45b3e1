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
from arctrue.studies.head_angle import places as places_module
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
    ("heads", "listed"), [(2, (1, 5, 24)), (3, (1, 7, 24)), (4, (1, 2, 3, 12, 36))]
)
def test_places_for_a_list_of_orders(
    monkeypatch: pytest.MonkeyPatch, heads: int, listed: tuple[int, ...]
) -> None:
    """The best places for listed orders are better for these orders than the best places for all
    orders up to the highest one; a least-squares fit by numpy alone gives the stated gain."""
    monkeypatch.setattr(places_module, "STEP_DEG", 20.0)
    monkeypatch.setattr(places_module, "BEST", 5)
    best = best_places(heads, listed)[0]
    at = np.radians(best.places_deg)
    known = [0] if heads < 4 else [0, 1, -1]
    basis = np.stack([np.exp(1j * k * at) for k in known], axis=1)
    free = np.eye(heads) - basis @ np.linalg.pinv(basis)
    counted = [order for order in listed if heads < 4 or order > 1]
    gains = [1.0 / np.linalg.norm(free @ np.exp(1j * n * at)) for n in counted]
    assert best.worst_gain == pytest.approx(max(gains), rel=1e-6)
    assert best.worst_order == counted[int(np.argmax(gains))]
    every = best_places(heads, max(listed))[0]
    assert best.worst_gain < judged_places(every.places_deg, listed).worst_gain - 0.02


def test_the_command_takes_a_list_of_orders(tmp_path: Path) -> None:
    file = tmp_path / "found.json"
    answer = CliRunner().invoke(main, ["alpha", "--orders", "1-3,11,24", "--json", str(file)])
    assert answer.exit_code == 0, answer.output
    assert "1-3, 11, 24" in answer.output
    assert not {"∞", "no mean", "missing"} & set(answer.output.split()), "of three or four heads"
    (choice,) = json.loads(file.read_text(encoding="utf-8"))["places"]
    assert choice["orders"] == [1, 2, 3, 11, 24]
    assert choice["given"]["places_deg"] == [0.0, 33.0]
    # At 33° order 11 has the largest noise gain, 1/(√2·|sin(11 · 33°/2)|) of the noise of one head.
    assert choice["given"]["worst_gain"] == pytest.approx(
        1.0 / (np.sqrt(2.0) * abs(np.sin(np.radians(11 * 33.0 / 2.0)))), rel=1e-6
    )
    assert choice["best"][0]["worst_gain"] < 0.1 * choice["given"]["worst_gain"]


@pytest.mark.parametrize(
    "orders", ["1", "0-3", "2,,3", "a", "8-2", "2-3,9-1", "5-2000", "1-99999999999"]
)
def test_orders_that_cannot_be_are_refused(orders: str) -> None:
    answer = CliRunner().invoke(main, ["alpha", "--orders", orders])
    assert answer.exit_code == 2
    said = " ".join(answer.output.split())
    assert "expected N from 2 to 1000" in said
    assert "2-8,12,24 (first ≤ last)" in said


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
