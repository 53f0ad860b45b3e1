"""Draws the measured and the predicted amplitude of an effect over a condition."""

from __future__ import annotations

from arctrue.report.charts.chart import ARCSEC, CHANNEL_COLOUR, Axis, Chart, Curve, Panel
from arctrue.report.effect_amplitude import EffectAmplitude

_INK = "#5a6470"


def effect_amplitude_chart(finding: EffectAmplitude, condition: str) -> Chart:
    """Draw the measured amplitude with its standard error, and the amplitude of the fitted effect,
    in each step of the condition."""
    panels = []
    for item in finding.over(condition):
        what = "amplitude of the effect's wave" if item.amplitude else "part of the measured error"
        layers = [
            Curve(
                item.x,
                item.measured,
                "measured",
                CHANNEL_COLOUR[item.channel],
                kind="points",
                y_error=item.standard_error,
            ),
            Curve(item.x, item.effect, finding.effect.replace("_", " "), _INK, dash="dash"),
        ]
        panels.append(
            Panel(Axis(item.name, item.unit), Axis(what, ARCSEC), layers, item.channel.capitalize())
        )
    name = finding.effect.replace("_", " ")
    words = f"Size of {name} against {panels[0].x.label if panels else 'nothing'}."
    return Chart("finding", words, panels, columns=2, panel_height=3.0)
