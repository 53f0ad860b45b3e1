"""Whether the tools of a test are there."""

from __future__ import annotations

from collections.abc import Callable

from scripts.netlist import ToolError


def tools_missing(*finders: Callable[[], object]) -> str:
    """Why a tool is not there, in the words of what looks for it; empty: all are."""
    try:
        for find in finders:
            find()
    except ToolError as error:
        return str(error)
    return ""
