"""Tests that the diagnosis gives no false name to a disc order that has an alias at the samples.

With N evenly spaced samples per turn, the cos and sin columns of order N − n equal those of order
n, up to a phase that depends on where a run starts.
"""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from arctrue.measurement import Capture, MeasurementSet, Table
from arctrue.workbench.diagnose.diagnosis import Diagnosis
from arctrue.workbench.diagnose.report import sentences
from arctrue.workbench.diagnose.report_json import diagnosis_data
from tests.workbench.base_diagnosis import diagnosis_of
from tests.workbench.small_sets import ALPHA, ARCSEC, COUNTS_PER_REV, Float, paper_error

RUNS = ((30.0, 0.0), (-30.0, 60.0), (90.0, 120.0))
"""Speed in deg/s and start time in s of each run."""
TURNS = 4.0
START_RAD = 1.0


def _reading(at_disc_rad: Float, order: float) -> Float:
    """Solve R = ψ + ε(R) in 3 iterations, where ε is the paper's error plus 0.6″ of one order.

    Each iteration multiplies the remaining error of R by the slope of ε, below 10⁻³.
    """
    found = at_disc_rad
    for _ in range(3):
        error = paper_error(found, np.full(found.size, 20.0), 1.0) + 0.6 * np.cos(
            order * found + 0.7
        )
        found = at_disc_rad + error * ARCSEC
    return found


@cache
def _diagnosed(order: float, samples_a_turn: float, *, starts_differ: bool) -> Diagnosis:
    random = np.random.default_rng(1)
    rows = int(samples_a_turn * TURNS)
    columns: dict[str, list[Float]] = {name: [] for name in ("run", "time", "h1", "h2")}
    for run, (speed_deg, start_s) in enumerate(RUNS):
        step = np.sign(speed_deg) * 2.0 * np.pi / samples_a_turn
        start = START_RAD + (1.7 * run if starts_differ else 0.0)
        angle = start + np.arange(rows) * step
        columns["run"].append(np.full(rows, float(run)))
        columns["time"].append(start_s + np.arange(rows) * abs(step) / np.radians(abs(speed_deg)))
        for name, offset in (("h1", 0.0), ("h2", ALPHA)):
            value = _reading(angle + offset, order) + random.normal(0.0, 0.08 * ARCSEC, rows)
            columns[name].append(np.round(value / (2.0 * np.pi) * COUNTS_PER_REV))
    joined = {name: np.concatenate(values) for name, values in columns.items()}
    capture = Capture(
        run=joined["run"].astype(np.int64),
        time_s=joined["time"],
        head1_counts=joined["h1"].astype(np.int64),
        head2_counts=joined["h2"].astype(np.int64),
        temperature_c=np.full(joined["time"].size, 20.0),
    )
    table = Table(counts_per_rev=COUNTS_PER_REV, head_separation_deg=float(np.degrees(ALPHA)))
    return diagnosis_of(MeasurementSet(table, capture, None))


@pytest.mark.parametrize(
    ("order", "samples"), [pytest.param(129.0, 233.3, marks=pytest.mark.large), (129.0, 234.0)]
)
def test_runs_from_other_angles_show_which_order_it_is(order: float, samples: float) -> None:
    """Runs that start at different angles determine the order. At N = 233.3 samples per turn, order
    129 looks like order 104.3 in each run, but the phase of this alias differs from run to run by
    N·start."""
    found = _diagnosed(order, samples, starts_differ=True)
    assert found.named is not None
    assert found.named.name == "high_order_graduation"
    assert found.named.nonlinear["order"] == order
    assert diagnosis_data(found, [])["aliases"] == []


@pytest.mark.large
@pytest.mark.parametrize("samples", [233.3, 234.0])
def test_runs_from_one_angle_leave_a_class(samples: float) -> None:
    """Order 129 and a line at N − 129 both remain possible: the class contains the graduation of
    order 129, and the diagnosis lists 129 as an alias of the line at N − 129."""
    found = _diagnosed(129.0, samples, starts_differ=False)
    assert found.verdict == "ambiguous"
    assert "high_order_graduation" in found.effect_class
    place = next(item for item in found.candidates if item.name == "high_order_graduation")
    assert place.nonlinear["order"] == 129.0
    listed = diagnosis_data(found, [])["aliases"]
    assert listed[0] == pytest.approx(129.0, abs=0.01)
    said = next(text for text in sentences(found) if "or its alias" in text)
    assert said.startswith(f"Order {samples - 129.0:.4g}")


def test_listed_aliases_are_the_same_columns_at_the_samples() -> None:
    """The cos and sin columns of each listed order span those of the set's line of order 104.3 at
    every sample."""
    found = _diagnosed(104.3, 233.3, starts_differ=False)
    assert "periodic_error" in found.effect_class
    listed = diagnosis_data(found, [])["aliases"]
    assert len(listed) == 2
    step = np.arange(int(233.3 * TURNS)) * 2.0 * np.pi / 233.3
    line = np.stack([np.cos(104.3 * step), np.sin(104.3 * step)], axis=1)
    for order in listed:
        alias = np.stack([np.cos(order * step), np.sin(order * step)], axis=1)
        left = line - alias @ np.linalg.lstsq(alias, line, rcond=None)[0]
        # The search finds the order of the line to 0.0005, which causes a phase error of 0.006 rad
        # over half of four turns.
        np.testing.assert_allclose(left, 0.0, atol=0.015)


def test_a_well_sampled_order_is_named_as_before() -> None:
    found = _diagnosed(61.0, 233.3, starts_differ=True)
    assert found.named is not None
    assert found.named.nonlinear["order"] == 61.0
    assert diagnosis_data(found, [])["aliases"] == []
