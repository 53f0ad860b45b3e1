"""Tests that a figure of an arc ends where the arc ends, and that a figure of the whole turn goes
from 0 to 360.

The arc may contain the angle 0.
"""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from arctrue.report.analysis import analyse
from arctrue.report.charts.angle_window import AngleWindow
from arctrue.report.charts.bins import of_turn
from arctrue.report.charts.chart import Band, Bars, Curve, HeatMap, Layer
from arctrue.report.charts.plotly_chart import chart_data
from arctrue.report.display import DisplaySettings, chart_of
from arctrue.workbench.effects.registry import built_in
from arctrue.workbench.model.model import default_model
from tests.workbench.small_sets import measurement_set

ARC_DEG = 9.0
OVER_THE_TURN = ("measurement_and_model", "branches", "heat_map", "residual_against")


@pytest.mark.parametrize("start", [-4.5, 0.0, 100.0, 351.0, 355.5, 719.0])
@pytest.mark.parametrize("span", [0.0, ARC_DEG, 90.0, 179.0])
def test_an_arc_has_its_own_ends(start: float, span: float) -> None:
    angle = np.radians(np.linspace(start, start + span, 2001))
    window = AngleWindow.over(angle[::-1])
    assert window.span_deg == pytest.approx(span, abs=1e-9)
    assert np.cos(np.radians(window.start_deg - start)) == pytest.approx(1.0, abs=1e-12)
    assert -180.0 < window.start_deg <= 360.0
    places = window.degrees(angle)
    assert np.diff(places) == pytest.approx(np.full(2000, span / 2000), abs=1e-9)
    low, high = window.axis().reach or (0.0, 0.0)
    assert low < places.min() <= places.max() < high


def test_the_bins_of_an_arc_have_the_means_of_their_rows() -> None:
    random = np.random.default_rng(5)
    place, values = random.uniform(-4.0, 5.0, 900), random.normal(size=900)
    window = AngleWindow.over(np.radians(place + 360.0))
    found = window.bins(np.radians(place), values, 9)
    step = window.span_deg / 9
    for number in range(9):
        low = window.start_deg + number * step
        inside = (place >= low - 1e-9) & (place < low + step + (1e-9 if number == 8 else -1e-9))
        assert found.mean[number] == pytest.approx(values[inside].mean())
        assert found.centre[number] == pytest.approx(place[inside].mean())


@pytest.mark.parametrize("stations", [2, 3, 24, 3000])
def test_the_whole_turn_is_as_it_was(stations: int) -> None:
    angle = np.arange(stations) * 2.0 * np.pi / stations + 0.1
    window = AngleWindow.over(angle)
    assert window.is_whole
    assert window.axis().reach == (0.0, 360.0)
    here, there = window.bins(angle, np.cos(angle), 36), of_turn(angle, np.cos(angle), 36)
    assert here.centre.tolist() == there.centre.tolist()
    assert here.mean.tolist() == there.mean.tolist()


def _reach(layer: Layer) -> tuple[float, float]:
    assert isinstance(layer, Band | Curve | HeatMap | Bars)
    x = layer.place if isinstance(layer, Bars) else layer.x
    return float(np.min(x)), float(np.max(x))


def test_figures_of_an_arc_show_the_arc() -> None:
    made = measurement_set(runs=2, cycles=2, turns=3)
    capture, reference = made.capture, made.reference
    assert capture is not None
    assert reference is not None
    # The rows lie within 4.5° on each side of 0.
    turn = 2**24
    near = np.abs((capture.head1_counts + turn / 2) % turn - turn / 2) < ARC_DEG / 720.0 * turn
    target = np.linspace(-ARC_DEG / 2, ARC_DEG / 2, reference.target_deg.size)
    arc = dataclasses.replace(
        made,
        capture=capture.where(near),
        reference=dataclasses.replace(reference, target_deg=target % 360.0),
    )
    seen = analyse(arc, "", default_model(), built_in())
    for name in OVER_THE_TURN:
        chart = chart_of(name, seen, None, DisplaySettings(against="angle"))
        assert chart is not None
        layout = chart_data(chart)["layout"]
        for number, panel in enumerate(chart.panels):
            low, high = layout[f"xaxis{'' if number == 0 else number + 1}"]["range"]
            assert ARC_DEG < high - low < 1.2 * ARC_DEG, (name, panel.title)
            for layer in panel.layers:
                if not hasattr(layer, "value"):
                    assert low < _reach(layer)[0] <= _reach(layer)[1] < high, (name, panel.title)
