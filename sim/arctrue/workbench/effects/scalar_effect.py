"""Effects whose parameters are their coefficients, in the effect's own unit.

Most have one coefficient. What each head has of its own (a bracket, a delay) has one for each of
heads 2, 3, …: that of head 1 makes the same change of all of them.
"""

from __future__ import annotations

from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from arctrue.workbench.effects.base import Effect, Nonlinear, Parameter
from arctrue.workbench.effects.capture_block import in_place_of_head
from arctrue.workbench.observations import CaptureRows, Observations

Float = NDArray[np.float64]


class ScalarEffect(Effect):
    """An effect whose size is one number, or one number a head."""

    parameter_name: ClassVar[str]
    parameter_unit: ClassVar[str]
    of_each_head: ClassVar[bool] = False
    """Heads 2, 3, … have a coefficient each."""

    def column_names(self, observations: Observations) -> list[str]:
        further = range(3, observations.heads + 1) if self.of_each_head else ()
        return [self.parameter_name, *(f"{self.parameter_name}_head{head}" for head in further)]

    def column(self, values: Float, rows: CaptureRows) -> Float:
        """The only column of these values, (rows,), or that of the rows' head among all."""
        column = values[:, np.newaxis]
        return in_place_of_head(column, rows) if self.of_each_head else column

    def parameters(
        self,
        coefficients: NDArray[np.float64],
        covariance: NDArray[np.float64],
        nonlinear: Nonlinear,
        observations: Observations,
    ) -> dict[str, Parameter]:
        sigma = np.sqrt(np.maximum(np.diag(covariance), 0.0))
        names = self.column_names(observations)
        return {
            name: Parameter(float(value), float(error), self.parameter_unit)
            for name, value, error in zip(names, coefficients, sigma, strict=True)
        }
