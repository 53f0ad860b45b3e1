"""Defines the command-line type of an effect's name; the shell can complete such names."""

from __future__ import annotations

import click
from click.shell_completion import CompletionItem


class _EffectName(click.ParamType[str]):
    """Accepts any word; :func:`load` checks it, because only :func:`load` reads the user's
    effects."""

    name = "effect"

    def convert(self, value: str, param: click.Parameter | None, ctx: click.Context | None) -> str:
        """Return the word unchanged."""
        return value

    def shell_complete(
        self, ctx: click.Context, param: click.Parameter, incomplete: str
    ) -> list[CompletionItem]:
        """Return the effects of the catalogue and of installed packages whose names begin with the
        typed text."""
        from arctrue.workbench.effects.registry import catalogue

        known = catalogue()
        return [CompletionItem(name) for name in known if name.startswith(incomplete)]


EFFECT_NAME = _EffectName()
