"""Defines the generics with which the benches run, and sets of values for the tests."""

from __future__ import annotations

import os

from arctrue.gateware.harmonic_lane import Rotation
from arctrue.generated import number_formats

COSINE_WIDTH = int(os.environ.get("COSINE_WIDTH", number_formats.COSINE_WIDTH))
CORDIC_ITERATIONS = int(os.environ.get("CORDIC_ITERATIONS", number_formats.CORDIC_ITERATIONS))
ROTATION: Rotation = "table" if os.environ.get("ROTATION") == "table" else "cordic"

DEFAULT = (number_formats.COSINE_WIDTH, number_formats.CORDIC_ITERATIONS)
# These values have widths below and above the default, fewer and more iterations, and the ends of
# both ranges.
OTHERS = ((14, 12), (20, 18), (18, 11), (8, 8), (24, 24), (8, 24))


def generics(width: int, iterations: int) -> dict[str, int]:
    """Return the generics of the entities; the benches get them as environment variables too."""
    return {"COSINE_WIDTH": width, "CORDIC_ITERATIONS": iterations}


def environment(**values: int | str) -> dict[str, str]:
    """Return the values as text, for environment variables."""
    return {name: str(value) for name, value in values.items()}
