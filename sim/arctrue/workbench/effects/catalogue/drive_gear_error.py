"""The worm or the gear that drives the table."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from arctrue.workbench.effects.base import (
    Columns,
    Effect,
    FitContext,
    Lane,
    Nonlinear,
    Parameter,
    amplitude_and_phase,
    paired_lanes,
)
from arctrue.workbench.effects.harmonics import harmonic_columns, harmonic_names
from arctrue.workbench.observations import Observations, ReferenceRows

if TYPE_CHECKING:
    from arctrue.workbench.inference.residuals import Residuals

HIGHEST_MULTIPLE = 3


class DriveGearError(Effect):
    """cos, sin of the tooth count and its multiple, in the reference run only."""

    name = "drive_gear_error"
    physics = (
        "Each turn of the worm or each tooth of the gear repeats its own error, so the table "
        "follows with as many periods a turn as the wheel has teeth. The disc on the axis does not "
        "move against its heads, so the two heads do not see it."
    )
    equation = "ε = Σ c cos(kGθ) + s sin(kGθ), G teeth (drive_gear_teeth, any number above 0)"
    source = "ISO 1328, periodic error of a gear"
    capture_sees = "nothing when the disc sits on the axis"
    reference_sees = "order G; an alias at G mod faces on a polygon"
    told_apart_by = "the order is the tooth count"
    next_measurement = "reference stations closer than half a tooth"
    plausible = "0.5 to 30″"
    parameter_units = {"multiple_K_amplitude": "arcsec", "multiple_K_phase": "deg"}
    compensation = "lanes"
    compensation_note = (
        "lanes at the tooth count, when it is whole and the reference run has given its size"
    )
    defaults = {"multiples": [1]}

    def missing(self, observations: Observations) -> list[str]:
        lacking = []
        if observations.drive_gear_teeth is None:
            lacking.append("the key table.drive_gear_teeth")
        if observations.reference is None:
            lacking.append("a reference run")
        return lacking

    def column_names(self, observations: Observations) -> list[str]:
        return harmonic_names(self.integers("multiples"), "tooth ")

    def reference_columns(
        self, rows: ReferenceRows, nonlinear: Nonlinear, context: FitContext
    ) -> Columns | None:
        if rows.teeth is None:
            return None
        return harmonic_columns(rows.angle_rad * rows.teeth, self.integers("multiples"))

    def narrowed(self, residuals: Residuals) -> tuple[Effect, float]:
        """With further multiples of the tooth count, if they are worth their columns."""
        reference = residuals.observations.reference
        worth = 2.0 * float(np.log(max(2, 0 if reference is None else reference.run.size)))
        kept = self.integers("multiples")
        gain = residuals.score(self, {}).gain
        for multiple in range(1, HIGHEST_MULTIPLE + 1):
            if multiple in kept:
                continue
            more = tuple(sorted((*kept, multiple)))
            larger = residuals.score(DriveGearError(multiples=list(more)), {}).gain
            if larger > gain + worth:
                kept, gain = more, larger
        if kept == self.integers("multiples"):
            return self, 1.0
        return DriveGearError(multiples=list(kept)), float(2**HIGHEST_MULTIPLE)

    def lanes(
        self,
        coefficients: NDArray[np.float64],
        nonlinear: Nonlinear,
        observations: Observations,
        temperature_c: float | None,
    ) -> list[Lane]:
        teeth = observations.drive_gear_teeth
        assert teeth is not None
        if teeth != round(teeth):
            return []
        return paired_lanes([round(teeth) * k for k in self.integers("multiples")], coefficients)

    def parameters(
        self,
        coefficients: NDArray[np.float64],
        covariance: NDArray[np.float64],
        nonlinear: Nonlinear,
        observations: Observations,
    ) -> dict[str, Parameter]:
        found: dict[str, Parameter] = {}
        for index, multiple in enumerate(self.integers("multiples")):
            pair = slice(2 * index, 2 * index + 2)
            cosine, sine = coefficients[pair]
            found |= amplitude_and_phase(
                cosine, sine, covariance[pair, pair], f"multiple_{multiple}_"
            )
        return found
