"""arctrue effects: the catalogue, one effect, or a new one to edit."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click
from rich.table import Table

from arctrue.cli._workbench import console, effects_for, for_people, load_model, write_json
from arctrue.effects.base import Effect
from arctrue.effects.new_effect import write_new_effect
from arctrue.effects.registry import effect_class


@click.group("effects", invoke_without_command=True)
@click.option("--model", "model_file", type=click.Path(path_type=Path), help="Model (TOML).")
@click.option("--effects", "folders", type=click.Path(path_type=Path), multiple=True)
@click.option("--json", "json_file", type=click.Path(path_type=Path), help="Write JSON.")
@click.pass_context
@for_people
def effects(
    context: click.Context,
    model_file: Path | None,
    folders: tuple[Path, ...],
    json_file: Path | None,
) -> None:
    """List the effects; `show NAME` tells all of one, `new NAME` writes one to edit."""
    context.obj = (model_file, folders)
    if context.invoked_subcommand is not None:
        return
    known = effects_for(load_model(model_file), model_file, folders)
    table = Table(title="Effects")
    for heading in ("name", "what happens", "lanes?"):
        table.add_column(heading)
    for name, effect in known.items():
        table.add_row(name, effect.physics, effect.compensation)
    console.print(table)
    write_json(json_file, {"schema": 1, "effects": [effect_data(item) for item in known.values()]})


@effects.command("show")
@click.argument("name")
@click.option("--json", "json_file", type=click.Path(path_type=Path), help="Write JSON.")
@click.pass_context
@for_people
def show(context: click.Context, name: str, json_file: Path | None) -> None:
    """Everything about one effect."""
    model_file, folders = context.obj
    effect = effect_class(name, effects_for(load_model(model_file), model_file, folders))
    data = effect_data(effect)
    for key, value in data.items():
        if isinstance(value, str) and value:
            console.print(f"[bold]{key.replace('_', ' ')}[/bold]: {value}")
    for item in data["search"]:
        console.print(
            f"[bold]searched[/bold]: {item['name']}, {item['low']:g} to {item['high']:g} "
            f"{item['unit']}, {item['meaning']}"
        )
    console.print(f"[bold]settings[/bold]: {data['settings']}")
    console.print(f"[bold]parameters[/bold]: {', '.join(data['parameters']) or 'one a column'}")
    write_json(json_file, {"schema": 1, **data})


@effects.command("new")
@click.argument("name")
@click.option(
    "--folder",
    type=click.Path(path_type=Path),
    default=Path("effects"),
    show_default=True,
    help="Where the file goes.",
)
@for_people
def new(name: str, folder: Path) -> None:
    """Write an effect ready to edit, with its test."""
    for path in write_new_effect(name, folder):
        console.print(f"wrote {path}")
    console.print(f"use it: arctrue diagnose SET --effects {folder}")


def effect_data(effect: type[Effect]) -> dict[str, Any]:
    """All that an effect declares, as JSON."""
    return {
        "name": effect.name,
        "physics": effect.physics,
        "equation": effect.equation,
        "source": effect.source,
        "capture_sees": effect.capture_sees,
        "reference_sees": effect.reference_sees,
        "told_apart_by": effect.told_apart_by,
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
