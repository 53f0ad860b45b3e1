"""Tests that a head that loses the same number of counts again and again is described as such."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray
from sim.tests.workbench.base_diagnosis import diagnosis_of

from arctrue.measurement import Capture, MeasurementSet, Table
from arctrue.workbench.diagnose.equal_slips import EqualSlips, equal_slips
from arctrue.workbench.diagnose.report import sentences
from arctrue.workbench.effects.registry import built_in
from arctrue.workbench.inference.design_matrix import Term
from arctrue.workbench.inference.fit import fit
from arctrue.workbench.observations.build import observations_of

Float = NDArray[np.float64]
COUNTS = 1 << 24
COUNT_ARCSEC = 1_296_000.0 / COUNTS
SPEEDS = (30.0, -30.0, 120.0, -120.0)
SAMPLES = 2000


def _set(of_head2: NDArray[np.int64], seed: int) -> MeasurementSet:
    """Return four runs of two turns with 0.1″ of noise a head; ``of_head2``: counts that are added
    to head 2, (rows,)."""
    rng = np.random.default_rng(seed)
    turn = np.linspace(0.0, 720.0, SAMPLES)
    run = np.repeat(np.arange(4), SAMPLES)
    angle = np.concatenate([rng.uniform(0.0, 360.0) + np.sign(v) * turn for v in SPEEDS])
    time = np.concatenate([40.0 * n + turn / abs(v) for n, v in enumerate(SPEEDS)])
    heads = []
    for place in (0.0, 33.0):
        at = np.radians(angle + place)
        error = 40.0 * np.cos(at + 1.0) + 5.0 * np.cos(2.0 * at) + 1.0 * np.cos(7.0 * at)
        reading = 3600.0 * (angle + place) + error + 0.1 * rng.normal(size=run.size)
        heads.append(np.round(reading / COUNT_ARCSEC).astype(np.int64))
    table = Table(counts_per_rev=COUNTS, head_separation_deg=33.0)
    capture = Capture(run, time, heads[0], heads[1] + of_head2)
    return MeasurementSet(table, capture, None)


def _losses(sizes: dict[int, list[int]], seed: int) -> NDArray[np.int64]:
    """Return counts that fall by the given numbers at random instants of each run, 40 samples or
    more from each other and from the ends."""
    rng = np.random.default_rng(seed)
    lost = np.zeros(4 * SAMPLES, dtype=np.int64)
    for run, each in sizes.items():
        places = 40 * rng.choice(np.arange(1, SAMPLES // 40 - 1), len(each), replace=False)
        for place, size in zip(places.tolist(), each, strict=True):
            lost[run * SAMPLES + place : (run + 1) * SAMPLES] -= size
    return lost


def _found(of_head2: NDArray[np.int64], seed: int) -> EqualSlips | None:
    observations = observations_of(_set(of_head2, seed))
    return equal_slips(fit([Term(built_in()["graduation_harmonics"](), {})], observations))


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_equal_losses_in_the_fast_runs_are_counted(seed: int) -> None:
    lost = _losses({2: [16] * 6, 3: [16] * 5}, seed)
    found = _found(lost, seed)
    assert found is not None
    assert found.counts == -16
    assert found.of_run == {2: 6, 3: 5}
    assert found.only_when_fast


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_a_good_head_and_a_single_slip_lose_no_counts_again(seed: int) -> None:
    assert _found(np.zeros(4 * SAMPLES, dtype=np.int64), seed) is None
    assert _found(_losses({2: [16]}, seed), seed) is None


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_knocks_of_different_sizes_are_no_equal_losses(seed: int) -> None:
    assert _found(_losses({1: [13, 29], 2: [18, 41], 3: [24, 7]}, seed), seed) is None
    assert _found(_losses({1: [16, -16], 2: [16, -16], 3: [-16, 16]}, seed), seed) is None


@pytest.mark.parametrize("teeth", [10, 40])
def test_a_saw_of_the_angle_is_no_staircase(teeth: int) -> None:
    """A saw falls by 16 counts at every tooth, and rises evenly between the teeth."""
    turn = np.tile(np.linspace(0.0, 2.0, SAMPLES), 4)
    saw = np.round(16.0 * np.mod(teeth * turn, 1.0)).astype(np.int64)
    assert _found(saw, 1) is None


def _short(slips: int, seed: int) -> MeasurementSet:
    """Return 40 runs of one turn with 60 rows; in each of the first ``slips`` runs, head 2 loses 64
    counts in the middle."""
    rng = np.random.default_rng(seed)
    rows, runs = 60, 40
    run = np.repeat(np.arange(runs), rows)
    turn = np.tile(np.arange(rows) * 360.0 / rows, runs)
    lost = 64 * ((run < slips) & (np.tile(np.arange(rows), runs) >= rows // 2))
    heads = []
    for place in (0.0, 33.0):
        error = 40.0 * np.cos(np.radians(turn + place) + 1.0) + 0.1 * rng.normal(size=run.size)
        heads.append(np.round((3600.0 * (turn + place) + error) / COUNT_ARCSEC).astype(np.int64))
    capture = Capture(run, 100.0 * run + turn / 30.0, heads[0], heads[1] - lost)
    return MeasurementSet(Table(counts_per_rev=COUNTS, head_separation_deg=33.0), capture, None)


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_losses_in_short_runs_are_counted(seed: int) -> None:
    """All slips are counted, although only 29 of a run's 60 rows have SIDE rows on both sides."""
    base = [Term(built_in()["graduation_harmonics"](orders=[1]), {})]
    found = equal_slips(fit(base, observations_of(_short(6, seed))))
    assert found is not None
    assert found.counts == -64
    assert found.of_run == dict.fromkeys(range(6), 1)
    assert equal_slips(fit(base, observations_of(_short(0, seed)))) is None


def test_the_diagnosis_describes_the_losses_and_asks_for_the_index() -> None:
    found = diagnosis_of(_set(_losses({2: [16] * 6, 3: [16] * 6}, 4), 4))
    assert found.verdict == "unknown"
    said = " ".join(sentences(found))
    assert "R₂ − R₁ falls by 16 counts (1.24″) again and again" in said
    assert "only the runs at 120°/s or more have such slips" in said
    assert "with the index counts recorded" in said
