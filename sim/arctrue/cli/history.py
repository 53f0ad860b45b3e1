"""arctrue history: shows the steps of a model and the model's error after each step."""

from __future__ import annotations

from pathlib import Path

import click
from msgspec import structs

from arctrue.cli._ladder import ladder_table
from arctrue.cli._loaded_set import console, for_people, write_json
from arctrue.cli._options import json_option
from arctrue.cli._outputs import OutputFolder
from arctrue.workbench.model.model_file import read_model
from arctrue.workbench.model.noise_floor import with_one_floor


@click.command("history", short_help="Show the steps of a model and its error after each.")
@click.option(
    "--model",
    "model_file",
    type=click.Path(path_type=Path),
    required=True,
    help="Model (TOML).",
)
@json_option
@click.option("--out", type=OutputFolder(), help="Folder for the picture.")
@for_people
def history(model_file: Path, json_file: Path | None, out: Path | None) -> None:
    """Print every step of a model and, with --out, draw its error after each step.

    RMS and peak are those of the fitted rows. "held out" is the RMS of rows that the fit did not
    use. Each quarter of the rows is predicted by a fit to the other rows. "noise" is the standard
    deviation of repeated readings. No model of the set has a smaller error.
    """
    model = read_model(model_file)
    if not model.history:
        raise ValueError(f"{model_file}: the model has no history yet; add an effect first")
    console.print(ladder_table(model.history))
    write_json(
        json_file,
        {"schema": 1, "history": [structs.asdict(step) for step in with_one_floor(model.history)]},
    )
    if out is not None:
        from arctrue.report.charts.ladder import ladder
        from arctrue.report.charts.matplotlib_chart import save_chart

        console.print(f"wrote {save_chart(ladder(model.history), out / 'history.png')}")
