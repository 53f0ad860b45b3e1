"""Runs the workbench on a measurement set; only the folder of the set is its input."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from arctrue.measurement import read_measurement_set
from arctrue.workbench.diagnose.adopted import adopt
from arctrue.workbench.diagnose.diagnosis import Diagnosis, diagnose
from arctrue.workbench.diagnose.report import sentences
from arctrue.workbench.diagnose.report_json import diagnosis_data
from arctrue.workbench.effects.base import Effect
from arctrue.workbench.effects.product_of_parts import ProductOfParts
from arctrue.workbench.effects.registry import catalogue
from arctrue.workbench.inference.residuals import Residuals
from arctrue.workbench.model.export import Export, export_model
from arctrue.workbench.model.followed_lanes import ConditionSettings
from arctrue.workbench.model.growth import add_effect, as_stored, fitted, settle, step_of
from arctrue.workbench.model.model import HistoryStep, Model, default_model
from arctrue.workbench.observations import Observations
from arctrue.workbench.observations.build import observations_of


@dataclass(frozen=True)
class DiagnosedModel:
    """Result of the workbench for a measurement set."""

    observations: Observations
    diagnosis: Diagnosis
    effect: str | None
    """Name of the effect that the last step added; None if this step could add no effect."""
    effect_file: Path | None
    """File that defines the added effect, if the catalogue does not contain it."""
    before: Model
    """Fitted model without the effect: the paper's model."""
    model: Model
    """Fitted model with the effect."""
    effects: Mapping[str, type[Effect]]

    @property
    def ladder(self) -> list[HistoryStep]:
        """Return the history of the model, which shows how the error on this set fell step by
        step."""
        return list(self.model.history)

    def export(
        self,
        lanes: int,
        temperature_c: float | None,
        sensor_time_constant_s: float = 0.0,
        *,
        conditions: ConditionSettings | None = None,
        with_local_table: bool = False,
        with_real_orders: bool = False,
    ) -> Export:
        """Return the model as coefficients of the gateware, and the effects that lanes cannot
        correct."""
        return export_model(
            self.model,
            self.observations,
            self.effects,
            lanes=lanes,
            temperature_c=temperature_c,
            sensor_time_constant_s=sensor_time_constant_s,
            conditions=conditions,
            with_local_table=with_local_table,
            with_real_orders=with_real_orders,
        )

    def data(self) -> dict[str, Any]:
        """Return the data of the diagnosis, as ``arctrue diagnose --json`` prints them."""
        return diagnosis_data(self.diagnosis, self.before.names())

    def words(self) -> list[str]:
        """Return the verdict of the diagnosis in sentences."""
        return sentences(self.diagnosis)


def diagnose_and_add(
    folder: Path,
    *,
    adopted_name: str,
    effects_folder: Path,
    effects_to_add: int = 1,
    added: tuple[str, Mapping[str, object]] | None = None,
) -> DiagnosedModel:
    """Run ``arctrue diagnose`` and ``arctrue add``, with ``--adopt`` if the diagnosis cannot name
    the effect.

    Both commands run once for each effect to add, until a diagnosis gives no effect to add; the
    result contains the last diagnosis.
    ``added``: name and settings of an effect that is added in place of the diagnosed one.
    """
    measurement = read_measurement_set(folder)
    observations = observations_of(measurement)
    effects = catalogue()
    title = measurement.title or folder.name
    before, solution = fitted(default_model(), observations, effects)
    model = dataclasses.replace(
        before, history=[step_of("fit", ", ".join(before.names()), title, solution)]
    )
    for number in range(effects_to_add):
        found = diagnose(observations, settle(model, observations, effects), effects)
        name, settings, file = None, {}, None
        if added is not None:
            name, settings = added[0], dict(added[1])
        elif found.named is not None:
            name = found.named.name
            usual = dict(effects[name].defaults)
            settings = {
                key: value
                for key, value in found.named.effect.settings.items()
                if value != usual.get(key)
            }
        elif found.described is not None and isinstance(found.described.effect, ProductOfParts):
            name = f"{adopted_name}_{number + 1}" if number else adopted_name
            file = adopt(found.described.effect, name, found.description or "", effects_folder)
            effects = catalogue([effects_folder])
        if name is None:
            break
        model, _ = add_effect(model, name, settings, observations, effects, title)
    return DiagnosedModel(observations, found, name, file, before, model, effects)


def left_on_fresh_set(diagnosed: DiagnosedModel, folder: Path) -> dict[str, float]:
    """Return the RMS, in arcseconds, of the residuals in another set's capture, without a new fit.

    The model before the effect was added and the model with it are both evaluated, as by ``arctrue
    compare --no-fit``.
    """
    observations = observations_of(
        read_measurement_set(folder),
        reference_temperature_c=diagnosed.model.reference_temperature_c,
    )
    left = {}
    for name, model in (("without", diagnosed.before), ("with", diagnosed.model)):
        solution = as_stored(model, observations, diagnosed.effects)
        residual = Residuals(solution).capture_arcsec
        assert residual is not None
        left[name] = float(np.sqrt(np.mean(residual**2)))
    return left
