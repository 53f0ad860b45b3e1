"""Probabilities of a diagnosis against dense Gaussian integrals, and their agreement with rules."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from scipy.stats import multivariate_normal

from arctrue.workbench.diagnose.posterior import posterior
from arctrue.workbench.diagnose.probabilities import (
    PRIOR_CATALOGUE,
    PRIOR_NONE,
    Weighed,
    inadequacy,
    log_evidence,
    log_evidence_of_p,
    normalised,
    prior,
)


@pytest.mark.parametrize("columns", [1, 3])
def test_evidence_is_the_ratio_of_two_dense_gaussian_densities(columns: int) -> None:
    """y ~ N(0, C) against y ~ N(0, C + n·X(XᵀC⁻¹X)⁻¹Xᵀ), the coefficients integrated out."""
    random = np.random.default_rng(5)
    rows = 40
    distance = np.abs(np.subtract.outer(np.arange(rows), np.arange(rows)))
    covariance = 0.3 * np.exp(-distance / 7.0) + 0.5 * np.eye(rows)
    design = random.normal(size=(rows, columns))
    measured = random.multivariate_normal(np.zeros(rows), covariance) + 0.4 * design[:, 0]
    precision = np.linalg.inv(covariance)
    information = design.T @ precision @ design
    moment = design.T @ precision @ measured
    gain = float(moment @ np.linalg.solve(information, moment))
    with_it = covariance + rows * design @ np.linalg.solve(information, design.T)
    expected = multivariate_normal.logpdf(measured, cov=with_it) - multivariate_normal.logpdf(
        measured, cov=covariance
    )
    assert log_evidence(Weighed(gain, columns, 1.0, rows)) == pytest.approx(expected, abs=1e-6)
    # Places that were searched share the prior.
    searched = log_evidence(Weighed(gain, columns, 50.0, rows))
    assert searched == pytest.approx(expected - np.log(50.0), abs=1e-6)


def test_a_stated_half_of_the_sets_has_the_effect() -> None:
    """Drawn from the prior: among sets that say p, a share of p has it (20 of 2,000 each side)."""
    random = np.random.default_rng(8)
    rows, sets = 30, 4000
    there = random.random(sets) < 0.5
    # One column with XᵀC⁻¹X = n: the coefficient has the prior N(0, 1), its estimate σ² = 1/n.
    estimate = np.where(there, random.normal(size=sets), 0.0) + random.normal(size=sets) / rows**0.5
    evidence = [log_evidence(Weighed(rows * value**2, 1, 1.0, rows)) for value in estimate]
    stated = 1.0 / (1.0 + np.exp(-np.array(evidence)))
    for low, high in ((0.0, 0.25), (0.25, 0.6), (0.6, 0.95), (0.95, 1.0)):
        inside = (stated >= low) & (stated < high + 1e-9)
        share, expected = float(there[inside].mean()), float(stated[inside].mean())
        # Four standard deviations of a binomial share.
        assert abs(share - expected) < 4.0 * np.sqrt(0.25 / inside.sum())


def test_little_known_noise_makes_a_gain_worth_less() -> None:
    known = log_evidence(Weighed(20.0, 1, 1.0, 100))
    little = log_evidence(Weighed(20.0, 1, 1.0, 100, freedom=4.0))
    assert little < known - 2.0
    assert log_evidence(Weighed(20.0, 1, 1.0, 100, freedom=1e9)) == pytest.approx(known, abs=1e-4)


def test_p_values_become_bounds_of_odds() -> None:
    # Sellke, Bayarri and Berger (2001), table 1: p of 0.05 and 0.01 bound 1/B by 0.407 and 0.125.
    assert np.exp(-log_evidence_of_p(0.05)) == pytest.approx(0.407, abs=5e-4)
    assert np.exp(-log_evidence_of_p(0.01)) == pytest.approx(0.125, abs=5e-4)
    assert log_evidence_of_p(0.5) == 0.0


def _candidate(name: str, gain: float, p: float, rank: int = 1):  # type: ignore[no-untyped-def]
    return SimpleNamespace(
        name=name, gain=gain, rank=rank, trials=1.0, level_trials=None, p_corrected=p,
        freedom=float("inf"),
    )  # fmt: skip


def _posterior(verdict, candidates, **changed):  # type: ignore[no-untyped-def]
    given = {
        "effect_class": [],
        "look_alikes": [],
        "product": None,
        "excluded": frozenset(),
        "lack_of_fit_p": 1.0,
        "rows": 1000,
        "near_tie": 6.0,
        "advantage": 10.0,
    } | changed
    return posterior(verdict, candidates, 2, **given)


def test_two_hypotheses_give_bayes_theorem() -> None:
    gain = 6.0
    found = _posterior("adequate", [_candidate("latency", gain, 0.02)])
    share = PRIOR_CATALOGUE / 3.0
    odds = share * np.exp(0.5 * gain * 1000 / 1001) / np.sqrt(1001.0) / PRIOR_NONE
    assert found["latency"] / found["none"] == pytest.approx(odds, rel=1e-9)
    assert sum(found.values()) == pytest.approx(1.0, abs=1e-12)


@pytest.mark.parametrize("gain", [14.0, 40.0, 1e4])
def test_what_is_named_has_the_largest(gain: float) -> None:
    # The other takes more with more freedom, but what it leaves was enough to exclude it.
    others = [_candidate("vibration", gain + 30.0, 1e-3, rank=2), _candidate("count_slip", 1.0, 1)]
    product = _candidate("product_of_parts", gain + 20.0, 1e-3)
    found = _posterior(
        "named", [_candidate("latency", gain, 5e-3), *others], effect_class=["latency"],
        product=product,
    )  # fmt: skip
    assert max(found, key=found.__getitem__) == "latency"
    assert set(found) == {"latency", "vibration", "count_slip", "none", "unknown"}
    assert sum(found.values()) == pytest.approx(1.0, abs=1e-12)
    assert found["none"] < found["latency"] * 0.08


@pytest.mark.parametrize("verdict", ["named", "ambiguous", "unknown"])
def test_no_likelihood_makes_an_answer_surer_than_such_answers_have_been(verdict: str) -> None:
    others = [_candidate("vibration", 30.0, 1e-3, rank=2), _candidate("count_slip", 1.0, 1)]
    found = _posterior(
        verdict, [_candidate("latency", 1e6, 1e-9), *others],
        effect_class=[] if verdict == "unknown" else ["latency"],
        product=_candidate("product_of_parts", 2e6, 1e-12) if verdict == "unknown" else None,
    )  # fmt: skip
    first = "unknown" if verdict == "unknown" else "latency"
    assert max(found, key=found.__getitem__) == first
    assert found[first] == pytest.approx(1.0 - inadequacy(verdict), abs=1e-3)
    assert sum(found.values()) == pytest.approx(1.0, abs=1e-12)


def test_the_first_of_a_class_is_no_less_probable_than_the_others() -> None:
    """The faces of a polygon come first as one family; their evidence pays for 23 sizes."""
    faces, motion = (
        _candidate("polygon_face_error", 250.0, 1e-9, rank=23),
        _candidate("x", 230.0, 0),
    )
    found = _posterior("ambiguous", [faces, motion], effect_class=["polygon_face_error", "x"])
    assert max(found, key=found.__getitem__) == "polygon_face_error"


def test_a_look_alike_that_cannot_be_tested_is_as_probable() -> None:
    found = _posterior(
        "ambiguous", [_candidate("hysteresis", 80.0, 1e-9)],
        effect_class=["hysteresis", "latency"], look_alikes=["latency"],
    )  # fmt: skip
    half = 0.5 * (1.0 - inadequacy("ambiguous"))
    assert found["latency"] == found["hysteresis"] == pytest.approx(half, abs=1e-3)


def test_verdicts_without_a_name_agree_with_their_probabilities() -> None:
    fits = [_candidate("latency", 900.0, 1e-9)]
    nothing = _posterior("adequate", fits, excluded=frozenset({"latency"}))
    assert max(nothing, key=nothing.__getitem__) in ("none", "unknown")
    strange = _posterior("unknown", fits, product=_candidate("product_of_parts", 950.0, 1e-12))
    assert max(strange, key=strange.__getitem__) == "unknown"
    silent = _posterior("cannot_tell", fits)
    # Beforehand, as the set says nothing: two of three effects cannot be tested.
    assert silent["latency"] == pytest.approx(prior(3))
    assert silent["none"] == pytest.approx(PRIOR_NONE)


def test_weights_far_apart_have_a_sum_of_one() -> None:
    found = normalised({"none": -3.0, "unknown": 40_000.0, "latency": 40_001.0})
    assert sum(found.values()) == pytest.approx(1.0, abs=1e-12)
    assert found["latency"] == pytest.approx(1.0 / (1.0 + np.exp(-1.0)), abs=1e-9)
