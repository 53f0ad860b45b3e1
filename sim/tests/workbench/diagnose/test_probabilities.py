"""Tests of the probabilities of a diagnosis against dense Gaussian integrals, and of the agreement
between probabilities and verdict."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from scipy.stats import multivariate_normal

from arctrue.workbench.diagnose.decision import Decision
from arctrue.workbench.diagnose.posterior import (
    LEAST_OF_A_NAME,
    SAID,
    posterior,
    stated,
)
from arctrue.workbench.diagnose.probabilities import (
    NONE,
    PRIOR_CATALOGUE,
    PRIOR_NONE,
    UNKNOWN,
    Weighed,
    log_evidence,
    log_evidence_of_p,
    normalised,
    prior,
)
from arctrue.workbench.diagnose.rules.of_the_set import (
    too_improbable_for_a_name,
    unknown_is_likelier,
)


@pytest.mark.parametrize("columns", [1, 3])
def test_evidence_is_the_ratio_of_two_dense_gaussian_densities(columns: int) -> None:
    """The evidence is the ratio of two dense densities, y ~ N(0, C) and y ~ N(0, C +
    n·X(XᵀC⁻¹X)⁻¹Xᵀ), in which the coefficients are integrated out."""
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
    # The places that were searched share the prior probability.
    searched = log_evidence(Weighed(gain, columns, 50.0, rows))
    assert searched == pytest.approx(expected - np.log(50.0), abs=1e-6)


def test_a_stated_half_of_the_sets_has_the_effect() -> None:
    """The stated probabilities are right for sets that the test draws from the prior. Of the sets
    for which the probability p is stated, the share p has the effect."""
    random = np.random.default_rng(8)
    rows, sets = 30, 4000
    there = random.random(sets) < 0.5
    # For one column with XᵀC⁻¹X = n, the coefficient has the prior N(0, 1), and its estimate has σ²
    # = 1/n.
    estimate = np.where(there, random.normal(size=sets), 0.0) + random.normal(size=sets) / rows**0.5
    evidence = [log_evidence(Weighed(rows * value**2, 1, 1.0, rows)) for value in estimate]
    stated = 1.0 / (1.0 + np.exp(-np.array(evidence)))
    for low, high in ((0.0, 0.25), (0.25, 0.6), (0.6, 0.95), (0.95, 1.0)):
        inside = (stated >= low) & (stated < high + 1e-9)
        share, expected = float(there[inside].mean()), float(stated[inside].mean())
        # The tolerance is four standard deviations of a binomial share.
        assert abs(share - expected) < 4.0 * np.sqrt(0.25 / inside.sum())


def test_little_known_noise_makes_a_gain_worth_less() -> None:
    known = log_evidence(Weighed(20.0, 1, 1.0, 100))
    little = log_evidence(Weighed(20.0, 1, 1.0, 100, freedom=4.0))
    assert little < known - 2.0
    assert log_evidence(Weighed(20.0, 1, 1.0, 100, freedom=1e9)) == pytest.approx(known, abs=1e-4)


def test_p_values_become_bounds_of_odds() -> None:
    # Sellke, Bayarri and Berger (2001), table 1: for p of 0.05 and 0.01 the bounds of 1/B are 0.407
    # and 0.125.
    assert np.exp(-log_evidence_of_p(0.05)) == pytest.approx(0.407, abs=5e-4)
    assert np.exp(-log_evidence_of_p(0.01)) == pytest.approx(0.125, abs=5e-4)
    assert log_evidence_of_p(0.5) == 0.0


def _candidate(name: str, gain: float, p: float, rank: int = 1):  # type: ignore[no-untyped-def]
    return SimpleNamespace(
        name=name, gain=gain, rank=rank, charged_trials=1.0, p_corrected=p,
        freedom=float("inf"), rows=1000, delta_bic=gain, evidence=None,
    )  # fmt: skip


def _verdict(verdict, effect_class, offered):  # type: ignore[no-untyped-def]
    """Apply the rules of the probabilities to the survey's verdict, and return the new verdict."""
    item = SimpleNamespace(name="latency", delta_bic=50.0)
    case = SimpleNamespace(ranked=[item], excluded=frozenset())
    said = Decision(verdict, effect_class=effect_class)
    facts: Any = SimpleNamespace(said=said, offered=offered, case=case)
    found = unknown_is_likelier(facts) or too_improbable_for_a_name(facts)
    return verdict if found is None else found.verdict


