"""Defines the command-line type of the orders that a choice of head places must determine."""

from __future__ import annotations

import re
from typing import Any

import click

MOST_ORDER = 1000
"""Highest order of ``arctrue alpha``; the search compares the gains of all orders at once."""


def listed_orders(text: str) -> tuple[int, ...]:
    """Parse a list of orders such as ``1-8`` or ``2,3,9``, in ascending order. Raises ValueError
    for another text, and for a range such as ``8-2``."""
    found: set[int] = set()
    for part in text.split(","):
        first, dash, last = part.partition("-")
        if not first.isdecimal() or (dash and not last.isdecimal()) or int(first) < 1:
            raise ValueError(f"{text}: expected orders such as 1-8 (first ≤ last) or 2,3,9")
        if dash and int(last) < int(first):
            raise ValueError(f"{text}: expected first ≤ last in {part}")
        found |= set(range(int(first), int(last or first) + 1))
    return tuple(sorted(found))


class Orders(click.ParamType["int | tuple[int, ...]"]):
    """Accepts a number N, which means the orders 1 to N, or a list such as ``2-8,12,24``."""

    name = "orders"

    def convert(
        self, value: Any, param: click.Parameter | None, ctx: click.Context | None
    ) -> int | tuple[int, ...]:
        """Return N, or the listed orders. Fails for another text, and for orders out of range."""
        if isinstance(value, int | tuple):
            return value
        text = str(value)
        if text.isdecimal() and 2 <= int(text) <= MOST_ORDER:
            return int(text)
        numbers = [int(number) for number in re.findall(r"[0-9]+", text)]
        try:
            if text.isdecimal() or max(numbers, default=0) > MOST_ORDER:
                raise ValueError
            return listed_orders(text)
        except ValueError:
            self.fail(
                f"{text}: expected N from 2 to {MOST_ORDER} for orders 1 to N, or a list such as "
                f"2-8,12,24 (first ≤ last) of orders up to {MOST_ORDER}",
                param,
                ctx,
            )
