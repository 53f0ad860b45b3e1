"""Tests of causes that are injected at the detection bound: their size, and the rate at which the
diagnosis finds them."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner

from arctrue.cli import main
from arctrue.studies.benchmark.bound import bound_scores, factor_to_bound, run_bound
from arctrue.studies.benchmark.independent.causes.heads import Slip
from arctrue.studies.benchmark.independent.injection import INJECTIONS, rms_arcsec
from arctrue.studies.benchmark.intervals import Rate

ROWS = 300
LINEAR = 1e-3
"""Largest relative deviation of the RMS error from proportionality to the size of the cause.

A shift of the angle changes the form of the error by about 10⁻⁵. At an amplitude of 0.01″, the
subdivision error itself shifts the phase on which it depends, which changes the form by 10⁻³.
"""


@pytest.mark.parametrize("effect", [name for name in INJECTIONS if name != "count_slip"])
def test_a_cause_has_the_name_and_shows_its_size(effect: str) -> None:
    random = np.random.default_rng(4)
    scene = INJECTIONS[effect].scene(random, ROWS)
    assert not scene.causes
    cause = INJECTIONS[effect].cause(random, scene)
    assert cause.name == effect
    one, half = (rms_arcsec(scene, cause.scaled(factor)) for factor in (1e-2, 5e-3))
    for channel, value in one.items():
        if value > 1e-3 * max(one.values()):
            assert value == pytest.approx(2 * half[channel], rel=LINEAR)


def test_a_slip_stays_whole_and_is_never_none() -> None:
    assert Slip(-7, 1, 0, 3.0).scaled(0.2).size == -2.0
    assert Slip(7, 1, 0, 3.0).scaled(1e-3).size == 1.0


def test_rms_of_a_creep_is_about_its_mean() -> None:
    """A creep that ramps from 0 to h has an RMS of h/√12 about its mean."""
    random = np.random.default_rng(5)
    scene = INJECTIONS["reference_drift"].scene(random, ROWS)
    cause = INJECTIONS["reference_drift"].cause(random, scene)
    height = abs(cause.size) * float(np.ptp(scene.reference_at().time_s)) / 3600
    found = rms_arcsec(scene, cause)
    rows = scene.reference_at().rows
    assert found["reference"] == pytest.approx(height / np.sqrt(12), rel=2 / rows)
    assert found["capture"] == pytest.approx(0.0, abs=1e-9)


def test_the_bound_is_reached_in_every_channel_that_shows_the_cause() -> None:
    bound = {"capture": 0.2, "reference": 0.1}
    assert factor_to_bound(bound, {"capture": 0.1, "reference": 0.02}) == pytest.approx(5.0)
    assert factor_to_bound(bound, {"capture": 1e-6, "reference": 0.02}) == pytest.approx(5.0)
    assert factor_to_bound({"capture": 0.2}, {"capture": 0.1, "reference": 0.02}) == 2.0
    with pytest.raises(ValueError, match="the cause appears in"):
        factor_to_bound({"reference": 0.1}, {"capture": 0.1, "reference": 0.0})


def result(found: bool, bound: float | None = 0.1) -> dict[str, Any]:
    stated = None if bound is None else {"capture": bound}
    return {"bound_rms_arcsec": stated, "found": found, "by_name": False}


def test_sets_without_a_bound_do_not_count() -> None:
    results = [({"effect": "latency"}, result(at < 20)) for at in range(24)]
    results += [({"effect": "latency"}, result(False, None))] * 5
    results += [({"effect": "hysteresis"}, result(True))] * 24
    hysteresis, latency = bound_scores(results)
    assert (hysteresis.effect, hysteresis.found, hysteresis.kept) == (
        "hysteresis",
        Rate(24, 24),
        True,
    )
    # The confidence interval of the rate is 62.6 … 95.3 % for 20 of 24, which includes 95 %, and
    # 57.8 … 92.9 % for 19 of 24.
    assert (latency.found, latency.by_name, latency.kept) == (Rate(20, 24), Rate(0, 24), True)
    results[0] = ({"effect": "latency"}, result(False))
    assert not bound_scores(results)[1].kept


@pytest.mark.large
def test_command(tmp_path: Path) -> None:
    arguments = ["benchmark", "bound", str(tmp_path / "bound"), "--effect=polygon_eccentricity"]
    file = tmp_path / "bound.json"
    arguments += ["--times=1", "--samples=300", "--workers=1", f"--json={file}"]
    done = CliRunner().invoke(main, arguments)
    assert done.exit_code == 0, done.output
    assert "polygon_eccentricity: found" in done.output
    assert json.loads(file.read_text())["polygon_eccentricity"]["found"]["of"] <= 1
    # The second call does not repeat finished sets; it reads their results again.
    assert CliRunner().invoke(main, arguments).exit_code == 0


@pytest.mark.parametrize(
    ("verdict", "found"), [("unknown", True), ("adequate", False), ("bad_data", False)]
)
def test_rows_that_are_refused_are_no_cause_that_is_found(
    monkeypatch: pytest.MonkeyPatch, verdict: str, found: bool
) -> None:
    """Only an answer that reports an error in addition to the model finds the injected cause."""
    stated = {"rms_arcsec": {"capture": 0.1, "reference": 0.1}}
    answers = iter(
        [
            {"verdict": "adequate", "covers": {"smallest": {"latency": stated}}},
            {"verdict": verdict, "named": None, "class": []},
        ]
    )
    monkeypatch.setattr("arctrue.studies.benchmark.bound._said", lambda _: next(answers))
    result = run_bound({"effect": "latency", "seed": 3, "samples": ROWS})
    assert result["verdict"] == verdict
    assert result["found"] is found
