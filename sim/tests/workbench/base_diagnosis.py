"""Diagnoses a set with only the paper's model."""

from __future__ import annotations

from arctrue.measurement import MeasurementSet
from arctrue.workbench.diagnose.diagnosis import Diagnosis, diagnose
from arctrue.workbench.effects.registry import built_in
from arctrue.workbench.inference.design_matrix import Term
from arctrue.workbench.observations.build import observations_of


def diagnosis_of(measurement: MeasurementSet) -> Diagnosis:
    effects = built_in()
    base = [Term(effects["graduation_harmonics"](), {})]
    return diagnose(observations_of(measurement), base, effects)
