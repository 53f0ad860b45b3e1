"""The command line as a test calls it."""

from __future__ import annotations

from click.testing import CliRunner, Result

from arctrue.cli import main


def arctrue(*words: object) -> Result:
    """Result of ``arctrue WORDS``."""
    return CliRunner().invoke(main, [str(word) for word in words])
