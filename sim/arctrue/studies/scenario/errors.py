"""Defines the error that tells the user what is wrong with a scenario."""

from __future__ import annotations


class ScenarioError(ValueError):
    """A scenario file that cannot be run; the text says which file and key, and what to do."""
