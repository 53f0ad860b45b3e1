"""arctrue drop: removes one effect from the model."""

from __future__ import annotations

from pathlib import Path

import click

from arctrue.cli._effect_name import EFFECT_NAME
from arctrue.cli._ladder import ladder_table
from arctrue.cli._loaded_set import (
    changing,
    common_options,
    console,
    for_people,
    load,
    set_argument,
    store,
    write_json,
)
from arctrue.cli._progress import Progress
from arctrue.cli.add import step_data
from arctrue.workbench.model.growth import drop_effect


@click.command("drop", short_help="Drop an effect from a model; see the error rise.")
@click.argument("effect", type=EFFECT_NAME)
@set_argument
@common_options
@for_people
def drop(
    effect: str,
    measurement_set: Path,
    model_file: Path | None,
    folders: tuple[Path, ...],
    json_file: Path | None,
    out: Path | None,
    seed: int,
) -> None:
    """Drop EFFECT from the model, fit the other effects to SET, and show how the error rises."""
    with changing(model_file):
        loaded = load(measurement_set, model_file, folders)
        with Progress(f"dropping {effect}"):
            model, solution = drop_effect(
                loaded.model, effect, loaded.observations, loaded.effects, loaded.measurement
            )
        if model_file is not None:
            store(model_file, model, loaded.model, measurement_set, folders)
    console.print(ladder_table(model.history))
    if json_file is not None:
        write_json(json_file, step_data(loaded, model, solution))
    if out is not None:
        from arctrue.report.charts.ladder import ladder
        from arctrue.report.charts.matplotlib_chart import save_chart

        console.print(f"wrote {save_chart(ladder(model.history), out / 'history.png')}")
