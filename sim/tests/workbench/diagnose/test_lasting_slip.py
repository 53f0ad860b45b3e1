"""Tests that lost counts of a head are named, whether or not the head searches its index before the
next run."""

from __future__ import annotations

import numpy as np
import pytest

from arctrue.workbench.diagnose.report import sentences
from arctrue.workbench.effects.catalogue.count_slip import CountSlip
from arctrue.workbench.effects.registry import built_in
from arctrue.workbench.inference.design_matrix import Term
from arctrue.workbench.inference.fit import fit
from arctrue.workbench.inference.residuals import Residuals
from arctrue.workbench.inference.scan.steps import step_scan
from arctrue.workbench.observations.build import observations_of
from tests.workbench.base_diagnosis import diagnosis_of
from tests.workbench.small_sets import COUNTS_PER_REV, measurement_set

COUNTS = 3 * 1024
COUNT_ARCSEC = 1_296_000.0 / COUNTS_PER_REV
SLIP_S, RUN_ENDS_S = 26.0, 32.0
"""Instant of the slip, in the second of four runs, and the end of that run."""


@pytest.mark.parametrize("stays", [True, pytest.param(False, marks=pytest.mark.large)])
def test_lost_counts_of_head_2(stays: bool) -> None:
    """Head 2 loses 3,072 counts (237″, noise 0.14″) in the second of four turns."""

    def slipped(time_s: np.ndarray, speed: float) -> np.ndarray:
        after = (time_s > SLIP_S) & ((time_s < RUN_ENDS_S + 1.0) | stays)
        return np.asarray(-COUNTS * COUNT_ARCSEC * after)

    found = diagnosis_of(measurement_set(head2_only=slipped, turns=1, reference=False))
    assert found.verdict == "named"
    assert found.named is not None
    assert found.named.name == "count_slip"
    assert found.named.effect.settings == {"stays": stays}
    values = found.named.parameters()
    assert values["run"].value == 1.0
    # Samples are 10 ms apart; the step lies between two of them.
    assert values["instant"].value == pytest.approx(SLIP_S, abs=0.02)
    # Half a count: the size must be this whole number of counts.
    assert values["counts"].value == pytest.approx(-COUNTS, abs=0.5)
    assert any("stays in the following runs" in text for text in sentences(found)) == stays


def test_the_instant_of_a_slip_in_runs_of_two_turns() -> None:
    """The second of four runs lasts from 40 s to 64 s, with samples 10 ms apart."""

    def slipped(time_s: np.ndarray, speed: float) -> np.ndarray:
        return np.asarray(-COUNTS * COUNT_ARCSEC * (time_s > 44.0))

    found = diagnosis_of(measurement_set(head2_only=slipped, turns=2, reference=False))
    assert found.named is not None
    assert found.named.name == "count_slip"
    assert found.named.effect.settings == {"stays": True}
    instant = found.named.parameters()["instant"]
    # The step lies anywhere between two samples: √3 standard uncertainties are half a sample.
    assert abs(instant.value - 44.0) <= np.sqrt(3.0) * instant.sigma * (1.0 + 1e-6)


def test_p_counts_a_step_that_stays_and_one_that_ends_with_its_run() -> None:
    """With the setting ``stays``, only steps that stay are searched. Without it, both forms are
    searched: twice as many instants for the same step."""

    def slipped(time_s: np.ndarray, speed: float) -> np.ndarray:
        return np.asarray(-COUNTS * COUNT_ARCSEC * (time_s > SLIP_S))

    observations = observations_of(measurement_set(head2_only=slipped, turns=1, reference=False))
    model = [Term(built_in()["graduation_harmonics"](), {})]
    residuals = Residuals(fit(model, observations))
    both, staying = (step_scan(CountSlip(stays=stays), residuals)[0] for stays in (False, True))
    assert both.nonlinear == staying.nonlinear
    assert both.gain == pytest.approx(staying.gain)
    assert both.trials == pytest.approx(2.0 * staying.trials)