def _posterior(verdict, candidates, **changed):  # type: ignore[no-untyped-def]
    given = {
        "effect_class": [],
        "look_alikes": [],
        "product": None,
        "excluded": frozenset(),
        "lack_of_fit_p": 1.0,
        "near_tie": 6.0,
        "advantage": 10.0,
    } | changed
    return posterior(verdict, candidates, 2, **given)


def test_a_refused_effect_is_not_ahead_because_its_noise_was_not_estimated() -> None:
    """A refused effect must not get the largest probability only because its noise was not
    estimated. Six runs determine a reversal error well; they exclude a drift, which has a smaller
    gain.

    The diagnosis has not estimated the noise with the drift in the model. If the evidence of the
    drift used 1,000 rows, its log odds would be 250; those of the reversal error are 140.
    """
    first, drift = _candidate("hysteresis", 647.0, 1e-90), _candidate("drift", 513.0, 1e-52)
    first.freedom, first.evidence = 2.0, SimpleNamespace()
    found = _posterior(
        "ambiguous",
        [first, drift],
        effect_class=["hysteresis"],
        excluded=frozenset({"drift"}),
        # The model without the first effect has a lack of fit, which the first effect removes.
        lack_of_fit_p=1e-71,
    )
    assert found["hysteresis"] > found["unknown"]
    assert _verdict("ambiguous", ["hysteresis"], found) == "ambiguous"


def test_two_hypotheses_give_bayes_theorem() -> None:
    gain = 6.0
    found = _posterior("adequate", [_candidate("latency", gain, 0.02)])
    share = PRIOR_CATALOGUE / 3.0
    odds = share * np.exp(0.5 * gain * 1000 / 1001) / np.sqrt(1001.0) / PRIOR_NONE
    assert found["latency"] / found["none"] == pytest.approx(odds, rel=1e-9)
    assert sum(found.values()) == pytest.approx(1.0, abs=1e-12)


@pytest.mark.parametrize(("tested", "untestable"), [(19, 0), (15, 4), (10, 9)])
def test_the_less_a_set_can_test_the_less_sure_is_adequate(tested: int, untestable: int) -> None:
    """Bayes' theorem: evidence 1 for an effect that the set cannot test, and for a stranger; each
    tested effect with a gain of 1 has the factor e^(½·1000/1001)/√1001."""
    found = posterior(
        "adequate", [_candidate(f"e{number}", 1.0, 0.9) for number in range(tested)], untestable,
        effect_class=[], look_alikes=[], product=None, excluded=frozenset(), lack_of_fit_p=1.0,
        near_tie=6.0, advantage=10.0,
    )  # fmt: skip
    share = PRIOR_CATALOGUE / (tested + untestable)
    of_tested = tested * share * np.exp(0.5 * 1000 / 1001) / np.sqrt(1001.0)
    everything = PRIOR_NONE + 0.01 + untestable * share + of_tested
    assert found["none"] == pytest.approx(PRIOR_NONE / everything, rel=1e-9)


@pytest.mark.parametrize("gain", [14.0, 40.0, 1e4])
def test_what_is_named_has_the_largest(gain: float) -> None:
    # ``vibration`` has a larger gain with more coefficients, but a rule has excluded it because of
    # the residual that it leaves.
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


@pytest.mark.parametrize("verdict", ["named", "ambiguous", "unknown", "adequate"])
def test_an_answer_is_stated_as_sure_as_such_answers_are(verdict: str) -> None:
    """The answer gets the confidence as its probability, if the confidence is then still the
    largest probability; the sum stays 1."""
    others = [_candidate("vibration", 30.0, 1e-3, rank=2), _candidate("count_slip", 1.0, 1)]
    found = _posterior(
        verdict, [_candidate("latency", 1e6 if verdict != "adequate" else 0.0, 1e-9), *others],
        effect_class=["latency"] if verdict in ("named", "ambiguous") else [],
        product=_candidate("product_of_parts", 2e6, 1e-12) if verdict == "unknown" else None,
    )  # fmt: skip
    first = {"unknown": "unknown", "adequate": "none"}.get(verdict, "latency")
    members = ["latency"] if first == "latency" else []
    for confidence in (0.999, 0.9, 0.7):
        said = stated(found, verdict, members, confidence)
        assert said[first] == pytest.approx(confidence, abs=1e-9)
        assert sum(said.values()) == pytest.approx(1.0, abs=1e-12)
        # The probabilities of the effects keep their ratios.
        if verdict == "adequate":
            assert said["latency"] / said["count_slip"] == pytest.approx(
                found["latency"] / found["count_slip"]
            )
    low = stated(found, verdict, members, 0.01)
    assert low[first] == max(low.values())
    assert stated(found, verdict, members, None) == found


