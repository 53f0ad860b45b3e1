"""Tests which rows of a capture with four heads the workbench uses, which rows it reports as
faulty, and which rows a planned measurement adds."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from arctrue.measurement import MeasurementSet
from arctrue.workbench.diagnose.data_faults import data_faults
from arctrue.workbench.diagnose.planned import PLANS
from arctrue.workbench.effects.base import FitContext
from arctrue.workbench.effects.capture_block import capture_block
from arctrue.workbench.effects.registry import built_in
from arctrue.workbench.observations import part
from arctrue.workbench.observations.build import observations_of
from tests.workbench.base_diagnosis import diagnosis_of
from tests.workbench.heads.four_heads import COUNTS, PLACES_DEG, FourHeads


def _with(measurement: MeasurementSet, head: int, counts: np.ndarray) -> MeasurementSet:
    assert measurement.capture is not None
    column = {f"head{head}_counts": counts}
    return replace(measurement, capture=replace(measurement.capture, **column))


def _counts(measurement: MeasurementSet, head: int) -> np.ndarray:
    assert measurement.capture is not None
    return measurement.capture.heads[head - 1].copy()


def test_a_sample_with_one_wrong_head_is_left_out_with_all_heads() -> None:
    measurement = FourHeads(samples=300).measured(7)
    counts = _counts(measurement, 4)
    counts[100] += 400
    observations = observations_of(_with(measurement, 4, counts))
    # The header is line 1 of the file.
    assert [(row.channel, row.row) for row in observations.masked] == [("capture", 102)]
    assert observations.capture is not None
    assert observations.capture.run.size == 3 * (4 * 300 - 1)
    # Row 399 is in the second channel of the first run, where each channel has 299 rows.
    assert observations.capture_sample is not None
    lines = [observations.sample_line(int(observations.capture_sample[k])) for k in (99, 100, 399)]
    assert lines == [101, 103, 103]


def test_a_head_that_stands_elsewhere_is_a_fault_of_the_data() -> None:
    measurement = FourHeads(samples=300).measured(7)
    wrong = _with(measurement, 3, _counts(measurement, 3) + COUNTS // 20)
    faults = data_faults(observations_of(wrong))
    assert len(faults) == 1
    assert "head 3 reads 180.500° ahead of head 1, expected 162.5°" in faults[0]
    assert "head_places_deg" in faults[0]


def test_counts_that_are_whole_turns_apart_are_those_of_the_same_place() -> None:
    """A head that passes its index mark later than head 1 counts from a later turn, which may
    differ from run to run; the place of a head does not."""
    measurement = FourHeads(samples=300).measured(7)
    assert measurement.capture is not None
    late = COUNTS * (measurement.capture.run == 1)
    shifted = _with(measurement, 4, _counts(measurement, 4) - COUNTS)
    shifted = _with(shifted, 2, _counts(measurement, 2) - late)
    found, expected = (observations_of(one) for one in (shifted, measurement))
    assert data_faults(found) == []
    assert found.capture is not None
    assert expected.capture is not None
    np.testing.assert_array_equal(
        found.capture.difference_arcsec, expected.capture.difference_arcsec
    )


def test_time_stamps_that_stand_still_are_reported_once() -> None:
    measurement = FourHeads(samples=300).measured(7)
    assert measurement.capture is not None
    time_s = measurement.capture.time_s.copy()
    time_s[:300] = 5.0
    faults = data_faults(
        observations_of(replace(measurement, capture=replace(measurement.capture, time_s=time_s)))
    )
    assert [fault for fault in faults if "stays at 5 s" in fault] == faults
    assert len(faults) == 1


def test_a_capture_without_a_place_for_each_head_is_refused() -> None:
    measurement = FourHeads(samples=300).measured(7)
    table = replace(measurement.table, head_places_deg=(0.0, 33.0), head_separation_deg=None)
    with pytest.raises(ValueError, match="a place for each of the 4 heads"):
        observations_of(replace(measurement, table=table))


@pytest.mark.large
@pytest.mark.parametrize("size", [0.1, 1.0])
def test_the_part_of_a_long_capture_has_every_head(
    size: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The part of a long capture in which the diagnosis searches has rows of every head. The full
    capture exceeds 150,000 rows: 4 runs of 14,000 samples with three differences each.

    The small capture has a tenth of the rows, of the limit, and of the rows that a turn keeps.
    """
    samples = round(14_000 * size)
    for name in ("MOST_ROWS", "LEAST_ROWS_A_TURN"):
        monkeypatch.setattr(part, name, round(getattr(part, name) * size))
    measured = FourHeads(slip=(1, 3, 40), samples=samples).measured(7)
    assert observations_of(measured).stored is not None
    found = diagnosis_of(measured)
    assert found.decision.first is not None
    values = found.decision.first.parameters()
    assert (values["run"].value, values["head"].value) == (1.0, 3.0)
    # The step lies in the middle of the run, half way between two samples.
    duration = 2.0 * 2.0 * np.pi / 0.5
    assert abs(values["instant"].value - (400.0 + 0.5 * duration)) < duration / samples
    assert abs(values["counts"].value - 40.0) < 5.0 * values["counts"].sigma


def test_a_planned_run_has_every_head() -> None:
    """The columns of the new rows are the contrasts of heads at the places that the set states."""
    observations = observations_of(FourHeads(samples=300).measured(7))
    before = observations.capture
    assert before is not None
    motion = built_in()["radial_error_motion"](orders=[3])
    tried = 0
    for plan in PLANS:
        after = plan.with_it(observations)
        if after is None or after.capture is None or after.capture.runs == before.runs:
            continue
        tried += 1
        rows = after.capture
        assert rows.runs == before.runs + 3
        assert rows.channel is not None
        assert after.recorded_runs == observations.recorded_runs + 1
        columns = capture_block(motion, rows, {}, FitContext())
        assert columns is not None
        # Head i reads cos pᵢ times a motion in y; the contrast is the reading of head 4 minus the
        # mean of the other heads.
        shares = np.cos(np.radians(PLACES_DEG))
        share = np.sqrt(1.5) * (shares[3] - shares[:3].mean())
        new = rows.run == before.runs + 2
        assert new.any()
        wanted = share * np.cos(3.0 * rows.angle_rad[new])
        assert np.abs(columns[new, 2] - wanted).max() < 1e-12
    assert tried >= 2
