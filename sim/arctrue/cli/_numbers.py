"""Numbers on the command line: finite ones."""

from __future__ import annotations

import math
from typing import Any

import click


class Finite(click.FloatRange):
    """A number within limits; nan and inf are none."""

    name = "number"

    def convert(
        self, value: Any, param: click.Parameter | None, ctx: click.Context | None
    ) -> float:
        """The number. Fails for text, for nan and inf, and outside the limits."""
        number = float(click.FLOAT.convert(value, param, ctx))
        if not math.isfinite(number):
            self.fail(f"{value!r} is not a finite number.", param, ctx)
        return float(super().convert(number, param, ctx))

    def _describe_range(self) -> str:
        """The range for the help, which has none to show of a number without limits."""
        return "" if self.min is None and self.max is None else super()._describe_range()


SEED = click.IntRange(min=0)
"""Of random numbers: numpy takes no negative one."""
