"""Tests that the comparison lists the condition that causes the residual first, and conditions that
only resemble it as its shadows."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest
from sim.tests.workbench.small_sets import measurement_set, paper_error

import arctrue as at
from arctrue.cli.compare import short_coefficient_names
from arctrue.report.charts.matplotlib_chart import chart_figure
from arctrue.report.charts.residual_maps import residual_findings_chart
from arctrue.workbench.compare.comparison import compare
from arctrue.workbench.compare.findings import ExcessOf, Finding
from arctrue.workbench.effects.registry import built_in
from arctrue.workbench.inference.design_matrix import Term
from arctrue.workbench.inference.fit import fit
from arctrue.workbench.observations.build import observations_of


def _findings(**options: object) -> list[Finding]:
    observations = observations_of(measurement_set(**options))  # type: ignore[arg-type]
    base = fit([Term(built_in()["graduation_harmonics"](), {})], observations)
    return compare(base, 1).findings


def _warm(disc, temperature, speed):  # type: ignore[no-untyped-def]
    return paper_error(disc, temperature, speed) + 0.4 * (temperature - 20.0) * np.cos(disc + 0.7)


@pytest.mark.large
def test_time_is_the_shadow_of_heat() -> None:
    found = [item for item in _findings(error=_warm) if item.channel == "capture"]
    first = found[0]
    # The warm run is also the last one, so that time resembles temperature.
    assert first.follows in ("temperature × order 1", "time × order 1")
    assert first.shadow_of is None
    assert first.share > 0.9
    assert first.share_beyond == pytest.approx(first.share)
    shadows = {item.follows: item for item in found if item.shadow_of == first.follows}
    other = ({"temperature × order 1", "time × order 1"} - {first.follows}).pop()
    assert shadows[other].share > 0.8
    assert shadows[other].share_beyond < 0.05
    assert f"resembles {first.follows}" in shadows[other].text


def test_two_causes_both_stand_by_themselves() -> None:
    found = _findings(
        error=_warm, electrical=lambda phase: 0.8 * np.cos(phase + 0.3), reference=False
    )
    alone = {item.follows: item for item in found if item.shadow_of is None}
    assert any("× order 1" in name for name in alone)
    phases = [item for name, item in alone.items() if name.startswith("electrical phase")]
    assert phases
    # No finding's share includes the share of another finding, so that the sum of the shares is at
    # most about 1.
    assert sum(item.share_beyond for item in alone.values()) < 1.1
    # An error of 0.8″ in each head is 0.64 arcsec² in the difference; the warming causes a wave of
    # 0.9″ in the difference, in one of the four runs.
    assert all(item.share_beyond > 0.1 for item in phases)


def test_nothing_beyond_chance_is_no_finding() -> None:
    assert _findings() == []


def test_chance_takes_its_share_from_the_noise_only() -> None:
    """At six stations, up and down, the readings differ by the direction, and by noise of 0.02″.
    In so few rows, the means of the bins may explain 0.8 of the noise, but here the noise is a
    small part of the residual."""
    target = np.tile(np.arange(6) * 60.0, 2)
    direction = np.repeat([1.0, -1.0], 6)
    error = 2.0 * np.sin(np.radians(target)) + 0.7 * direction
    error += np.random.default_rng(1).normal(scale=0.02, size=12)
    data = {"target_deg": target, "direction": direction, "error_arcsec": error}
    data |= {"cycle": np.repeat([0, 1], 6)}
    found = at.compare(
        at.Dataset.from_pandas(reference=pd.DataFrame(data)), at.Model()
    ).result.findings
    assert found[0].follows == "direction"
    # The fit of order 1 leaves 0.32″ RMS that does not follow the direction: 0.17 of the variance.
    assert found[0].share == pytest.approx(0.83, abs=0.02)


def test_share_of_the_excess() -> None:
    # With a noise of 3 and a whole residual of 5, the excess is 16 of 25.
    assert ExcessOf(100, 5.0, 4.0).share(0.32) == pytest.approx(0.5)
    # If the effect does not repeat, the repeats scatter as much as the whole residual, so that
    # there is no excess; the share then refers to the whole residual.
    assert ExcessOf(100, 5.0, 0.5).share(0.32) == pytest.approx(0.32)
    assert [ExcessOf(100, 5.0, excess).words for excess in (4.0, 0.5)] == ["excess", "variance"]
    assert ExcessOf(100, 5.0, 4.0).share(-0.1) == 0.0


def test_the_picture_shows_what_the_text_says() -> None:
    """The chart has one bar for each sentence, in the same order; its length is the stated
    share."""
    found = [
        Finding("capture", "temperature × order 1", 0.97, 0.97, None, "97 % …"),
        Finding("capture", "time", 0.81, 0.02, "temperature × order 1", "time …"),
        Finding("reference", "direction", 0.4, 0.4, None, "40 % …"),
    ]
    (axes,) = chart_figure(residual_findings_chart(found)).axes
    places = dict(
        zip((t.get_text() for t in axes.get_yticklabels()), axes.get_yticks(), strict=True)
    )
    assert list(places) == [f"{item.channel}: {item.follows}" for item in found]
    assert sorted(places.values(), reverse=True) == list(places.values()), "the first stands above"
    widths: dict[int, list[float]] = {}
    for bar in (bar for bars in axes.containers for bar in bars):
        middle = round(bar.get_y() + bar.get_height() / 2.0)
        widths.setdefault(middle, []).append(bar.get_width())
    for item, place in zip(found, places.values(), strict=True):
        assert widths[round(place)] == [100.0 * item.share, 100.0 * item.share_beyond]


def test_names_of_many_coefficients_are_short() -> None:
    names = [f"graduation: {wave} {order}" for order in (1, 2, 3, 7) for wave in ("cos", "sin")]
    names += ["graduation: cos 9", "hysteresis: reversal", "one"]
    assert short_coefficient_names(names) == [
        "graduation: orders 1-3, 7, cos 9",
        "hysteresis: reversal",
        "one",
    ]
