"""Tests of the ordered rules of the verdict; each test makes a set for its rule."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest
from sim.tests.workbench.base_diagnosis import diagnosis_of
from sim.tests.workbench.small_sets import ARCSEC, COUNTS_PER_REV, measurement_set, paper_error

from arctrue.workbench.diagnose.classes import OF_THE_SAME_KIND
from arctrue.workbench.diagnose.every_pass import on_every_pass
from arctrue.workbench.diagnose.report import sentences
from arctrue.workbench.diagnose.report_json import diagnosis_data
from arctrue.workbench.effects.registry import built_in

EFFECTS = built_in()
COUNT_ARCSEC = 2.0 * np.pi / COUNTS_PER_REV / ARCSEC


@pytest.mark.large
def test_a_head_that_knocks_again_and_again_has_not_slipped() -> None:
    """The diagnosis does not call repeated knocks a slip, although each knock is a step of whole
    counts. The residuals show the other steps only if the model contains the first step."""
    counts = 12
    instants = np.array([3.1, 9.7, 15.2, 22.8, 29.9])

    def knocks(time, speed):  # type: ignore[no-untyped-def]
        return counts * COUNT_ARCSEC * (np.searchsorted(instants, time) % 2)

    found = diagnosis_of(measurement_set(runs=2, cycles=3, head2_only=knocks))
    assert found.verdict == "unknown"
    assert found.named is None
    assert found.decision.resembles is not None
    reported = diagnosis_data(found, ["graduation_harmonics"])
    assert reported["resembles"] == found.decision.resembles.name
    assert reported["unlike"]
    assert any("resembles" in sentence for sentence in sentences(found))
    assert found.probability["unknown"] == max(found.probability.values())


def test_one_slip_of_whole_counts_keeps_its_name() -> None:
    def slip(time, speed):  # type: ignore[no-untyped-def]
        return 12 * COUNT_ARCSEC * ((time > 15.2) & (time < 60.0))

    found = diagnosis_of(measurement_set(runs=2, cycles=3, head2_only=slip))
    assert found.named is not None
    assert found.named.name == "count_slip"
    assert found.further == []


@pytest.mark.large
def test_a_slip_that_is_no_whole_number_of_counts_is_none() -> None:
    def slip(time, speed):  # type: ignore[no-untyped-def]
        return 12.5 * COUNT_ARCSEC * ((time > 18.2) & (time < 60.0))

    found = diagnosis_of(measurement_set(runs=2, cycles=3, head2_only=slip))
    assert found.verdict == "unknown"
    assert found.decision.resembles is not None
    assert found.decision.resembles.name == "count_slip"
    stated = re.search(r"step of ([\d.]+) ± ([\d.]+) counts", str(found.decision.unlike))
    assert stated is not None
    counts, sigma = map(float, stated.groups())
    # The bound is 4 stated standard uncertainties and half of the last printed digit.
    assert counts == pytest.approx(12.5, abs=4.0 * sigma + 0.005)


@pytest.mark.large
def test_a_small_second_matter_does_not_take_the_name_of_the_first() -> None:
    """The diagnosis names the reversal error of 1.6″ although order 2 grows with the temperature.
    The gain of order 2 is at most a hundredth of the gain of the reversal error."""
    share = 0.3 * np.sqrt(OF_THE_SAME_KIND)

    def error(disc, temperature, speed):  # type: ignore[no-untyped-def]
        return paper_error(disc, temperature, speed) + 0.2 * share * (temperature - 20.0) * np.cos(
            2 * disc + 0.7
        )

    found = diagnosis_of(measurement_set(error, reversal_arcsec=1.6))
    assert found.named is not None
    assert found.named.name == "hysteresis"


@pytest.mark.large
def test_what_only_the_reference_shows_is_not_asked_of_the_runs_of_the_capture() -> None:
    """The lean of the polygon needs no evidence from the runs of the capture. In the capture, it
    changes only order 1, which the graduation absorbs; only the reference shows the lean."""
    measurement = measurement_set()
    assert measurement.reference is not None
    target = np.radians(measurement.reference.target_deg)
    measurement.reference.error_arcsec[:] += 0.5 * np.cos(target + 2.0)
    found = diagnosis_of(measurement)
    assert found.base is not None
    lean = next(item for item in found.candidates if item.name == "polygon_eccentricity")
    rows = found.base.observations.capture
    assert rows is not None
    assert on_every_pass(lean, found.base)
    assert found.named is lean
    # Noise may change order 1 of the capture by different amounts in each run; this must neither
    # confirm nor contradict the lean.
    change = lean.solution.capture_prediction_arcsec(False) - found.base.capture_prediction_arcsec(
        False
    )
    uneven = rows.difference_arcsec + np.where(rows.run == 0, 50.0, -50.0) * change
    capture = replace(rows, difference_arcsec=uneven)
    there = replace(found.base, observations=replace(found.base.observations, capture=capture))
    assert on_every_pass(lean, there)
