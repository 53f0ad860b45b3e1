"""Defines the command-line type of the angles at which the heads stand."""

from __future__ import annotations

from typing import Any

import click

from arctrue.base.head_places import places_from_text


class Places(click.ParamType[tuple[float, ...]]):
    """Accepts the angles of all heads relative to head 1, degrees, such as ``0,64.3,177,257.9``."""

    name = "places"

    def convert(
        self, value: Any, param: click.Parameter | None, ctx: click.Context | None
    ) -> tuple[float, ...]:
        """Return the numbers in a comma-separated text."""
        if isinstance(value, tuple):
            return value
        try:
            return places_from_text(str(value))
        except ValueError as error:
            self.fail(str(error), param, ctx)
