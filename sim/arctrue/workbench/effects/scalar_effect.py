"""Effects with one coefficient: the parameter is the coefficient, in the effect's own unit."""

from __future__ import annotations

from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from arctrue.workbench.effects.base import Effect, Nonlinear, Parameter
from arctrue.workbench.observations import Observations


class ScalarEffect(Effect):
    """An effect whose size is one number."""

    parameter_name: ClassVar[str]
    parameter_unit: ClassVar[str]

    def column_names(self, observations: Observations) -> list[str]:
        return [self.parameter_name]

    def parameters(
        self,
        coefficients: NDArray[np.float64],
        covariance: NDArray[np.float64],
        nonlinear: Nonlinear,
        observations: Observations,
    ) -> dict[str, Parameter]:
        sigma = float(np.sqrt(max(covariance[0, 0], 0.0)))
        return {self.parameter_name: Parameter(float(coefficients[0]), sigma, self.parameter_unit)}
