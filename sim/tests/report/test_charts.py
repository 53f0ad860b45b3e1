"""Tests that the figures of page and report draw the right values, and that each axis names its
unit."""

from __future__ import annotations

import json
import xml.etree.ElementTree as ElementTree

import numpy as np
import plotly.graph_objects as go
import pytest
from msgspec.structs import replace

from arctrue.base.json_text import plain
from arctrue.report.analysis import Analysis, analyse, with_effect
from arctrue.report.charts.bins import of_turn
from arctrue.report.charts.chart import (
    ARCSEC,
    QUIET,
    Axis,
    Chart,
    Curve,
    HeatMap,
    Level,
    Panel,
    in_unit,
)
from arctrue.report.charts.heat_map import heat_map
from arctrue.report.charts.ladder import ladder
from arctrue.report.charts.matplotlib_chart import chart_svg, save_chart
from arctrue.report.charts.measurement_and_model import measurement_and_model
from arctrue.report.charts.plotly_chart import chart_data
from arctrue.report.charts.spectrum import Along, highest_of_groups, spectrum
from arctrue.report.display import FIGURES, DisplaySettings, chart_of
from arctrue.report.effect_amplitude import effect_amplitude
from arctrue.workbench.effects.registry import built_in
from arctrue.workbench.model.model import default_model
from tests.workbench.small_sets import CAPTURE_NOISE, measurement_set, paper_error

HEAT_ARCSEC_A_KELVIN = 0.4
URAD_PER_ARCSEC = np.pi / 648_000.0 * 1e6
"""Microradians per arcsecond: by definition π rad are 180 · 3600″."""
SHAKING_HZ = 7.0
RULED_ORDER, RULED_ARCSEC = 37, 0.5
WITHOUT_UNIT = {"run", "cycle", "step", "order, cycles a turn"}
"""Axes that show counts, which have no unit."""


@pytest.fixture(scope="module")
def warming() -> Analysis:
    """Analyse, with the paper's model, a table whose order 1 grows with the temperature."""

    def error(disc: np.ndarray, warm: np.ndarray, speed: float) -> np.ndarray:
        return paper_error(disc, warm, speed) + HEAT_ARCSEC_A_KELVIN * (warm - 20.0) * np.cos(disc)

    measured = measurement_set(error)
    return analyse(measured, "warming", default_model(), built_in())


@pytest.fixture(scope="module")
def added(warming: Analysis) -> Analysis:
    return with_effect(warming, "thermal_eccentricity", {})


def curves(chart: Chart, panel: int = 0) -> dict[str, Curve]:
    return {layer.name: layer for layer in chart.panels[panel].layers if isinstance(layer, Curve)}


def test_a_bin_has_the_mean_and_the_ends_of_its_rows() -> None:
    random = np.random.default_rng(3)
    angle, values = random.uniform(-9.0, 9.0, 500), random.normal(size=500)
    found = of_turn(angle, values, 36)
    for centre, mean, low, high in zip(
        found.centre, found.mean, found.low, found.high, strict=True
    ):
        inside = [
            value
            for at, value in zip(angle, values, strict=True)
            if abs((np.degrees(at) - centre + 180.0) % 360.0 - 180.0) < 5.0
        ]
        assert mean == pytest.approx(np.mean(inside))
        assert (low, high) == (min(inside), max(inside))


