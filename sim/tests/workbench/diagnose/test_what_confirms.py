"""Tests which rows confirm an effect: the channels that it changes, blocks, passes, and a record
without its steps."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from sim.tests.workbench.small_sets import measurement_set

from arctrue.measurement import MeasurementSet, Reference, Table
from arctrue.workbench.diagnose.diagnosis import diagnose
from arctrue.workbench.diagnose.survey import Survey
from arctrue.workbench.effects.registry import built_in
from arctrue.workbench.inference import left as left_module
from arctrue.workbench.inference.design_matrix import Term
from arctrue.workbench.inference.fit import fit
from arctrue.workbench.inference.forward.events import Step
from arctrue.workbench.inference.forward.of_solution import without_steps
from arctrue.workbench.inference.left import Left, passes_of
from arctrue.workbench.model.model import default_model
from arctrue.workbench.observations.build import observations_of

EFFECTS = built_in()


def _left(capture: float, reference: float) -> Left:
    rms = {"capture": capture, "reference": reference}
    rows = {"capture": 15_000, "reference": 240}
    return Left(rms, rms, rms, rms, None, None, rows)  # type: ignore[arg-type]


def test_only_channels_with_columns_of_the_effect_are_judged(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """A reversal error removes two thirds of the reference's error. The 15,000 rows of the capture,
    in which it has no columns, have no weight."""
    monkeypatch.setattr(left_module, "passes_of", lambda solution: {"reference": 10})
    fall = _left(0.290, 0.161).mean_log_ratio(_left(0.268, 0.469))
    assert fall == pytest.approx(np.log(0.161 / 0.469))


def test_channels_count_with_their_passes(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(left_module, "passes_of", lambda solution: {"capture": 30, "reference": 10})
    found = _left(0.2, 0.4).mean_log_ratio(_left(0.1, 0.1))
    assert found == pytest.approx((30.0 * np.log(2.0) + 10.0 * np.log(4.0)) / 40.0)


def test_an_effect_counts_the_passes_of_its_channels() -> None:
    made = observations_of(measurement_set(runs=2))
    reference = made.reference
    assert reference is not None
    visits = reference.run.size / np.unique(np.round(reference.target_rad, 6)).size
    in_both = passes_of(fit([Term(EFFECTS["graduation_harmonics"](), {})], made))
    assert in_both["reference"] == pytest.approx(visits)
    assert set(in_both) == {"capture", "reference"}
    terms = [Term(EFFECTS[name](), {}) for name in ("graduation_harmonics", "reference_drift")]
    assert set(passes_of(fit(terms, made))) == {"reference"}


def _survey(left_over: float, gain: float, share: float) -> tuple[Survey, SimpleNamespace]:
    def solution(rms: float) -> SimpleNamespace:
        return SimpleNamespace(
            capture_residual_arcsec=lambda: None,
            reference_residual_arcsec=lambda: np.full(10, rms),
            observations=SimpleNamespace(capture=None),
            terms=(),
        )

    residuals = SimpleNamespace(solution=solution(29.1))
    survey = Survey(residuals, 0.0, 1)  # type: ignore[arg-type]
    item = SimpleNamespace(
        solution=solution(left_over),
        share=SimpleNamespace(share=share),
        improvement={"reference": SimpleNamespace(gain=gain, information=112.0)},
        regular=None,
        evidence=None,
        size_arcsec={"reference": 20.0},
        effect=SimpleNamespace(in_parts=()),
    )
    return survey, item


@pytest.mark.parametrize(
    ("left_over", "gain", "share", "objection"),
    [
        (10.0, 16.0, 0.65, None),
        (10.0, -1.0, 0.65, "rows that were left out of the fit do not show it"),
        (25.0, 16.0, 0.65, "rows that were left out of the fit do not show it"),
        (10.0, 60.0, 0.4, "other blocks of the rows predict at most half of this error"),
        (25.0, 60.0, 0.65, None),
    ],
)
def test_blocks_confirm_what_removes_most_of_the_error(
    left_over: float, gain: float, share: float, objection: str | None
) -> None:
    """A gain of 16 is below two standard errors, 2·√112 = 21, but blocks predict the effect and it
    removes most of the error; the objection names the test that failed."""
    survey, item = _survey(left_over, gain, share)
    assert survey.objection(item) == objection  # type: ignore[arg-type]
    assert survey.confirmed(item) is (objection is None)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("size", "quantum", "one"),
    [(-20.3, 20.0, True), (31.0, 20.0, False), (3.0, 0.0, False), (3.0, 0.01, False)],
)
def test_a_jump_of_one_display_step_is_no_jump(size: float, quantum: float, one: bool) -> None:
    assert Step(9, 1.0, size, 0.4, 50.0).may_be_one(quantum) is one


def _log(error: np.ndarray, step_s: float) -> MeasurementSet:
    time_s = step_s * np.arange(error.size)
    reference = Reference(
        target_deg=360.0 / 86_164.1 * time_s,
        error_arcsec=error,
        time_s=time_s,
        run=np.zeros(error.size, dtype=np.int64),
    )
    return MeasurementSet(Table(), None, reference, title="star")


def test_a_step_is_subtracted_to_the_end_of_its_stretch() -> None:
    jump = np.where(np.arange(300) >= 100, 5.0, 0.0)
    made = observations_of(_log(jump, 2.0))
    left = without_steps(made, [(200.0, 5.0)]).reference
    assert left is not None
    # The observations subtract the mean of the readings.
    assert np.ptp(left.error_arcsec) < 1e-9


@pytest.mark.large
def test_a_line_is_named_although_the_record_jumps() -> None:
    """A line of 7″ with twelve periods is named in a log that jumps once by 300″."""
    random = np.random.default_rng(8)
    number = np.arange(600)
    error = 7.0 * np.sin(2.0 * np.pi * number / 50.0) + random.normal(size=number.size)
    made = observations_of(_log(error + np.where(number >= 370, 300.0, 0.0), 10.0))
    found = diagnose(made, default_model().terms(EFFECTS), EFFECTS)
    assert found.named is not None
    assert found.named.name == "periodic_error"
    assert len(found.detections.steps) == 1
