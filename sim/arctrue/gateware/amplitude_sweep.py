"""Models the entity ``amplitude_sweep``, which multiplies amplitudes by their modulators."""

from __future__ import annotations

import dataclasses
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from arctrue.gateware.coefficients import Coefficients
from arctrue.gateware.lane_words import AMPLITUDE_WORD_MAX
from arctrue.gateware.table_conditions import MODULATOR_ONE
from arctrue.generated.number_formats import MODULATOR_FRACTION


class Modulators(NamedTuple):
    """Modulators: factors by which the amplitudes of lanes are multiplied, s1.16."""

    direction: int = 0
    speed: int = 0
    word_a: int = 0
    word_b: int = 0

    @property
    def values(self) -> NDArray[np.int64]:
        """Return the modulators in the order of the names in ``extension.MODULATORS``, (6,)."""
        square = int(rounded_product(self.speed, self.speed))
        return np.array(
            [MODULATOR_ONE, self.direction, self.speed, square, self.word_a, self.word_b]
        )


def rounded_product(word: ArrayLike, modulator: ArrayLike) -> NDArray[np.int64]:
    """Return word · modulator in the unit of the word, rounded half up."""
    product = np.asarray(word, dtype=np.int64) * np.asarray(modulator, dtype=np.int64)
    rounded: NDArray[np.int64] = (product + (MODULATOR_ONE >> 1)) >> MODULATOR_FRACTION
    return rounded


def effective_amplitudes(amplitudes: ArrayLike, modulator: ArrayLike) -> NDArray[np.int64]:
    """Return amplitude · modulator in 2⁻¹¹ count, limited to the format, as the pipeline reads it;
    the shapes of the arguments broadcast."""
    return np.minimum(rounded_product(amplitudes, modulator), AMPLITUDE_WORD_MAX)


def modulated(coefficients: Coefficients, modulators: Modulators) -> Coefficients:
    """Return the bank with the amplitudes that the pipeline reads while the modulators are
    constant."""
    chosen = modulators.values[coefficients.modulator_numbers]
    amplitudes = effective_amplitudes(coefficients.amplitudes, chosen)
    return dataclasses.replace(coefficients, amplitudes=amplitudes.astype(np.int32))
