"""Noise of the readings that hangs on the row before: a filter in the electronics, AR(1)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from arctrue.table.causes.cause import Cause
from arctrue.table.conditions import Conditions
from arctrue.table.noise import Noise


@dataclass(frozen=True, slots=True)
class AutoregressiveNoise(Cause):
    """x_i = correlation·x_{i−1} + w_i from row to row, whatever the time; each run begins anew."""

    sigma_rad: float
    correlation: float
    """Above −1 and below 1."""

    def head_noise(self, head: int, conditions: Conditions) -> Noise:
        """One process of the standard deviation ``sigma_rad``."""
        same_run = np.concatenate([[False], np.diff(conditions.run) == 0])
        decay = np.where(same_run, self.correlation, 0.0)[None, :]
        return Noise(np.zeros(same_run.size), np.array([self.sigma_rad]), decay)
