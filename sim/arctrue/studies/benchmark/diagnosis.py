"""Runs the diagnosis of this project as a subject of the benchmark (a program whose answers are
scored)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any

from arctrue.measurement import MeasurementSet, read_measurement_set
from arctrue.studies.benchmark.subject import Answer
from arctrue.workbench.diagnose.diagnosis import MATTERS_COUNTS, Diagnosis, diagnose
from arctrue.workbench.diagnose.report_json import diagnosis_data
from arctrue.workbench.effects.registry import catalogue
from arctrue.workbench.model.growth import settle
from arctrue.workbench.model.model import default_model
from arctrue.workbench.observations import Observations
from arctrue.workbench.observations.build import observations_of


def diagnosed(
    measurement: MeasurementSet, matters_counts: float = MATTERS_COUNTS
) -> tuple[Observations, Diagnosis]:
    """Return the rows of a set, and their diagnosis under the default model."""
    observations = observations_of(measurement)
    effects = catalogue([])
    terms = settle(default_model(), observations, effects)
    return observations, diagnose(observations, terms, effects, matters_counts=matters_counts)


def arctrue(folder: Path) -> Answer:
    """Diagnose the set in ``folder`` and return the answer; nothing else is read."""
    _, found = diagnosed(read_measurement_set(folder))
    answer = answer_of(diagnosis_data(found, default_model().names()))
    grounds = None if found.grounds is None else asdict(found.grounds)
    return answer | {"grounds": grounds}


def answer_of(data: Mapping[str, Any]) -> Answer:
    """Return the keys that the benchmark scores from the output of ``diagnose --json`` (schema 1 or
    2)."""
    candidates = list(data.get("candidates", []))
    first = next((item for item in candidates if item["effect"] == data.get("named")), None)
    before = candidates[0]["heldout_before_arcsec"] if candidates else {}
    probability = data.get("probability")
    oscillation = (data.get("findings") or {}).get("oscillation")
    return {
        "verdict": data["verdict"],
        "named": data.get("named"),
        "class": list(data.get("class") or []),
        "parts": list(data.get("parts") or []),
        "further": list(data.get("further") or []),
        "probability": None
        if probability is None
        else {name: round(float(value), 6) for name, value in probability.items()},
        "parameters": None
        if first is None
        else _rounded({name: item["value"] for name, item in first.get("parameters", {}).items()}),
        "oscillation_hz": None
        if oscillation is None
        else float(f"{oscillation['frequency_hz']:.7g}"),
        "held_out_arcsec": _rounded(first["heldout_after_arcsec"] if first else before),
    }


def _rounded(values: Mapping[str, float]) -> dict[str, float]:
    # Round to seven digits, because the last bits of a sum may differ between processors.
    return {name: float(f"{value:.7g}") for name, value in values.items()}
