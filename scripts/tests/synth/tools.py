"""Tell whether the tools of a test are present."""

from __future__ import annotations

from collections.abc import Callable

from scripts.netlist import ToolError


def tools_missing(*finders: Callable[[], object]) -> str:
    """Return why a tool is missing, in the words of its finder, or an empty string."""
    try:
        for find in finders:
            find()
    except ToolError as error:
        return str(error)
    return ""
