"""Tests that the diagnosis of a dense log names the largest regular cause first. A regular cause is
an effect that causes sine waves (lines). This module computes the logs."""

from __future__ import annotations

import numpy as np
import pytest

from arctrue.measurement import MeasurementSet, Reference, Table
from arctrue.workbench.diagnose.diagnosis import Diagnosis, diagnose
from arctrue.workbench.diagnose.report import sentences
from arctrue.workbench.diagnose.report_json import diagnosis_data
from arctrue.workbench.effects.registry import built_in
from arctrue.workbench.model.model import default_model
from arctrue.workbench.observations.build import observations_of
from tests.workbench.noisy_logs import (
    clock,
    driven_oscillator,
    ornstein_uhlenbeck,
    with_lines,
)

EFFECTS = built_in()
SIDEREAL_DEG_S = 360.0 / 86_164.1
TEETH = 180.0
WORM_S = 86_164.1 / TEETH
ROWS, STEP_S = 1600, 1.2


def _diagnosed(
    time_s: np.ndarray,
    error: np.ndarray,
    *,
    teeth: float | None = None,
    speed: float = 1.0,
) -> Diagnosis:
    """Diagnose the log of a guide star; the axis follows the sky at ``speed`` times the sidereal
    rate."""
    reference = Reference(
        target_deg=speed * SIDEREAL_DEG_S * time_s,
        error_arcsec=error,
        time_s=time_s,
        run=np.zeros(time_s.size, dtype=np.int64),
    )
    measurement = MeasurementSet(Table(drive_gear_teeth=teeth), None, reference, title="star")
    return diagnose(observations_of(measurement), default_model().terms(EFFECTS), EFFECTS)


def _noise(seed: int) -> tuple[np.ndarray, np.ndarray]:
    random = np.random.default_rng(seed)
    time_s = clock(random, ROWS, STEP_S, "jitter")
    noise = 0.8 * ornstein_uhlenbeck(random, time_s, 20.0) + 0.4 * random.normal(size=ROWS)
    return time_s, noise


@pytest.mark.large
def test_the_worm_is_named_before_smaller_lines() -> None:
    """The diagnosis names the worm before the smaller lines. The log contains the worm with 8″ and
    its second multiple with 1.5″, a gear in front of the worm with 3″, and a line of 0.5″ with a
    period of 6 s."""
    time_s, noise = _noise(1)
    lines = [(8.0, WORM_S), (1.5, WORM_S / 2.0), (3.0, 131.0), (0.5, 6.0)]
    found = _diagnosed(time_s, with_lines(time_s, lines) + noise, teeth=TEETH)
    assert found.named is not None
    assert found.named.name == "drive_gear_error"
    causes = found.detections.causes
    assert [cause.effect.name for cause in causes[:2]] == ["drive_gear_error", "periodic_error"]
    assert [line.multiple for line in causes[0].lines] == [1, 2]
    assert causes[1].period_s(causes[1].lines[0]) == pytest.approx(131.0, rel=0.01)
    # The RMS of both sines of the worm is √((8² + 1.5²)/2); Ornstein–Uhlenbeck noise of 0.8″ and 20
    # s changes it by a tenth.
    assert causes[0].taken_arcsec == pytest.approx(np.sqrt((64.0 + 2.25) / 2.0), rel=0.1)
    assert [item.name for item in found.further][:1] == ["periodic_error"]
    data = diagnosis_data(found, ["graduation_harmonics"])["findings"]
    assert data["regular"][0]["lines"][0]["multiple"] == 1
    assert any(
        text.startswith("Regular errors in the reference") and "drive_gear_error" in text
        for text in sentences(found)
    )


@pytest.mark.large
def test_a_gear_near_a_multiple_of_the_worm_is_not_the_worm() -> None:
    """The mount has a worm without error and a spur gear whose period is 1 % shorter than a third
    of the worm's: the log of 4,200 s separates the two by seven standard uncertainties of the
    order."""
    teeth, period_s = 144.0, 197.3
    random = np.random.default_rng(8)
    time_s = clock(random, 1400, 3.0, "jitter")
    noise = 0.6 * ornstein_uhlenbeck(random, time_s, 90.0) + 0.8 * random.normal(size=1400)
    found = _diagnosed(time_s, with_lines(time_s, [(3.0, period_s)]) + noise, teeth=teeth)
    assert found.named is not None
    assert found.named.name == "periodic_error"
    assert found.named.parameters()["period_time"].value == pytest.approx(period_s, rel=0.003)


