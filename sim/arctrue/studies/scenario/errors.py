"""Defines the error for a wrong scenario."""

from __future__ import annotations


class ScenarioError(ValueError):
    """A scenario that cannot be run; the message names the file and the key, and how to correct
    it."""
