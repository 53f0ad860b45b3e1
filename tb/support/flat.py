"""Converts lists of words to flat ports, with the first word in the low bits, and back."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


def flat(values: NDArray[np.integer], width: int) -> int:
    """Return one integer that contains ``values``, each in ``width`` bits in two's complement."""
    return sum((int(word) % 2**width) << (width * place) for place, word in enumerate(values))


def words(value: int, count: int, width: int) -> list[int]:
    """Return the ``count`` words of ``width`` bits in a flat port as unsigned numbers."""
    return [(value >> (width * place)) & (2**width - 1) for place in range(count)]


def signed_words(value: int, count: int, width: int) -> list[int]:
    """Return the ``count`` words of ``width`` bits in a flat port as signed numbers."""
    half = 1 << (width - 1)
    return [(word ^ half) - half for word in words(value, count, width)]
