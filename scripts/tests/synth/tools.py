"""Tells whether the tools of a test are installed."""

from __future__ import annotations

from collections.abc import Callable

from scripts.netlist import ToolError


def tools_missing(*finders: Callable[[], object]) -> str:
    """Return the reason why a tool is missing, as its finder states it, or an empty string."""
    try:
        for find in finders:
            find()
    except ToolError as error:
        return str(error)
    return ""
