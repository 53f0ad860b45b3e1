"""Tests of the study on the page docs/heads.md: every row at a small scale, its bounds, and the
committed page."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from arctrue.base.json_text import plain
from arctrue.calibration.moved_head import moved_heads
from arctrue.report.heads_page import heads_page
from arctrue.studies.heads.shown import shown

ROOT = Path(__file__).resolve().parents[4]
COMMITTED = json.loads((ROOT / "docs" / "data" / "heads.json").read_text(encoding="utf-8"))
HEAD_RMS_ARCSEC = 0.25e-6 / 53.975e-3 * 206265.0 / np.sqrt(2.0)
"""RMS error of a head for an axis motion on a circle of 0.25 µm: 0.68″."""
SHIFT_RMS_ARCSEC = 2e-6 / 53.975e-3 * 206265.0 / np.sqrt(2.0)
"""RMS error of a head when the disc's centre has moved by 2 µm: 5.4″."""


@pytest.fixture(scope="module", params=["small", "committed"])
def found(request: pytest.FixtureRequest) -> dict[str, Any]:
    """Return a small study that runs now, and the study whose figures are on the page."""
    if request.param == "committed":
        return COMMITTED
    result: dict[str, Any] = plain(shown(samples_a_turn=4000, fine_orders=30, fine_turns=3, seed=2))
    return result


def test_a_ball_pass_is_attenuated_500_times(found: dict[str, Any]) -> None:
    row = found["ball_pass"]
    assert row["on_head1_rms_arcsec"] == pytest.approx(HEAD_RMS_ARCSEC, rel=0.05)
    assert row["attenuation"] >= 500.0
    assert row["two_heads_without_noise_rms_arcsec"] > 0.5
    assert row["mean_rms_arcsec"] <= 0.06
    assert row["mean_of_20_rms_arcsec"] < 0.025


def test_a_disc_that_moves_on_its_hub_does_not_show(found: dict[str, Any]) -> None:
    for row, bound in zip(found["hub_shift"], (0.005, 0.01), strict=True):
        assert row["on_head1_rms_arcsec"] == pytest.approx(SHIFT_RMS_ARCSEC, rel=0.02)
        assert row["two_heads_after_rms_arcsec"] == pytest.approx(SHIFT_RMS_ARCSEC, rel=0.1)
        assert row["on_mean_rms_arcsec"] <= bound


def test_any_head_may_be_missing(found: dict[str, Any]) -> None:
    every, *three = found["missing"]
    assert [one["missing"] for one in three] == [1, 2, 3, 4]
    for one in (every, *three):
        # The weights combine the noise of each head, 0.1″, and its rounding to counts of 0.077″,
        # 0.0223″ RMS. The reading of the carrier (the head whose counts the output follows) is
        # rounded before the correction; this rounding adds to the noise.
        expected = np.hypot(0.1, 0.0223) * one["noise"]
        assert one["rms_arcsec"] == pytest.approx(expected, rel=0.1)
        assert abs(one["zero_apart_arcsec"]) < 0.01
    assert all(one["noise"] <= 0.83 for one in three)
    # Each choice of heads needs coefficients of its own, because the error of its mean differs by
    # arcseconds.
    assert min(one["lanes_rms_arcsec"] for one in three) > every["lanes_rms_arcsec"] + 1.0


def test_a_head_that_moved_is_found_and_the_zero_is_kept(found: dict[str, Any]) -> None:
    for row in found["moved"]:
        assert row["found"] == [row["head"]]
        assert row["moved_arcsec"] == pytest.approx(100.0, abs=0.1)
        assert abs(row["wrong_by_arcsec"]) > 20.0
        assert abs(row["zero_after_arcsec"]) <= 0.05


def test_without_a_bound_of_the_axis_no_head_can_be_reported() -> None:
    places = np.radians([0.0, 64.3, 177.0, 257.9])
    changes = np.array([0.0, 100.0, 0.0, 0.0])
    ratios = np.ones(4)
    found = moved_heads(changes, places, ratios, axis_limit_arcsec=1e3, noise_arcsec=0.1)
    assert [one.head for one in found] == [1, 2, 3, 4]
    shift = 5.0 * np.cos(places) + 3.0 * np.sin(places)
    found = moved_heads(shift - shift[0], places, ratios, axis_limit_arcsec=20.0, noise_arcsec=0.1)
    assert [one.head for one in found] == [0]
    assert found[0].axis_arcsec == pytest.approx((3.0, 5.0))


def test_the_error_function_is_found_as_well_as_the_gains_say(found: dict[str, Any]) -> None:
    for row in found["error_function"]["rows"]:
        # The RMS of N coefficients has the relative scatter √(1/2N), where N is twice the number of
        # orders. The bound is four times this, plus 0.1 for the rounding to counts.
        scatter = 0.1 + 4.0 / np.sqrt(2.0 * 2.0 * row["orders"])
        known, expected = row["known_places_2_sigma_arcsec"], row["expected_2_sigma_arcsec"]
        assert (1.0 - scatter) * expected < known < (1.0 + scatter) * expected
        assert row["left_2_sigma_arcsec"] > (1.0 - scatter) * expected


def test_the_committed_error_function_reaches_what_was_asked_for() -> None:
    every, rest = COMMITTED["error_function"]["rows"]
    assert (every["orders"], every["turns"]) == (500, 10)
    assert every["left_2_sigma_arcsec"] <= 0.045
    # The RMS of 998 coefficients scatters by 1/√(2·998) = 2.2 %. The test allows four times
    # this scatter about the expected value, and twice this scatter above the limit of 0.012″.
    assert rest["expected_2_sigma_arcsec"] <= 0.012
    for row in (every, rest):
        assert row["known_places_2_sigma_arcsec"] == pytest.approx(
            row["expected_2_sigma_arcsec"], rel=4.0 / np.sqrt(2.0 * 998.0)
        )
    assert rest["left_2_sigma_arcsec"] <= 0.012 * (1.0 + 2.0 / np.sqrt(2.0 * 998.0))


def test_page_and_json_agree() -> None:
    page = (ROOT / "docs" / "heads.md").read_text(encoding="utf-8")
    assert page == heads_page(COMMITTED), "arctrue heads --page docs/heads.md --json ..."
