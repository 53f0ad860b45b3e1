"""Run the command line from a test."""

from __future__ import annotations

from click.testing import CliRunner, Result

from arctrue.cli import main


def arctrue(*words: object) -> Result:
    """Return the result of ``arctrue WORDS``."""
    return CliRunner().invoke(main, [str(word) for word in words])
