"""Defines the error for a wrong scenario."""

from __future__ import annotations


class ScenarioError(ValueError):
    """A scenario file that cannot be run; the text says which file and key, and what to do."""
