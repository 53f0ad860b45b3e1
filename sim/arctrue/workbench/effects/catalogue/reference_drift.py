"""The stand of the reference or the autocollimator creeps."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from arctrue.workbench.effects.base import Columns, Effect, FitContext, Nonlinear, Parameter
from arctrue.workbench.observations import Observations, ReferenceRows


class ReferenceDrift(Effect):
    """Adds a polynomial in time to the reference rows."""

    name = "reference_drift"
    physics = (
        "The stand of the autocollimator or its electronics creeps during the run. All stations "
        "shift together, by an amount that grows with time."
    )
    equation = "ε = Σ r_j·tʲ, t from the middle of the run; reference only"
    source = "drift of an instrument; EURAMET cg-19"
    capture_sees = "nothing"
    reference_sees = "an error that grows from cycle to cycle"
    separated_by = "a second reading of the first station at the end"
    next_measurement = "repeat the first station at the end of every cycle"
    in_parts = ("time", "reference")
    plausible = "0.1 to 5″/h"
    parameter_units = {"rate": "arcsec/h"}
    compensation = "reference"
    compensation_note = "an error of the reference, not of the table"
    defaults = {"degree": 1}

    def missing(self, observations: Observations) -> list[str]:
        rows = observations.reference
        if rows is None:
            return ["a reference run"]
        if rows.time_s is None and rows.cycle is None:
            return ["the column time_s or cycle in the reference run"]
        clock = rows.time_s if rows.time_s is not None else rows.cycle
        assert clock is not None
        return [] if np.ptp(clock) > 0 else ["a reference run of some duration"]

    def _degree(self) -> int:
        degree = self.settings["degree"]
        if not isinstance(degree, int) or not 1 <= degree <= 6:
            raise ValueError(f"effect {self.name}: degree must be 1 to 6, found {degree!r}")
        return degree

    def column_names(self, observations: Observations) -> list[str]:
        return [f"hour^{power}" for power in range(1, self._degree() + 1)]

    def reference_columns(
        self, rows: ReferenceRows, nonlinear: Nonlinear, context: FitContext
    ) -> Columns | None:
        if rows.time_s is not None:
            hours = (rows.time_s - rows.middle_time_s) / 3600.0
        elif rows.cycle is not None:
            hours = rows.cycle.astype(np.float64)
        else:
            return None
        return np.stack([hours**power for power in range(1, self._degree() + 1)], axis=1)

    def parameters(
        self,
        coefficients: NDArray[np.float64],
        covariance: NDArray[np.float64],
        nonlinear: Nonlinear,
        observations: Observations,
    ) -> dict[str, Parameter]:
        rows = observations.reference
        unit = "cycle" if rows is not None and rows.time_s is None else "h"
        sigma = np.sqrt(np.maximum(np.diag(covariance), 0.0))
        names = ("rate", "curvature", "cubic", "quartic", "quintic", "sextic")
        return {
            names[power]: Parameter(
                float(value), float(error), f"arcsec/{unit}" + (f"^{power + 1}" if power else "")
            )
            for power, (value, error) in enumerate(zip(coefficients, sigma, strict=True))
        }