def test_faulty_data_state_what_was_probable_beforehand() -> None:
    found = _posterior("bad_data", [_candidate("latency", 900.0, 1e-9)])
    assert stated(found, "bad_data", [], None) == found


def test_an_answer_that_cannot_tell_gives_none_what_was_counted() -> None:
    """The state ``none`` gets the counted share, but at least the largest probability; all others
    keep their ratios."""
    found = _posterior("cannot_tell", [_candidate("latency", 900.0, 1e-9)])
    said = stated(found, "cannot_tell", [], 0.9)
    assert said["none"] == pytest.approx(0.9)
    assert sum(said.values()) == pytest.approx(1.0, abs=1e-12)
    assert said["latency"] / said["unknown"] == pytest.approx(found["latency"] / found["unknown"])
    low = stated(found, "cannot_tell", [], 0.01)
    assert low["none"] == max(low.values())
    assert sum(low.values()) == pytest.approx(1.0, abs=1e-12)


def test_the_first_of_a_class_is_no_less_probable_than_the_others() -> None:
    """The faces of a polygon, one family of errors, stay the first of their class, although their
    evidence has a penalty for 23 sizes."""
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
    assert found["latency"] == found["hysteresis"] == pytest.approx(0.5, abs=1e-3)
    for confidence in (0.2, 0.7):
        said = stated(found, "ambiguous", ["hysteresis", "latency"], confidence)
        assert said["latency"] == said["hysteresis"]


@pytest.mark.parametrize("confidence", [0.2, 0.6, 0.9])
def test_a_class_has_what_its_first_has_and_more(confidence: float) -> None:
    """The class is more probable than every effect outside it, and the effects keep their ratios.

    The first effect gets a confidence above its probability. A smaller confidence moves probability
    from the effects to ``unknown``, until the class is only just ahead of ``unknown``. The
    benchmark uses the probability of the first effect for the class.
    """
    members = ["hysteresis", "latency"]
    found = {"hysteresis": 0.5, "latency": 0.3, "vibration": 0.05, "unknown": 0.1, "none": 0.05}
    said = stated(found, "ambiguous", members, confidence)
    assert sum(said.values()) == pytest.approx(1.0, abs=1e-12)
    together = said["hysteresis"] + said["latency"]
    assert together > max(value for name, value in said.items() if name not in members)
    assert said["latency"] / said["vibration"] == pytest.approx(6.0)
    if confidence >= 0.5:
        assert said["hysteresis"] == pytest.approx(confidence)
        assert together >= 0.8
    else:
        assert said["hysteresis"] / said["latency"] == pytest.approx(5.0 / 3.0)
        assert together == pytest.approx(said["unknown"], rel=0.01)
        assert said["none"] == found["none"]


def test_verdicts_without_a_name_agree_with_their_probabilities() -> None:
    fits = [_candidate("latency", 900.0, 1e-9)]
    nothing = _posterior("adequate", fits, excluded=frozenset({"latency"}))
    assert max(nothing, key=nothing.__getitem__) in ("none", "unknown")
    strange = _posterior("unknown", fits, product=_candidate("product_of_parts", 950.0, 1e-12))
    assert max(strange, key=strange.__getitem__) == "unknown"
    silent = _posterior("cannot_tell", fits)
    # With this verdict every effect keeps its prior probability; here the catalogue has three
    # effects, two of which the set cannot test.
    assert silent["latency"] == pytest.approx(prior(3))
    assert silent["none"] == pytest.approx(PRIOR_NONE)


def test_weights_far_apart_have_a_sum_of_one() -> None:
    found = normalised({"none": -3.0, "unknown": 40_000.0, "latency": 40_001.0})
    assert sum(found.values()) == pytest.approx(1.0, abs=1e-12)
    assert found["latency"] == pytest.approx(1.0 / (1.0 + np.exp(-1.0)), abs=1e-9)


def test_faces_pay_for_the_rows_that_know_them() -> None:
    """The penalty in the evidence of the faces uses the number of rows that determine them: 480
    readings of the polygon determine the 23 sizes, and the 24,000 rows of the capture do not count.
    """
    faces = _candidate("polygon_face_error", 332.0, 1e-60, rank=23)
    line = _candidate("periodic_error", 120.0, 1e-12, rank=2)
    faces.rows = 480
    both = {"effect_class": ["polygon_face_error"], "excluded": frozenset({"periodic_error"})}
    assert _posterior("ambiguous", [faces, line], **both)["polygon_face_error"] > 0.9
    faces.rows = 24_480
    assert _posterior("ambiguous", [faces, line], **both)["unknown"] > 0.9


