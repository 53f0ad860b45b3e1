"""Writes a diagnosis as JSON (schema 2)."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from arctrue.workbench.diagnose.aliases import aliases
from arctrue.workbench.diagnose.candidate import Candidate
from arctrue.workbench.diagnose.coverage import Coverage
from arctrue.workbench.diagnose.diagnosis import Diagnosis
from arctrue.workbench.diagnose.remaining_error import RemainingError
from arctrue.workbench.effects.base import Parameter
from arctrue.workbench.inference.left import Left
from arctrue.workbench.inference.residuals import Residuals
from arctrue.workbench.noise.whiteness import noise_data


def parameter_data(parameters: dict[str, Parameter]) -> dict[str, Any]:
    """Return fitted parameters as JSON."""
    return {
        name: {"value": item.value, "sigma": item.sigma, "unit": item.unit}
        for name, item in parameters.items()
    }


def candidate_data(item: Candidate, before: Left | None, after: Left | None) -> dict[str, Any]:
    """Return one candidate as JSON; ``after`` is None for a candidate that was not added to the
    model."""
    fall = {} if before is None or after is None else after.fall_from(before)
    return {
        "effect": item.name,
        "p_corrected": item.p_corrected,
        "delta_bic": item.delta_bic,
        "size_arcsec": item.size_arcsec,
        "rms_before_arcsec": {} if before is None else dict(before.rms_arcsec),
        "rms_after_arcsec": {} if after is None else dict(after.rms_arcsec),
        "heldout_before_arcsec": {} if before is None else dict(before.heldout_rms_arcsec),
        "heldout_after_arcsec": {} if after is None else dict(after.heldout_rms_arcsec),
        "heldout_se_arcsec": {channel: one.standard_error_arcsec for channel, one in fall.items()},
        "parameters": parameter_data(item.parameters()),
        "lacking_variety": item.lacking_variety,
        "share_of_blocks": None if item.share is None else item.share.share,
    }


def covers_data(covers: Coverage) -> dict[str, Any]:
    """Return the coverage as JSON: sizes of effects that the verdict excludes, effects that cannot
    be tested, and blind orders."""
    return {
        "smallest": {
            name: {
                "rms_arcsec": item.rms_arcsec,
                "size": None
                if item.size is None
                else {"value": item.size.value, "unit": item.size.unit},
            }
            for name, item in covers.smallest.items()
        },
        "cannot_be_tested": covers.untestable,
        "blind_orders": covers.blind_orders,
    }


def _noise_data(result: Diagnosis) -> dict[str, Any]:
    """Return the noise of the model with the named or described effect, as JSON.

    Without the effect in the model, the noise would contain it.
    """
    found = result.named or result.described
    solution = result.base if found is None else found.solution
    if solution is None:
        return {}
    residuals = Residuals(solution)
    tests = residuals.capture_whiteness, residuals.reference_whiteness
    data = noise_data(solution.noise, tests)
    rows = result.observations.capture
    if rows is not None and rows.head_noise is not None and rows.head_noise.sigmas_arcsec:
        data["heads_arcsec"] = list(rows.head_noise.sigmas_arcsec)
    return data


def _detections_data(result: Diagnosis) -> dict[str, Any]:
    """Return the detections in the reference as JSON, with the damped oscillation of the decision
    if it has one."""
    found, seen = result.detections, result.decision.oscillation
    return found.data() if seen is None else replace(found, oscillation=seen).data()


def _second_data(found: RemainingError | None) -> dict[str, Any] | None:
    """Return the error that remains with the named effect in the model, as JSON."""
    if found is None:
        return None
    return {
        "left_arcsec": dict(found.left_arcsec),
        "differs_from_place_to_place_in": found.channel,
        "variation": found.variation if found.channel is not None else None,
        "description": found.description,
    }


def diagnosis_data(result: Diagnosis, model: list[str]) -> dict[str, Any]:
    """Return the whole diagnosis as JSON, schema 2."""
    parts = [] if result.described is None else result.described.effect.parts
    said = result.decision
    before = result.before
    return {
        "schema": 2,
        "model": model,
        "noise_arcsec": {} if before is None else dict(before.noise_arcsec),
        "residual_rms_arcsec": {} if before is None else dict(before.rms_arcsec),
        "lack_of_fit": {
            channel: {"p_value": item.lack_of_fit_p}
            for channel, item in result.channels.items()
            if item.lack_of_fit_p is not None
        },
        "verdict": result.verdict,
        "named": None if result.named is None else result.named.name,
        "aliases": with_aliases(result)[1],
        "class": result.effect_class,
        "class_correlation": dict(said.class_correlation),
        "description": result.description,
        "lag_s": None if result.lag is None else result.lag.time_constant_s,
        "parts": parts,
        "resembles": None if said.resembles is None else said.resembles.name,
        "unlike": said.unlike,
        "next_measurement": result.next_measurement,
        "next_measurement_kind": result.next_measurement_kind,
        "data_faults": list(said.faults),
        "probability": dict(result.probability),
        "unlike_benchmark": list(result.unlike),
        "covers": covers_data(result.covers),
        "noise": _noise_data(result),
        "cannot_tell": said.cannot_tell,
        "look_alikes": dict(said.look_alikes),
        "masked": [row.data() for row in result.observations.masked],
        "negligible": [item.name for item in result.negligible],
        "findings": _detections_data(result),
        "index_scatter_arcsec": None
        if result.index_scatter is None
        else result.index_scatter.rms_arcsec,
        "further": [item.name for item in result.further],
        # This entry is the former name of "further", kept for one release.
        "beside": [item.name for item in result.further],
        "second_finding": _second_data(result.second),
        "cannot_be_tested": dict(result.untestable),
        "candidates": [
            candidate_data(item, before, result.left.get(item.name)) for item in result.candidates
        ],
    }


def with_aliases(result: Diagnosis) -> tuple[Candidate | None, list[float]]:
    """Return the first effect of the class whose order has aliases, and these aliases."""
    first = result.decision.first
    others = [] if first is None else result.candidates
    names = set(result.effect_class)
    for item in [first, *others]:
        if item is None or (item is not first and item.name not in names):
            continue
        if found := aliases(item, result.observations):
            return item, found
    return None, []
