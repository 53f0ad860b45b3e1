"""Guides the user through the next measurement, with steps at the table, commands, and checks."""

from __future__ import annotations

import shlex
from collections.abc import Callable
from pathlib import Path

import click

from arctrue.cli._terminal import tell_objection, tell_warning
from arctrue.measurement import MeasurementSet
from arctrue.measurement.asked import KINDS, at_the_table, by_device, came

NOT_AS_ASKED = 1


def next_option(function: Callable[..., None]) -> Callable[..., None]:
    """Add the options --next KIND and --force to a command."""
    for option in (
        click.option(
            "--force", is_flag=True, help="Add the measurement even if --next refuses it."
        ),
        click.option(
            "--next",
            "kind",
            type=click.Choice(KINDS),
            metavar="KIND",
            help="Kind of measurement that diagnose requested; the command compares the new "
            f"measurement with the earlier one. One of {', '.join(KINDS)}.",
        ),
    ):
        function = option(function)
    return function


def steps(kind: str, measurement: MeasurementSet) -> list[str]:
    """Return the steps at the table, one numbered sentence each."""
    return [
        f"{number}. {text}" for number, text in enumerate(at_the_table(kind, measurement), start=1)
    ]


def commands(kind: str, folder: Path, *, model: Path | None = None) -> list[str]:
    """Return the commands to type after the steps. The user replaces PORT by the device's port,
    FILE by the recorded file, NEW and JOINED by the folders of the new set and of the joined set,
    and MODEL.toml by the model's file."""
    there = shlex.quote(str(folder))
    with_model = "" if model is None else f" --model {shlex.quote(str(model))}"
    if by_device(kind):
        return [
            f"arctrue capture PORT {there} --append --next {kind}",
            f"arctrue diagnose {there}{with_model}",
        ]
    imported = "arctrue import FILE NEW"
    if kind == "polygon_reindexed":
        # A measurement set cannot state how the polygon is mounted, so the measurement with the
        # polygon mounted anew remains a separate set.
        model_file = "MODEL.toml" if model is None else shlex.quote(str(model))
        return [imported, f"arctrue compare NEW --model {model_file} --no-fit"]
    return [
        imported,
        f"arctrue join {there} NEW JOINED --next {kind}",
        f"arctrue diagnose JOINED{with_model}",
    ]


def refuse_what_was_not_asked(
    kind: str, before: MeasurementSet, taken: MeasurementSet, *, force: bool
) -> None:
    """Print how ``taken`` differs from the requested measurement; end the command if ``taken`` is
    not that measurement and ``force`` is False."""
    found = came(kind, before, taken)
    for remark in found.remarks:
        tell_warning(remark)
    for fault in found.faults:
        tell_objection(f"not the requested measurement ({kind}): {fault}", forced=force)
    if found.faults and not force:
        raise SystemExit(NOT_AS_ASKED)
