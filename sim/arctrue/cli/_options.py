"""Defines options that several commands share."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import click
from click.core import ParameterSource

from arctrue.cli._numbers import Finite
from arctrue.cli._outputs import OutputFile
from arctrue.generated.number_formats import LANES_DEFAULT, LANES_MAX

json_option = click.option(
    "--json", "json_file", type=OutputFile(), help="Write the results as JSON."
)
page_option = click.option(
    "--page", "page_file", type=OutputFile(".md"), help="Write the page as Markdown."
)
temperature_option = click.option(
    "--temperature", type=Finite(), help="Temperature in °C, for effects that depend on it."
)


def lanes_option(
    default: int = LANES_DEFAULT, words: str = "Number of lanes of the gateware."
) -> Callable[[Callable[..., Any]], Callable[..., Any]]:
    """Return the option --lanes, whose limit is the largest number of lanes in a gateware;
    ``words`` is the help text of the option."""
    return click.option(
        "--lanes",
        type=click.IntRange(1, LANES_MAX),
        default=default,
        show_default=True,
        help=words,
    )


def refuse_given(names: Sequence[str], why: str) -> None:
    """Raise ValueError if the user gave any of these options."""
    context = click.get_current_context()
    for name in names:
        if context.get_parameter_source(name) is ParameterSource.COMMANDLINE:
            option = next(one.opts[0] for one in context.command.params if one.name == name)
            raise ValueError(f"{option} {why}")