def test_the_finding_is_what_was_put_in(added: Analysis) -> None:
    found = effect_amplitude(added, added.solution)
    assert (found.effect, found.best) == ("thermal_eccentricity", "temperature")
    (capture,) = [item for item in found.over("temperature") if item.channel == "capture"]
    # cos(ψ + 33°) − cos ψ has the amplitude 2 sin 16.5°, and a wave of RMS 1 has the amplitude √2.
    slope = HEAT_ARCSEC_A_KELVIN * 2.0 * np.sin(np.radians(16.5)) / np.sqrt(2.0)
    rise = np.polyfit(capture.x, capture.measured, 1)[0]
    # The cold and the warm rows differ by 4 K. Each row has 0.1″·√2 of noise, and 3,600 rows are
    # warm; the tolerance of the slope is three standard errors.
    assert rise == pytest.approx(slope, abs=3.0 * CAPTURE_NOISE * np.sqrt(2.0 / 3600.0) / 4.0)
    # The fitted effect must lie on a straight line over the temperature, because it contains no
    # noise.
    straight = np.polyval(np.polyfit(capture.x, capture.effect, 1), capture.x)
    assert np.abs(capture.effect - straight).max() < 0.01 * np.ptp(capture.effect)
    assert np.abs(capture.effect - capture.measured).max() < 5.0 * capture.standard_error.max()


def test_a_high_order_is_drawn_over_its_own_phase() -> None:
    def ruled(disc: np.ndarray, warm: np.ndarray, speed: float) -> np.ndarray:
        return paper_error(disc, warm, speed) + RULED_ARCSEC * np.cos(RULED_ORDER * disc)

    made = measurement_set(ruled, runs=1, cycles=1)
    seen = with_effect(analyse(made, "", default_model(), built_in()), "high_order_graduation", {})
    found = effect_amplitude(seen, seen.solution)
    (shown,) = [item for item in found.over(found.best) if item.channel == "capture"]
    assert shown.name == f"phase of order {RULED_ORDER}"
    # The expected size is the amplitude of the order in the difference of two heads 33° apart.
    size = RULED_ARCSEC * 2.0 * abs(np.sin(np.radians(RULED_ORDER * 33.0 / 2.0)))
    assert np.ptp(shown.effect) / 2.0 == pytest.approx(size, rel=0.05)
    assert shown.share == pytest.approx(1.0, abs=0.01)


def test_whitened_measurement_scatters_by_one(added: Analysis) -> None:
    left = added.left("capture", whitened=True)
    assert float(np.std(left)) == pytest.approx(1.0, abs=0.05)
    assert measurement_and_model(added, whitened=True).panels[0].y.unit == "standard deviations"


def test_the_ladder_has_every_step(added: Analysis) -> None:
    chart = ladder(added.model.history)
    first, last = added.model.history
    for number, panel in enumerate(chart.panels):
        channel = panel.title.lower()
        drawn = curves(chart, number)
        assert drawn["fitted"].y.tolist() == [first.rms_arcsec[channel], last.rms_arcsec[channel]]
        assert drawn["held out"].y[-1] == last.heldout_rms_arcsec[channel]
        (floor,) = [layer for layer in panel.layers if isinstance(layer, Level)]
        assert floor.name == "noise"
        assert floor.value == last.noise_arcsec[channel]


def test_the_heat_map_shows_the_warm_run_alone(warming: Analysis) -> None:
    (layer,) = [item for item in heat_map(warming).panels[0].layers if isinstance(item, HeatMap)]
    spread = np.nanstd(layer.values, axis=1)
    assert int(np.argmax(spread)) == 3
    assert spread[3] > 5.0 * np.median(spread)


def test_microradians_are_the_same_angles(added: Analysis) -> None:
    chart = ladder(added.model.history)
    other = in_unit(chart, "urad")
    before, after = curves(chart)["fitted"].y, curves(other)["fitted"].y
    assert after == pytest.approx(before * URAD_PER_ARCSEC, rel=1e-12)
    assert other.panels[0].y.text.endswith("µrad")
    reach = other.panels[0].y.reach
    assert reach is not None
    assert reach[0] < after.min() < after.max() < reach[1]


