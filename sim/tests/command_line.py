"""Runs the command line from a test."""

from __future__ import annotations

from click.testing import CliRunner, Result

from arctrue.cli import main


def arctrue(*words: object) -> Result:
    """Run ``arctrue WORDS`` and return the result."""
    return CliRunner().invoke(main, [str(word) for word in words])
