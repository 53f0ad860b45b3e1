"""Defines the command-line types of finite numbers and of seeds."""

from __future__ import annotations

import math
from typing import Any

import click


class Finite(click.FloatRange):
    """Accepts a finite number within limits; refuses nan and inf."""

    name = "number"

    def convert(
        self, value: Any, param: click.Parameter | None, ctx: click.Context | None
    ) -> float:
        """Return the number. Fails for a text, nan, inf, and a number outside the limits."""
        number = float(click.FLOAT.convert(value, param, ctx))
        if not math.isfinite(number):
            self.fail(f"{value!r} is not a finite number.", param, ctx)
        return float(super().convert(number, param, ctx))

    def _describe_range(self) -> str:
        """Return the range for the help; a number without limits has no range."""
        return "" if self.min is None and self.max is None else super()._describe_range()


SEED = click.IntRange(min=0)
"""Accepts the seed of a random generator; numpy accepts no negative seed."""