def _assert_the_largest_is_said(
    verdict: str, members: list[str], probability: dict[str, float]
) -> None:
    """Assert that the answer has the largest probability; for a class, its first effect has the
    largest one among the effects."""
    said = (SAID.get(verdict) or members)[0]
    rivals = set(probability) - ({NONE, UNKNOWN} if verdict == "ambiguous" else set())
    assert probability[said] == max(probability[name] for name in rivals), (verdict, said)


def test_no_verdict_contradicts_its_probabilities() -> None:
    """The answer agrees with the probabilities after the last rule, for random evidences of any
    size."""
    random = np.random.default_rng(12)
    names = ["latency", "vibration", "count_slip", "hysteresis", "timing_skew"]
    changed = 0
    for _ in range(3000):
        candidates = [
            _candidate(name, float(random.exponential(80.0)), 10.0 ** -random.uniform(0.0, 30.0),
                       rank=int(random.integers(1, 5)))
            for name in random.permutation(names)[: random.integers(1, 6)]
        ]  # fmt: skip
        verdict = str(random.choice(["named", "ambiguous", "unknown", "adequate", "cannot_tell"]))
        there = [item.name for item in candidates]
        members = there[: random.integers(1, 4)] if verdict in ("named", "ambiguous") else []
        product = _candidate("product_of_parts", float(random.exponential(80.0)), 1e-9, rank=2)
        changes = {
            "effect_class": members,
            "excluded": frozenset(there[len(members) :][: random.integers(0, 3)]),
            "product": product if random.random() < 0.5 else None,
            "lack_of_fit_p": 10.0 ** -random.uniform(0.0, 40.0),
            "look_alikes": ["settling"] if members and random.random() < 0.2 else [],
        }
        found = posterior(verdict, candidates, 2, near_tie=6.0, advantage=10.0, **changes)  # type: ignore[arg-type]
        last = _verdict(verdict, members, found)
        members = members if last != "unknown" else []
        said = stated(found, last, members, float(random.uniform(0.05, 0.999)))
        changed += last != verdict
        if last == "ambiguous":
            assert _verdict(last, members, said) == last, verdict
        _assert_the_largest_is_said(last, members, said)
        assert sum(said.values()) == pytest.approx(1.0, abs=1e-12)
    # The last rule has changed enough of the random answers to be tested.
    assert changed > 100


def test_a_class_of_one_effect_with_one_percent_is_no_class() -> None:
    """A vibration with less than one percent of the probability forms no class: at a single speed,
    a half-integer order, which the catalogue lacks, is over a hundred times as likely."""
    said = {"vibration": 0.0063, "unknown": 0.9937, "none": 0.0}
    assert _verdict("ambiguous", ["vibration"], said) == "unknown"
    # The more probable of the two becomes the answer; several similar effects share their
    # probability.
    for share, verdict in ((0.51, "unknown"), (0.49, "ambiguous")):
        both = {"vibration": 1.0 - share, "unknown": share, "none": 0.0}
        assert _verdict("ambiguous", ["vibration"], both) == verdict
    open_ = {"vibration": 0.15, "latency": 0.15, "unknown": 0.7, "none": 0.0}
    assert _verdict("ambiguous", ["vibration", "latency"], open_) == "ambiguous"


def test_effects_that_explain_the_rows_equally_keep_their_class() -> None:
    """A gear and a product of parts with fewer coefficients stay in one class: at 24 faces both are
    a wave of order 9."""
    members = [_candidate(name, 1000.0, 1e-200, rank=6) for name in ("gear", "faces")]
    product = _candidate("product_of_parts", 1000.0, 1e-200, rank=2)
    found = _posterior("ambiguous", members, effect_class=["gear", "faces"], product=product)
    assert _verdict("ambiguous", ["gear", "faces"], found) == "ambiguous"
    alone = _posterior("ambiguous", members, effect_class=["gear"], product=product)
    assert _verdict("ambiguous", ["gear"], alone) == "unknown"


def test_a_name_that_shares_its_probability_is_a_class() -> None:
    both = ["latency", "hysteresis"]
    for first, verdict in (
        (LEAST_OF_A_NAME + 0.01, "named"),
        (LEAST_OF_A_NAME - 0.01, "ambiguous"),
    ):
        said = {"latency": first, "hysteresis": 0.95 - first, "unknown": 0.05, "none": 0.0}
        assert _verdict("named", both, said) == verdict
