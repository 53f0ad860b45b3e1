"""The name of an effect on the command line, completed by the shell."""

from __future__ import annotations

import click
from click.shell_completion import CompletionItem


class _EffectName(click.ParamType[str]):
    """Any word: which effects there are is known when the folders of own effects are."""

    name = "effect"

    def convert(self, value: str, param: click.Parameter | None, ctx: click.Context | None) -> str:
        """The word as it is."""
        return value

    def shell_complete(
        self, ctx: click.Context, param: click.Parameter, incomplete: str
    ) -> list[CompletionItem]:
        """The effects of the catalogue and of installed packages that begin so."""
        from arctrue.workbench.effects.registry import catalogue

        known = catalogue()
        return [CompletionItem(name) for name in known if name.startswith(incomplete)]


EFFECT_NAME = _EffectName()
