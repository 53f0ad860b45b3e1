"""Converts between lists of words and flat ports, which contain the words side by side, the first
in the low bits."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


def flat(values: NDArray[np.integer], width: int) -> int:
    """Return ``values``, each in ``width`` bits (two's complement), as one integer."""
    return sum((int(word) % 2**width) << (width * place) for place, word in enumerate(values))


def words(value: int, count: int, width: int) -> list[int]:
    """Return ``count`` unsigned words of ``width`` bits."""
    return [(value >> (width * place)) & (2**width - 1) for place in range(count)]


def signed_words(value: int, count: int, width: int) -> list[int]:
    """Return ``count`` words of ``width`` bits in two's complement."""
    half = 1 << (width - 1)
    return [(word ^ half) - half for word in words(value, count, width)]