@pytest.mark.large
def test_without_a_tooth_count_the_largest_line_is_named() -> None:
    time_s, noise = _noise(2)
    lines = [(3.6, 122.0), (1.2, 81.0), (0.5, 6.0)]
    found = _diagnosed(time_s, with_lines(time_s, lines) + noise)
    assert found.named is not None
    assert found.named.name == "periodic_error"
    period = found.named.parameters()["period_time"].value
    assert period == pytest.approx(122.0, rel=0.01)


@pytest.mark.large
def test_a_small_line_with_a_slow_change_is_said_to_be_the_smaller_part() -> None:
    """The diagnosis says that the named line of 1″ is the smaller part of the error. The larger
    part is 9″, rises and falls three times, and is no line; its RMS is nine times as large.
    """
    time_s, noise = _noise(3)
    found = _diagnosed(time_s, with_lines(time_s, [(9.0, 600.0), (1.0, 6.0)]) + noise)
    assert found.named is not None
    assert found.named.parameters()["period_time"].value == pytest.approx(6.0, rel=0.01)
    said = sentences(found)
    smaller = [place for place, text in enumerate(said) if "explains the smaller part" in text]
    assert len(smaller) == 1
    assert smaller[0] < next(place for place, text in enumerate(said) if "Regular errors" in text)


@pytest.mark.large
def test_a_line_that_is_most_of_the_error_is_not_said_to_be_the_smaller_part() -> None:
    time_s, noise = _noise(4)
    found = _diagnosed(time_s, with_lines(time_s, [(3.6, 122.0)]) + noise)
    assert found.named is not None
    assert not any("smaller part" in text for text in sentences(found))


@pytest.mark.large
@pytest.mark.parametrize("seed", [3, 4])
def test_a_resonance_that_noise_drives_is_no_line(seed: int) -> None:
    """The diagnosis names no line for a resonance of quality 15, which keeps its phase for a fifth
    of the log, so that neighbouring blocks predict it as well as a line."""
    random = np.random.default_rng(seed)
    time_s = clock(random, ROWS, STEP_S, "even")
    error = 2.0 * driven_oscillator(random, time_s, 80.0, 15.0) + 0.3 * random.normal(size=ROWS)
    found = _diagnosed(time_s, error)
    assert found.detections.causes == ()
    assert found.verdict != "adequate"
    assert found.named is None


@pytest.mark.large
def test_a_slow_curve_is_no_line() -> None:
    """The diagnosis names no line for a slow curve with 1.4 periods in the log."""
    time_s, noise = _noise(5)
    error = 5.0 * np.sin(2.0 * np.pi * 1.4 * time_s / time_s[-1]) + noise
    found = _diagnosed(time_s, error)
    assert found.detections.causes == ()
    assert found.named is None or found.named.name != "periodic_error"


def test_a_jump_is_reported_as_a_jump() -> None:
    """The diagnosis reports a jump of 3″ at 700 s, seven times the scatter of neighbours. The
    verdict is not "adequate", and no line is reported.
    """
    random = np.random.default_rng(6)
    time_s = clock(random, ROWS, STEP_S, "even")
    error = 0.4 * random.normal(size=ROWS) + np.where(time_s > 700.0, 3.0, 0.0)
    found = _diagnosed(time_s, error)
    assert found.verdict != "adequate"
    assert found.detections.causes == ()
    (jump,) = found.detections.steps
    # The jump lies between two rows, which are 1.2 s apart; the tolerance is two rows.
    assert jump.time_s == pytest.approx(700.0, abs=2.0 * STEP_S)
    assert jump.size_arcsec == pytest.approx(3.0, abs=0.1)
    assert any("jumped at" in text for text in sentences(found))


def test_white_noise_is_adequate_or_cannot_tell() -> None:
    """The diagnosis finds no effect in white noise; but the log of one axis has too few columns to
    test most effects."""
    random = np.random.default_rng(7)
    time_s = clock(random, ROWS, STEP_S, "even")
    found = _diagnosed(time_s, 0.4 * random.normal(size=ROWS))
    assert found.detections.causes == ()
    assert found.detections.steps == ()
    assert not found.detections.not_noise
    assert found.verdict in ("adequate", "cannot_tell")
