"""Tests that the first fitted values of a slip are its true instant, counts and head, in a capture
with few runs."""

from __future__ import annotations

import numpy as np
import pytest

from arctrue.measurement import Capture, MeasurementSet, Table
from arctrue.workbench.diagnose.report import sentences
from arctrue.workbench.effects.catalogue.count_slip import CountSlip
from arctrue.workbench.effects.registry import built_in
from arctrue.workbench.inference.design_matrix import Term
from arctrue.workbench.inference.fit import fit
from arctrue.workbench.inference.residuals import Residuals
from arctrue.workbench.inference.scan.steps import step_scan
from arctrue.workbench.observations.build import observations_of
from tests.workbench.base_diagnosis import diagnosis_of

COUNTS_PER_REV = 1 << 22
SAMPLES, STEP_S = 1200, 1.0 / 300.0
SECOND_RUN_S = 34.0


def _two_runs(seed: int, *, head: int, counts: int, sample: int) -> MeasurementSet:
    """Return a run of three turns up and one down; in the second run, one head gains counts."""
    random = np.random.default_rng(seed)
    turns = 3.0 * np.arange(SAMPLES) / SAMPLES
    angle = np.concatenate([0.2 + turns, 3.4 - turns])
    time_s = STEP_S * np.arange(SAMPLES)
    readings = []
    for place in (0.0, 40.0 / 360.0):
        disc = 2.0 * np.pi * (angle + place)
        error = 25.0 * np.cos(disc - 0.7) + 3.0 * np.cos(2.0 * disc) + np.sin(5.0 * disc + 1.0)
        error += random.normal(0.0, 0.12, angle.size)
        readings.append(np.rint((angle + place + error / 1_296_000.0) * COUNTS_PER_REV))
    readings[head - 1][SAMPLES + sample :] += counts
    capture = Capture(
        run=np.repeat([0, 1], SAMPLES),
        time_s=np.concatenate([time_s, SECOND_RUN_S + time_s]),
        head1_counts=readings[0].astype(np.int64),
        head2_counts=readings[1].astype(np.int64),
    )
    return MeasurementSet(Table(COUNTS_PER_REV, head_separation_deg=40.0), capture, None)


@pytest.mark.parametrize("seed", [1, 2, 3])
@pytest.mark.parametrize("sample", [130, 480, 900])
def test_the_scan_finds_the_sample_of_the_slip(seed: int, sample: int) -> None:
    """A slip of 256 counts is 79″, 400 times the noise of 0.2″: the scan must find the sample
    itself."""
    measured = _two_runs(seed, head=2, counts=256, sample=sample)
    base = fit([Term(built_in()["graduation_harmonics"](), {})], observations_of(measured))
    found = step_scan(CountSlip(), Residuals(base))[0]
    assert found.nonlinear["run"] == 1.0
    assert found.nonlinear["instant"] == pytest.approx(SECOND_RUN_S + sample * STEP_S, abs=1e-6)


@pytest.mark.parametrize(("head", "counts"), [(2, 256), (1, -1024)])
def test_the_named_slip_is_the_true_one(head: int, counts: int) -> None:
    found = diagnosis_of(_two_runs(1, head=head, counts=counts, sample=480))
    assert found.named is not None
    assert found.named.name == "count_slip"
    values = found.named.parameters()
    # The step lies between two samples.
    assert values["instant"].value == pytest.approx(SECOND_RUN_S + 479.5 * STEP_S, abs=STEP_S)
    # R₂ − R₁ rises if head 2 gains counts, and falls if head 1 gains counts.
    sign = 1.0 if head == 2 else -1.0
    assert values["counts"].value == pytest.approx(sign * counts, abs=0.6)
    assert found.further == []
    text = " ".join(sentences(found))
    assert "explains a further part" not in text
    assert f"Head {head} {'gains' if counts > 0 else 'loses'} counts there" in text
    assert values["head"].value == head
