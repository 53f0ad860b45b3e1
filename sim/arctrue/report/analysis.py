"""Combines a measurement set with a fitted model for the page and the report."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from arctrue.measurement import MeasurementSet
from arctrue.workbench.effects.base import Effect
from arctrue.workbench.inference.residuals import Residuals
from arctrue.workbench.inference.solution import Solution
from arctrue.workbench.model.growth import add_effect, drop_effect, fitted, step_of
from arctrue.workbench.model.model import Model
from arctrue.workbench.observations import CaptureRows, Observations, ReferenceRows
from arctrue.workbench.observations.build import observations_of

Float = NDArray[np.float64]
CHANNELS = ("capture", "reference")

NAMES = {
    "angle": "angle of the table",
    "electrical1": "electrical phase of head 1",
    "electrical2": "electrical phase of head 2",
}
OWN_PHASE = "own_phase"
"""Key of the condition that is the phase within a period of the effect's own order or frequency."""
ROUND = ("angle", "electrical1", "electrical2", OWN_PHASE)
"""Keys of the conditions that are angles with a period, in radians."""
UNITS = {"speed": "deg/s", "time": "s", "temperature": "°C"}


@dataclass(frozen=True)
class Condition:
    """A quantity over which a residual can be drawn; ``values`` contains an array (rows,) for each
    channel."""

    key: str
    name: str
    unit: str
    values: Mapping[str, Float]

    @property
    def goes_round(self) -> bool:
        """Whether the condition is an angle with a period, in radians."""
        return self.key in ROUND


@dataclass(frozen=True)
class Analysis:
    """A measurement set with a model that was fitted to it."""

    measurement: MeasurementSet
    title: str
    observations: Observations
    model: Model
    solution: Solution
    effects: Mapping[str, type[Effect]]

    @cached_property
    def residuals(self) -> Residuals:
        """Residuals of the fitted model."""
        return Residuals(self.solution)

    def rows(self, channel: str) -> CaptureRows | ReferenceRows:
        """Return the rows of a measured channel with their conditions."""
        found = self.observations.capture if channel == "capture" else self.observations.reference
        assert found is not None
        return found

    def left(self, channel: str, *, whitened: bool = False) -> Float:
        """Return the residual of every row in arcseconds, or whitened to a standard deviation of
        1."""
        residuals = self.residuals
        found = {
            ("capture", False): lambda: residuals.capture_arcsec,
            ("capture", True): lambda: residuals.capture_whitened,
            ("reference", False): lambda: residuals.reference_arcsec,
            ("reference", True): lambda: residuals.reference_whitened,
        }[channel, whitened]()
        assert found is not None
        return found

    def measured(self, channel: str) -> Float:
        """Return R₂ − R₁ − α of every capture row, or ε of every reference row, in arcseconds."""
        rows = self.rows(channel)
        return rows.difference_arcsec if isinstance(rows, CaptureRows) else rows.error_arcsec

    def angle_rad(self, channel: str) -> Float:
        """Return the table's angle in every row; in a row of the reference, this is the target
        angle."""
        rows = self.rows(channel)
        return rows.angle_rad if isinstance(rows, CaptureRows) else rows.target_rad

    @cached_property
    def conditions(self) -> dict[str, Condition]:
        """All angles, and all other quantities that vary in the set, by key."""
        found: dict[str, dict[str, Float]] = {}
        for channel in self.observations.channels:
            for key, values in _conditions_of(self.rows(channel)).items():
                if key in ROUND or float(np.ptp(values)) > 0.0:
                    found.setdefault(key, {})[channel] = values
        return {
            key: Condition(key, NAMES.get(key, key.replace("_", " ")), _unit(key), values)
            for key, values in found.items()
        }


def _unit(key: str) -> str:
    return "deg" if key in ROUND else UNITS.get(key, "1")


def _conditions_of(rows: CaptureRows | ReferenceRows) -> dict[str, Float]:
    angle = rows.angle_rad if isinstance(rows, CaptureRows) else rows.target_rad
    speed = rows.speed_rad_s
    found: dict[str, Float | None] = {
        "angle": angle,
        "temperature": rows.temperature_c,
        "time": rows.time_s,
        "speed": None
        if speed is None
        else np.asarray(np.round(np.degrees(speed), 2), dtype=np.float64),
        "direction": rows.direction,
        "run": rows.run.astype(np.float64),
        "electrical1": rows.electrical1_rad,
    }
    if isinstance(rows, CaptureRows):
        found["run"] = (rows.run // rows.channels).astype(np.float64)
        if rows.channel is not None:
            found["head"] = (rows.channel + 2).astype(np.float64)
        found["revolution"] = (rows.revolution // rows.channels).astype(np.float64)
        found["electrical2"] = rows.electrical2_rad
    elif rows.cycle is not None:
        found["cycle"] = rows.cycle.astype(np.float64)
    found |= {name: values for name, values in rows.conditions.items() if name not in found}
    return {key: values for key, values in found.items() if values is not None and values.size}


def analyse(
    measurement: MeasurementSet,
    title: str,
    model: Model,
    effects: Mapping[str, type[Effect]],
    observations: Observations | None = None,
) -> Analysis:
    """Fit the model to the set; the model gets a first history entry if it has none.

    ``observations``: the rows of the set, if the caller has computed them already. Raises
    NotTestableError, ValueError for a model that the set cannot test.
    """
    if observations is None:
        observations = observations_of(
            measurement, reference_temperature_c=model.reference_temperature_c
        )
    grown, solution = fitted(model, observations, effects)
    if not grown.history:
        step = step_of("fit", ", ".join(grown.names()), title, solution)
        grown = replace(grown, history=[step])
    return Analysis(measurement, title, observations, grown, solution, effects)


def with_effect(before: Analysis, name: str, settings: dict[str, object]) -> Analysis:
    """Add one effect to the model and fit it. Raises the errors of ``add_effect``."""
    grown, solution = add_effect(
        before.model, name, settings, before.observations, before.effects, before.title
    )
    return replace(before, model=grown, solution=solution)


def without_effect(before: Analysis, name: str) -> Analysis:
    """Drop one effect of the model and fit the others. Raises the errors of ``drop_effect``."""
    shrunk, solution = drop_effect(
        before.model, name, before.observations, before.effects, before.title
    )
    return replace(before, model=shrunk, solution=solution)
