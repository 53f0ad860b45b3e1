"""Places of heads as a value of an option."""

from __future__ import annotations

from typing import Any

import click


class Places(click.ParamType[tuple[float, ...]]):
    """Places after head 1, degrees: ``0,64.3,177,257.9``."""

    name = "places"

    def convert(
        self, value: Any, param: click.Parameter | None, ctx: click.Context | None
    ) -> tuple[float, ...]:
        """Numbers with commas between them."""
        if isinstance(value, tuple):
            return value
        try:
            places = tuple(float(word) for word in str(value).split(","))
        except ValueError:
            self.fail(f"expected degrees such as 0,64.3,177,257.9, found {value!r}", param, ctx)
        if places[0] != 0.0 or not all(abs(place) < 360.0 for place in places):
            self.fail("expected 0 for head 1, and all below 360", param, ctx)
        return places
