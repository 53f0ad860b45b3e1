"""Tests of stated probabilities: the fit against simulated answers, the mean over uncertain
coefficients against an integral."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.special import expit
from scipy.stats import norm

from arctrue.studies.benchmark.stated import FILE as TABLE
from arctrue.studies.benchmark.stated import (
    Stated,
    confidences,
    fitted,
    read_stated,
    write_stated,
)
from arctrue.workbench.diagnose import calibrated
from arctrue.workbench.diagnose.calibrated import (
    DISTANCES,
    FEATURES,
    FILE,
    KINDS,
    Calibration,
    calibration,
    confidence,
    features,
)
from arctrue.workbench.diagnose.distance import Distance
from arctrue.workbench.diagnose.grounds import Grounds

USUAL = Grounds(0.999, -30.0, 200.0, 150.0, 0.9, 0.0, 1, 0, Distance(0.1, 4, 20.0, 1.0, 0.3))
MACKAY = 0.01
"""Largest error with which σ(μ/√(1 + πv/8)) approximates the mean of a logistic function of a
normal value, for variances v up to 9."""


@pytest.mark.parametrize("variance", [0.1, 1.0, 9.0])
@pytest.mark.parametrize("mean", [0.5, 2.0, 4.0])
def test_what_is_stated_is_the_mean_over_the_uncertain_value(mean: float, variance: float) -> None:
    row = np.zeros(len(FEATURES))
    row[0] = 1.0
    learned = Calibration(mean * row, variance * np.diag(row), {"named": 100_000})
    expected, _ = quad(lambda x: expit(x) * norm.pdf(x, mean, variance**0.5), -30.0, 40.0)
    assert learned.confidence("named", row) == pytest.approx(expected, abs=2 * MACKAY)


@pytest.mark.parametrize("answers", [0, 3, 200])
def test_nothing_is_stated_surer_than_it_was_counted(answers: int) -> None:
    """Laplace's rule limits the confidence: if n of n answers were right and the prior is flat, the
    probability that the next answer is right is the posterior mean."""
    row = np.zeros(len(FEATURES))
    row[0] = 1.0
    share = (
        quad(lambda p: p ** (answers + 1), 0.0, 1.0)[0] / quad(lambda p: p**answers, 0.0, 1.0)[0]
    )
    for sign, expected in ((1.0, share), (-1.0, 1.0 - share)):
        learned = Calibration(sign * 30.0 * row, np.zeros((row.size, row.size)), {"named": answers})
        assert learned.confidence("named", row) == pytest.approx(expected, abs=1e-9)


@pytest.mark.parametrize("verdict", KINDS)
def test_the_farther_from_the_benchmark_the_less_sure(verdict: str) -> None:
    """Each distance from the benchmark lowers the confidence, and all distances together lower it
    most.

    The test compares probabilities without the limit for few counted answers, because this limit
    would hide a distance that has no effect.
    """
    away = [
        replace(USUAL.distance, untested=0.9),
        replace(USUAL.distance, left=8.0),
        replace(USUAL.distance, not_white=300.0),
        replace(USUAL.distance, runs=1, visits=0.0),
        Distance(0.95, 1, 0.0, 8.0, 300.0),
    ]
    unlimited = replace(calibration(), answers=dict.fromkeys(KINDS, 10**12))

    def stated(distance: Distance) -> float:
        grounds = replace(USUAL, distance=distance)
        found = unlimited.confidence(verdict, features(verdict, grounds))
        most = 1.0 - 1.0 / (calibration().answers[verdict] + 2.0)
        limited = min(max(found, 1.0 - most), most)
        assert confidence(verdict, grounds) == pytest.approx(limited, abs=1e-12)
        return found

    usual = stated(USUAL.distance)
    found = [stated(distance) for distance in away]
    assert all(value < usual for value in found)
    assert found[-1] == min(found)


def test_faulty_data_have_no_confidence() -> None:
    assert confidence("bad_data", USUAL) is None


def test_evidence_does_not_count_if_nothing_can_be_reported() -> None:
    assert confidence("cannot_tell", replace(USUAL, evidence=0.0)) == confidence(
        "cannot_tell", USUAL
    )


def _drawn(number: int, share: float, verdict: str, random: np.random.Generator) -> list[Stated]:
    return [
        Stated("simulated", "white", verdict, "", bool(random.random() < share), 0.97,
               0.999, 0.1, 4, 20.0, 1.0, 0.3, 0)
        for _ in range(number)
    ]  # fmt: skip


def test_the_fit_states_the_share_that_is_right() -> None:
    """The confidences of a fit to 4,000 names and 4,000 classes agree with the known shares of
    right answers within 4 binomial standard errors."""
    random = np.random.default_rng(7)
    rows = _drawn(4000, 0.97, "named", random) + _drawn(4000, 0.7, "ambiguous", random)
    learned = fitted(rows)
    for verdict, share in (("named", 0.97), ("ambiguous", 0.7)):
        (one,) = confidences([row for row in rows if row.verdict == verdict][:1], learned)
        assert one == pytest.approx(share, abs=4 * np.sqrt(share * (1 - share) / 4000))
    signs = dict(zip(FEATURES, learned.coefficients, strict=True))
    assert signs["evidence"] >= 0.0
    assert all(signs[name] <= 0.0 for name in DISTANCES)
    assert learned.answers["named"] == learned.answers["ambiguous"] == 4000


def test_few_answers_are_not_trusted() -> None:
    """After three answers that were all right, the confidence is above 0.5 but below 0.95."""
    rows = _drawn(3, 1.0, "named", np.random.default_rng(1))
    (few,) = confidences(rows[:1], fitted(rows))
    assert 0.5 < few < 0.95


def test_the_table_is_read_as_it_was_written(tmp_path) -> None:  # type: ignore[no-untyped-def]
    rows = read_stated(TABLE)
    write_stated(rows, tmp_path / "stated.csv")
    assert (tmp_path / "stated.csv").read_bytes() == TABLE.read_bytes()
    assert {row.generator for row in rows} == {"simulated", "independent"}


def test_the_coefficients_in_use_are_those_of_the_table() -> None:
    """A new fit to the table agrees with the stored coefficients, except for the rounding in the
    file and the last digits of the optimiser."""
    rows = read_stated(TABLE)
    assert json.loads(FILE.read_text(encoding="utf-8"))["features"] == list(FEATURES)
    here, used = fitted(rows), calibration()
    for row in rows:
        one = features(row.verdict, row.grounds)
        expected = here.confidence(row.verdict, one)
        assert used.confidence(row.verdict, one) == pytest.approx(expected, abs=2e-3)


def test_evidence_beyond_what_likelihoods_can_know_does_not_count() -> None:
    held = 1.0 - calibrated.SUREST_EVIDENCE
    assert confidence("named", replace(USUAL, evidence=1.0)) == pytest.approx(
        confidence("named", replace(USUAL, evidence=held))
    )
