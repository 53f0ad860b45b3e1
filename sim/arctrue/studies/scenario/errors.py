"""Defines the error for a wrong scenario."""

from __future__ import annotations


class ScenarioError(ValueError):
    """Raised for a scenario that cannot be run; the message names file, key and remedy."""
