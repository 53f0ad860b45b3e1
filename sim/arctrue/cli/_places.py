"""Command-line type of the places of the heads."""

from __future__ import annotations

from typing import Any

import click


class Places(click.ParamType[tuple[float, ...]]):
    """Accepts the places after head 1, in degrees: ``0,64.3,177,257.9``."""

    name = "places"

    def convert(
        self, value: Any, param: click.Parameter | None, ctx: click.Context | None
    ) -> tuple[float, ...]:
        """Return the numbers, which commas separate."""
        if isinstance(value, tuple):
            return value
        try:
            places = tuple(float(word) for word in str(value).split(","))
        except ValueError:
            self.fail(f"expected degrees such as 0,64.3,177,257.9, found {value!r}", param, ctx)
        if places[0] != 0.0 or not all(abs(place) < 360.0 for place in places):
            self.fail("expected 0 for head 1, and all below 360", param, ctx)
        return places
