"""arctrue effects: lists the catalogue, describes one effect, or creates a new one."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import asdict
from pathlib import Path
from typing import Any

import click
from rich.text import Text

from arctrue.cli._effect_name import EFFECT_NAME
from arctrue.cli._group import Commands
from arctrue.cli._loaded_set import (
    console,
    effects_for,
    effects_option,
    for_people,
    load_model,
    model_option,
    write_json,
)
from arctrue.cli._options import json_option
from arctrue.cli._progress import Progress
from arctrue.cli._tables import pairs, table, words
from arctrue.cli._terminal import tell_error
from arctrue.measurement import MeasurementSet, read_measurement_set
from arctrue.workbench.effects.base import Effect
from arctrue.workbench.effects.new_effect import write_new_effect
from arctrue.workbench.effects.registry import built_in, effect_class, from_file
from arctrue.workbench.observations.build import observations_of

CORRECTED_BY = {
    "lanes": "lanes",
    "offset": "offset",
    "modulators": "lanes of a bitstream with MODULATORS",
    "local_table": "the table of a bitstream with LOCAL_TABLE",
    "none": "nothing",
    "reference": "nothing",
}
"""Part of the gateware that can correct an effect, by the effect's kind of compensation."""


@click.group(
    "effects",
    cls=Commands,
    invoke_without_command=True,
    short_help="List the known effects, or describe one.",
)
@model_option
@effects_option
@json_option
@click.pass_context
@for_people
def effects(
    context: click.Context,
    model_file: Path | None,
    folders: tuple[Path, ...],
    json_file: Path | None,
) -> None:
    """List the effects; `show NAME` describes one; `new` and `check` are for your own effects."""
    context.obj = (model_file, folders)
    if context.invoked_subcommand is not None:
        return
    known = effects_for(load_model(model_file), model_file, folders)
    listed = table(
        "Effects", words("name"), words("what happens"), words("corrected by"), lines=True
    )
    for name, effect in known.items():
        listed.add_row(name, effect.physics, CORRECTED_BY[effect.compensation])
    console.print(listed)
    console.print("To describe one effect: arctrue effects show NAME")
    write_json(json_file, {"schema": 1, "effects": [effect_data(item) for item in known.values()]})


@effects.command("show")
@click.argument("name", type=EFFECT_NAME)
@json_option
@click.pass_context
@for_people
def show(context: click.Context, name: str, json_file: Path | None) -> None:
    """Describe one effect."""
    model_file, folders = context.obj
    effect = effect_class(name, effects_for(load_model(model_file), model_file, folders))
    data = effect_data(effect)
    console.print(effect.name, style="bold")
    grid = pairs()
    for word, text in _lines(data):
        grid.add_row(Text(word, style="bold"), Text(text))
    console.print(grid)
    write_json(json_file, {"schema": 1, **data})


def _lines(data: dict[str, Any]) -> Iterator[tuple[str, str]]:
    """Yield label and text of each line of the description; empty entries are omitted."""
    separation = ("capture_sees", "reference_sees", "separated_by", "next_measurement")
    for key in ("physics", "equation", "source", "plausible", *separation):
        if data[key]:
            yield key.replace("_", " "), data[key]
    note = f": {data['compensation_note']}" if data["compensation_note"] else ""
    yield "corrected by", f"{CORRECTED_BY[data['compensation']]}{note}"
    for item in data["search"]:
        unit = "" if item["unit"] == "1" else f" {item['unit']}"
        reach = f"{item['low']:g} to {item['high']:g}{unit}"
        yield "searched", f"{item['name']}, {reach}: {item['meaning']}"
    for key, value in data["settings"].items():
        yield "setting", f"{key} = {value}"
    named = [
        name if unit == "1" else f"{name} ({unit})" for name, unit in data["parameters"].items()
    ]
    yield "parameters", ", ".join(named) or "one per column"


@effects.command("new")
@click.argument("name")
@click.option(
    "--folder",
    type=click.Path(path_type=Path),
    default=Path("effects"),
    show_default=True,
    help="Folder for the effect and its test.",
)
@for_people
def new(name: str, folder: Path) -> None:
    """Write a template of an effect, with its test."""
    for path in write_new_effect(name, folder):
        console.print(f"wrote {path}")
    console.print(f"use it: arctrue diagnose SET --effects {folder}")


@effects.command("check")
@click.argument("file", type=click.Path(path_type=Path, dir_okay=False))
@click.option(
    "--set",
    "measurement_set",
    type=click.Path(path_type=Path, file_okay=False),
    help="Check on the rows of this set.  [default: a simulated set, all conditions]",
)
@json_option
@for_people
def check(file: Path, measurement_set: Path | None, json_file: Path | None) -> None:
    """Check the effects of the Python file FILE before they are fitted to data.

    The checks compare the columns of the design matrix with finite differences of a forward
    formula, and test units, shape, finite values, evaluation row by row, and independence of the
    model's columns. Exit code 1: a check failed. 2: FILE cannot be used.
    """
    from arctrue.workbench.check.effect_check import checks_of

    found = from_file(file)
    with Progress("making the rows"):
        observations = observations_of(_rows_to_check_on(measurement_set))
    data: list[dict[str, Any]] = []
    wrong = []
    for name, kind in found.items():
        checks = checks_of(kind, observations, built_in())
        answers = table(name, words("check"), words(), words("result"))
        for one in checks:
            answers.add_row(one.question, one.outcome, one.words)
        console.print(answers)
        wrong += [f"{name}: {one.question}" for one in checks if one.outcome == "wrong"]
        data.append({"effect": name, "checks": [asdict(one) for one in checks]})
    write_json(json_file, {"schema": 1, "file": str(file), "effects": data})
    for text in wrong:
        tell_error(f"{file}: wrong: {text}")
    if wrong:
        raise SystemExit(1)


def _rows_to_check_on(measurement_set: Path | None) -> MeasurementSet:
    """Read the set that the user named, or simulate a set with every condition that the catalogue
    uses."""
    if measurement_set is not None:
        return read_measurement_set(measurement_set)
    from arctrue.studies.simulate.experiment import EXPERIMENTS
    from arctrue.studies.simulate.simulated_set import simulate_set

    return simulate_set([], EXPERIMENTS["short"](), seed=1).measurement


def effect_data(effect: type[Effect]) -> dict[str, Any]:
    """Return all declarations of an effect as JSON values."""
    return {
        "name": effect.name,
        "physics": effect.physics,
        "equation": effect.equation,
        "source": effect.source,
        "capture_sees": effect.capture_sees,
        "reference_sees": effect.reference_sees,
        "separated_by": effect.separated_by,
        # The earlier name of this key is kept for one release.
        "told_apart_by": effect.separated_by,
        "next_measurement": effect.next_measurement,
        "plausible": effect.plausible,
        "compensation": effect.compensation,
        "compensation_note": effect.compensation_note,
        "search": [
            {
                "name": item.name,
                "unit": item.unit,
                "low": item.low,
                "high": item.high,
                "meaning": item.meaning,
            }
            for item in effect.search
        ],
        "settings": dict(effect.defaults),
        "parameters": dict(effect.parameter_units),
    }
