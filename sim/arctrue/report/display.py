"""Reads and writes the settings of an analysis page's display, which are the query part of its
address."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any
from urllib.parse import urlencode

from arctrue.report.analysis import Analysis, Condition
from arctrue.report.charts.branches import branches
from arctrue.report.charts.chart import ARCSEC, URAD, Angle, Chart, in_unit
from arctrue.report.charts.effect_amplitude_chart import effect_amplitude_chart
from arctrue.report.charts.heat_map import heat_map
from arctrue.report.charts.ladder import ladder
from arctrue.report.charts.lanes_chart import lanes_chart
from arctrue.report.charts.measurement_and_model import measurement_and_model
from arctrue.report.charts.residual_against import residual_against, share_of_variance
from arctrue.report.charts.spectrum import ALONG, Along, spectrum
from arctrue.report.ranking import Ranking, effect_amplitude_from
from arctrue.workbench.model.noise_floor import floor_of

FIGURES = (
    "measurement_and_model",
    "residual_against",
    "branches",
    "spectrum",
    "heat_map",
    "finding",
    "ladder",
    "lanes",
)
"""Names of the figures in the order in which the page shows them."""


_HOTTEST_C = 200.0


@dataclass(frozen=True)
class DisplaySettings:
    """Settings that the reader chose; an empty text means the default setting."""

    unit: Angle = ARCSEC
    whitened: bool = False
    against: str = ""
    along: Along = "order"
    finding: str = ""
    temperature_c: float | None = None
    """Temperature for which the device's coefficients are computed; None: lanes that change with
    the temperature follow the table's thermometer."""
    reveal: bool = False

    @classmethod
    def of_query(cls, query: Mapping[str, str]) -> DisplaySettings:
        """Parse the query of an address; ignore invalid parts."""
        along = query.get("along", "order")
        return cls(
            unit=URAD if query.get("unit") == URAD else ARCSEC,
            whitened=query.get("whitened") == "1",
            against=query.get("against", ""),
            along=along if along in ALONG else "order",
            finding=query.get("finding", ""),
            temperature_c=_temperature(query.get("temperature", "")),
            reveal=query.get("reveal") == "1",
        )

    def query(self, **changes: Any) -> str:
        """Return the query for these settings with changes; it is empty for the default
        settings."""
        other = replace(self, **changes)
        said = {
            "unit": other.unit if other.unit != ARCSEC else "",
            "whitened": "1" if other.whitened else "",
            "against": other.against,
            "along": other.along if other.along != "order" else "",
            "finding": other.finding,
            "temperature": "" if other.temperature_c is None else f"{other.temperature_c:g}",
            "reveal": "1" if other.reveal else "",
        }
        text = urlencode({key: value for key, value in said.items() if value})
        return f"?{text}" if text else ""


def temperature_fault(text: str) -> str:
    """Return the sentence for a temperature that cannot be used; an empty text if there is no
    fault."""
    if not text.strip() or _temperature(text) is not None:
        return ""
    return f"{text}: expected a temperature from {-_HOTTEST_C:g} to {_HOTTEST_C:g} °C"


def _temperature(text: str) -> float | None:
    try:
        value = float(text.replace(",", "."))
    except ValueError:
        return None
    return value if abs(value) <= _HOTTEST_C else None


def ranked_conditions(analysis: Analysis, ranking: Ranking | None) -> list[tuple[Condition, float]]:
    """Rank all conditions by the share of the residual's variance that each explains, largest
    first.

    With a ranking, the shares are those of the ranking; without a ranking, each share is computed
    and reduced by the share that independent noise would explain.
    """
    shares: dict[str, float] = {}
    for key, condition in analysis.conditions.items():
        if ranking is not None and ranking["regressors"]:
            names = {condition.name, key}
            shares_of_condition = [
                r["share"] for r in ranking["regressors"] if r["condition"] in names
            ]
            shares[key] = max(shares_of_condition, default=0.0)
        else:
            shares[key] = max(
                share_of_variance(condition, values, analysis.left(channel))
                for channel, values in condition.values.items()
            )
    found = [(analysis.conditions[key], share) for key, share in shares.items()]
    return sorted(found, key=lambda item: -item[1])


def chart_of(
    name: str, analysis: Analysis, ranking: Ranking | None, display: DisplaySettings
) -> Chart | None:
    """Make the chart with this name (one of :data:`FIGURES`) in the reader's unit.

    Returns None if there is nothing to draw yet. Raises KeyError for another name.
    """
    if name not in FIGURES:
        raise KeyError(name)
    found = _chart(name, analysis, ranking, display)
    return None if found is None or not found.panels else in_unit(found, display.unit)


def _chart(
    name: str, analysis: Analysis, ranking: Ranking | None, display: DisplaySettings
) -> Chart | None:
    if name == "measurement_and_model":
        return measurement_and_model(analysis, whitened=display.whitened)
    if name == "residual_against":
        condition = analysis.conditions.get(display.against)
        if condition is None:
            condition = ranked_conditions(analysis, ranking)[0][0]
        return residual_against(analysis, condition)
    if name == "branches":
        return branches(analysis.residuals, floor_of(analysis.model.history))
    if name == "spectrum":
        return spectrum(analysis.residuals, display.along)
    if name == "heat_map":
        return heat_map(analysis)
    if name == "ladder":
        return ladder(analysis.model.history)
    if ranking is None:
        return None
    if name == "finding":
        if ranking["finding"] is None:
            return None
        found = effect_amplitude_from(ranking["finding"])
        over = display.finding if found.over(display.finding) else found.best
        return effect_amplitude_chart(found, over) if over else None
    device = ranking["device"]
    if device is None or "refused" in device or not device["orders"]:
        return None
    return lanes_chart(device["orders"], device["amplitudes_arcsec"], device["at_reference"])