@pytest.mark.parametrize("name", [name for name in FIGURES if name not in ("finding", "lanes")])
@pytest.mark.parametrize("unit", ["arcsec", "urad"])
def test_each_figure_can_be_drawn_and_says_its_units(added: Analysis, name: str, unit: str) -> None:
    chart = chart_of(name, added, None, DisplaySettings(unit=unit))  # type: ignore[arg-type]
    assert chart is not None
    assert chart.words
    for panel in chart.panels:
        for axis in (panel.x, panel.y):
            assert axis.unit != "1" or axis.label in WITHOUT_UNIT, axis
    # go.Figure checks the data against plotly's own schema. The JSON must not contain NaN, which
    # browsers cannot read.
    data = json.loads(json.dumps(plain(chart_data(chart)), allow_nan=False))
    assert len(go.Figure(data).data) >= len(chart.panels)
    svg = ElementTree.fromstring(chart_svg(chart))
    assert svg.attrib["aria-label"] == chart.words


@pytest.mark.parametrize("along", ["hz", "s"])
def test_the_spectrum_in_time_marks_a_vibration(along: Along) -> None:
    def shake(time: np.ndarray, speed: float) -> np.ndarray:
        return 0.5 * np.cos(2.0 * np.pi * SHAKING_HZ * time)

    made = measurement_set(head2_only=shake, runs=1, cycles=2)
    seen = analyse(made, "", default_model(), built_in())
    panel = spectrum(seen.residuals, along).panels[0]
    (marks,) = [item for item in panel.layers if isinstance(item, Curve) and item.labels]
    place = float(marks.x[0])
    # The single run lasts 36 s, and the spectrum's frequencies are 1/72 Hz apart.
    assert (place if along == "hz" else 1.0 / place) == pytest.approx(SHAKING_HZ, abs=1.0 / 72.0)
    assert marks.y[0] == pytest.approx(0.5, rel=0.1)


@pytest.mark.parametrize("rates", [1999, 4001, 5999])
def test_the_curve_of_a_spectrum_contains_a_line_at_each_end(rates: int) -> None:
    amplitude = np.ones(rates)
    amplitude[[0, -1]] = 9.0
    assert {0, rates - 1} <= set(highest_of_groups(amplitude))


def test_panels_stand_below_one_another_on_a_phone(added: Analysis) -> None:
    chart = ladder(added.model.history)
    wide, narrow = (chart_data(chart, width)["layout"] for width in (1200, 350))
    assert wide["xaxis"]["domain"][1] < wide["xaxis2"]["domain"][0]
    assert narrow["xaxis"]["domain"] == narrow["xaxis2"]["domain"]
    assert narrow["height"] > wide["height"]


def test_a_name_with_marks_is_text(added: Analysis) -> None:
    last = replace(added.model.history[-1], effect="<b>x</b> & $y$")
    chart = ladder([*added.model.history[:-1], last])
    texts = chart_data(chart)["layout"]["xaxis"]["ticktext"]
    assert texts[-1] == "2 add<br>&lt;b>x&lt;/b> &amp; $y$"
    assert "$y$" in chart_svg(chart)


def test_a_picture_is_written(added: Analysis, tmp_path) -> None:  # type: ignore[no-untyped-def]
    path = save_chart(ladder(added.model.history), tmp_path / "new" / "ladder.png")
    assert path.read_bytes().startswith(b"\x89PNG")


def test_a_circle_of_equal_scales_is_a_circle_on_paper_and_on_the_page() -> None:
    angle = np.linspace(0.0, 2.0 * np.pi, 200)
    circle = Curve(np.cos(angle), 3.0 * np.sin(angle), "orbit", QUIET)
    panel = Panel(Axis("x", ARCSEC), Axis("y", ARCSEC), [circle], equal_scales=True)
    chart = Chart("orbit", "The orbit of an axis.", [panel])
    assert go.Figure(chart_data(chart)).layout.yaxis.scaleanchor == "x"
    path = max(
        (
            item.attrib["d"]
            for item in ElementTree.fromstring(chart_svg(chart)).iter()
            if "d" in item.attrib
        ),
        key=len,
    )
    numbers = np.array([part.split() for part in path.replace("M", "").split("L")], dtype=float)
    across, upright = np.ptp(numbers, axis=0)
    assert upright / across == pytest.approx(3.0, rel=0.01)
