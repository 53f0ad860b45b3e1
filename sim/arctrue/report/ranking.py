"""Computes the slow part of an analysis: missing effects, misfit by condition, and coefficients for
a device.

For the page, a separate process does this computation; for a report, the program does it before it
writes the report. The result is JSON.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict
from typing import Any

from arctrue.base.progress import ReportStep
from arctrue.calibration.calibration import at_the_temperature_of, objections
from arctrue.calibration.comparison import compare as compare_with_reference
from arctrue.gateware.coefficient_file_text import coefficient_file_text
from arctrue.generated.number_formats import LANES_DEFAULT
from arctrue.report.analysis import Analysis
from arctrue.report.effect_amplitude import AmplitudeCurve, EffectAmplitude, effect_amplitude
from arctrue.workbench.compare.comparison import compare
from arctrue.workbench.diagnose.diagnosis import Diagnosis, diagnose
from arctrue.workbench.diagnose.report import sentences
from arctrue.workbench.diagnose.report_json import diagnosis_data
from arctrue.workbench.model.export import export_model

Ranking = dict[str, Any]
"""Result of a ranking, with the keys ``diagnosis`` (schema 2), ``sentences``, ``finding``,
``findings``, ``regressors`` and ``device``."""

SEED = 1
"""Seed of the random draws that give the share of the residual which chance alone explains;
``arctrue compare`` uses the same seed by default."""


def ranked(
    analysis: Analysis,
    report_step: ReportStep = lambda text: None,
    partly: Callable[[Ranking], None] = lambda found: None,
    *,
    seed: int = SEED,
) -> Ranking:
    """Rank missing effects and conditions, and compute the lanes for a device; ``partly`` receives
    the diagnosis before the other parts are computed."""
    result = diagnose(
        analysis.observations,
        list(analysis.solution.terms),
        analysis.effects,
        report_step=report_step,
    )
    found: Ranking = {
        "diagnosis": diagnosis_data(result, analysis.model.names()),
        "sentences": sentences(result),
        "finding": _finding(analysis, result),
        "findings": [],
        "regressors": [],
        "device": None,
    }
    partly(found)
    report_step("comparing the residual with the conditions")
    compared = compare(analysis.solution, seed)
    found["findings"] = [asdict(item) for item in compared.findings]
    found["regressors"] = [
        {"channel": item.channel, "condition": item.condition, "share": item.excess_share}
        for item in compared.maps
    ]
    report_step("computing the coefficients of the gateware")
    found["device"] = device_data(analysis)
    return found


def _finding(analysis: Analysis, result: Diagnosis) -> dict[str, Any] | None:
    """Compute the amplitude curve of one effect: the effect that the diagnosis names or describes,
    otherwise the first effect of the class, otherwise the effect added last."""
    first = result.named or result.described
    if first is None and result.effect_class:
        first = next(
            (item for item in result.candidates if item.name == result.effect_class[0]), None
        )
    after = None if first is None else result.left.get(first.name)
    solution = analysis.solution if first is None else first.solution
    if after is not None:
        # The effect is fitted in the same way as by the button Add, so that the page's figures
        # agree with the result of Add.
        solution = after.solution
    if first is None and len(solution.terms) < 2:
        return None
    found = effect_amplitude(analysis, solution)
    return {
        "effect": found.effect,
        "added": first is None,
        "best": found.best,
        "shown": [item.data() for item in found.shown],
    }


def effect_amplitude_from(data: dict[str, Any]) -> EffectAmplitude:
    """Return the effect amplitude that was stored as JSON in a ranking."""
    return EffectAmplitude(
        data["effect"], [AmplitudeCurve.of_data(item) for item in data["shown"]], data["best"]
    )


def device_data(analysis: Analysis, temperature_c: float | None = None) -> dict[str, Any]:
    """Return the lanes, the remaining error, the objections and the coefficient file for the
    device, or the reason why there is no file.

    Effects that depend on the temperature are evaluated at ``temperature_c``; without it, the lanes
    of these effects follow the table's thermometer.
    """
    has_temperature = analysis.observations.has_temperature
    try:
        export = export_model(
            analysis.model,
            analysis.observations,
            analysis.effects,
            lanes=LANES_DEFAULT,
            temperature_c=temperature_c,
        )
    except ValueError as error:
        return {
            "refused": str(error),
            "temperature_c": temperature_c,
            "has_temperature": has_temperature,
        }
    reference = analysis.measurement.reference
    at_reference = None
    if reference is not None:
        if reference.mask is not None:
            reference = reference.where(~reference.mask)
        applied = at_the_temperature_of(analysis.measurement, export.coefficients)
        seen = compare_with_reference(reference, applied)
        at_reference = [
            seen.target_deg.tolist(),
            seen.before_arcsec.tolist(),
            seen.after_arcsec.tolist(),
        ]
    return {
        "temperature_c": temperature_c,
        "has_temperature": has_temperature,
        "follows": export.coefficients.thermal is not None,
        "orders": export.orders,
        "amplitudes_arcsec": export.amplitudes_arcsec,
        "lanes": LANES_DEFAULT,
        "left_out": export.left_out,
        "warnings": export.warnings,
        "objections": objections(analysis.measurement, export.coefficients),
        "at_reference": at_reference,
        "file": coefficient_file_text(export.coefficients, title=analysis.title),
    }
