"""A diagnosis as JSON (schema 1) and as sentences."""

from __future__ import annotations

from typing import Any

from arctrue.workbench.diagnose.candidate import Candidate
from arctrue.workbench.diagnose.diagnosis import Diagnosis
from arctrue.workbench.diagnose.heldout import HeldOut
from arctrue.workbench.effects.base import Parameter
from arctrue.workbench.inference.residuals import Residuals
from arctrue.workbench.inference.solution import Solution


def parameter_data(parameters: dict[str, Parameter]) -> dict[str, Any]:
    """Parameters as JSON."""
    return {
        name: {"value": item.value, "sigma": item.sigma, "unit": item.unit}
        for name, item in parameters.items()
    }


def rms_data(solution: Solution) -> dict[str, float]:
    """RMS of the residuals by channel."""
    residuals = Residuals(solution)
    found = {}
    for channel, values in (
        ("capture", residuals.capture_arcsec),
        ("reference", residuals.reference_arcsec),
    ):
        if values is not None:
            found[channel] = float((values @ values / max(values.size, 1)) ** 0.5)
    return found


def held_out_data(held_out: HeldOut | None) -> dict[str, float]:
    """Held-out RMS by channel."""
    if held_out is None:
        return {}
    values = {
        "capture": held_out.capture_rms_arcsec,
        "reference": held_out.reference_rms_arcsec,
    }
    return {channel: value for channel, value in values.items() if value is not None}


def candidate_data(
    item: Candidate, before: dict[str, float], held_out_before: HeldOut | None
) -> dict[str, Any]:
    """One candidate as JSON."""
    return {
        "effect": item.name,
        "p_corrected": item.p_corrected,
        "delta_bic": item.delta_bic,
        "size_arcsec": item.size_arcsec,
        "rms_before_arcsec": before,
        "rms_after_arcsec": rms_data(item.solution),
        "heldout_before_arcsec": held_out_data(held_out_before),
        "heldout_after_arcsec": held_out_data(item.held_out),
        "heldout_se_arcsec": {
            channel: fall.standard_error_arcsec for channel, fall in item.improvement.items()
        },
        "parameters": parameter_data(item.parameters()),
        "lacking_variety": item.lacking_variety,
    }


def diagnosis_data(result: Diagnosis, model: list[str]) -> dict[str, Any]:
    """The whole diagnosis as JSON, schema 1."""
    parts = [] if result.described is None else result.described.effect.parts  # type: ignore[attr-defined]
    return {
        "schema": 1,
        "model": model,
        "noise_arcsec": result.noise_arcsec,
        "residual_rms_arcsec": result.residual_rms_arcsec,
        "lack_of_fit": {
            channel: {"p_value": value} for channel, value in result.lack_of_fit.items()
        },
        "verdict": result.verdict,
        "named": None if result.named is None else result.named.name,
        "class": result.effect_class,
        "class_correlation": result.class_correlation,
        "description": result.description,
        "parts": parts,
        "next_measurement": result.next_measurement,
        "next_measurement_kind": result.next_measurement_kind,
        "data_faults": result.faults,
        "masked": [row.data() for row in result.observations.masked],
        "negligible": [item.name for item in result.negligible],
        "beside": [item.name for item in result.beside],
        "cannot_be_tested": result.untestable,
        "candidates": [
            candidate_data(item, result.residual_rms_arcsec, result.held_out_before)
            for item in result.candidates
        ],
    }


def sentences(result: Diagnosis) -> list[str]:
    """The verdict in words, and what to do next."""
    if result.verdict == "bad_data":
        return ["The data themselves are faulty:", *result.faults]
    if result.verdict == "cannot_tell":
        return [
            "This set cannot tell: its rows are too few beside the coefficients to show noise.",
            f"Next measurement: {result.next_measurement}.",
        ]
    if result.verdict == "adequate":
        said = ["The model is adequate: no known effect, and no product of parts, adds anything."]
    elif result.verdict == "named" and result.named is not None:
        said = [f"Missing: {result.named.name}. {result.named.effect.physics}"]
        if len(result.effect_class) > 1:
            larger = ", ".join(result.effect_class[1:])
            said.append(f"Larger effects would explain it too, with more freedom: {larger}.")
        said.append(_compensation(result.named))
        if result.beside:
            said.append(
                f"It is not all: beside it {result.beside[0].name} takes more still. Add "
                f"{result.named.name} and diagnose again."
            )
    elif result.verdict == "ambiguous":
        said = _undecided(result)
    elif result.description is None:
        said = [
            "The model does not fit, and neither an effect nor a product of parts describes what "
            "is left: see the maps of arctrue compare."
        ]
    else:
        said = [f"None of the known effects fits. Best description: {result.description}."]
    if result.next_measurement:
        said.append(f"Next measurement: {result.next_measurement}.")
    if result.negligible:
        names = ", ".join(item.name for item in result.negligible)
        said.append(f"Significant but too small to matter: {names}.")
    return said


def _undecided(result: Diagnosis) -> list[str]:
    first = result.effect_class[0]
    if len(result.effect_class) > 1:
        said = [f"This data cannot tell between: {', '.join(result.effect_class)}."]
    elif result.unconfirmed is not None:
        said = [f"{first} fits best, but this data is not enough to name it: {result.unconfirmed}."]
    else:
        said = [f"{first} fits best, but this data is not enough to name it."]
    if result.description is not None:
        said.append(f"It may as well be this, which is in no catalogue: {result.description}.")
    return said


def _compensation(item: Candidate) -> str:
    words = {
        "lanes": "The gateware can compensate it with lanes",
        "offset": "The gateware can compensate it with its offset",
        "none": "The gateware cannot compensate it",
    }[item.effect.compensation]
    note = item.effect.compensation_note
    return f"{words}: {note}." if note else f"{words}."
