"""Makes all charts of ``arctrue compare``, each with the name of its file."""

from __future__ import annotations

from arctrue.report.charts.branches import branches
from arctrue.report.charts.chart import Chart
from arctrue.report.charts.residual_maps import residual_findings_chart, residual_maps_chart
from arctrue.report.charts.spectrum import all_spectra
from arctrue.report.charts.whitened import whitened
from arctrue.workbench.compare.comparison import ModelComparison
from arctrue.workbench.inference.residuals import Residuals
from arctrue.workbench.inference.solution import Solution


def comparison_charts(solution: Solution, comparison: ModelComparison) -> dict[str, Chart]:
    """Draw the residuals by run and direction, the findings (if there are any), the maps and the
    spectra of the residuals, and the whitened residuals."""
    residuals = Residuals(solution)
    noise_arcsec = {name: item.noise_arcsec for name, item in comparison.channels.items()}
    found = {"residual_branches": branches(residuals, noise_arcsec)}
    if comparison.findings:
        found["residual_findings"] = residual_findings_chart(comparison.findings)
    return {
        **found,
        "residual_maps": residual_maps_chart(comparison.maps),
        "residual_lines": all_spectra(residuals),
        "residual_whitened": whitened(residuals),
    }
