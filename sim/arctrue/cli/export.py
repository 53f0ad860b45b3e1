"""arctrue export: a fitted model as coefficients of the gateware."""

from __future__ import annotations

from pathlib import Path

import click
from rich.table import Table

from arctrue.calibration.calibration import objections
from arctrue.cli._numbers import Finite
from arctrue.cli._outputs import OutputFile
from arctrue.cli._progress import Progress
from arctrue.cli._terminal import say
from arctrue.cli._workbench import (
    common_options,
    console,
    for_people,
    load,
    set_argument,
    write_json,
)
from arctrue.gateware.coefficient_file import write_coefficient_file
from arctrue.generated.number_formats import LANES_DEFAULT, LANES_MAX
from arctrue.workbench.model.export import export_model
from arctrue.workbench.model.growth import fitted

NOT_WRITTEN = 1


@click.command("export", short_help="Write a model as coefficients of the gateware.")
@set_argument
@common_options
@click.option(
    "--lanes",
    type=click.IntRange(1, LANES_MAX),
    default=LANES_DEFAULT,
    show_default=True,
    help="Lanes of the gateware.",
)
@click.option("--temperature", type=Finite(), help="°C, for effects that depend on it.")
@click.option(
    "--coefficients",
    "coefficient_file",
    type=OutputFile(),
    default=Path("coefficients.toml"),
    show_default=True,
    help="File to write.",
)
@click.option(
    "--force",
    is_flag=True,
    help="Write the coefficients although the reference run or the firmware would refuse them.",
)
@for_people
def export(
    measurement_set: Path,
    model_file: Path | None,
    folders: tuple[Path, ...],
    json_file: Path | None,
    out: Path | None,
    seed: int,
    lanes: int,
    temperature: float | None,
    coefficient_file: Path,
    force: bool,
) -> None:
    """Write the model as coefficients of the gateware, and say what lanes cannot correct.

    What has no values yet is fitted to SET. With --out the file goes into that folder. Exit code
    1: SET says that these coefficients make the error larger, and nothing was written (--force
    writes them).
    """
    bench = load(measurement_set, model_file, folders)
    model = bench.model
    if not all(entry.coefficients for entry in model.effects):
        with Progress("fitting"):
            model, _ = fitted(model, bench.observations, bench.effects)
    result = export_model(
        model, bench.observations, bench.effects, lanes=lanes, temperature_c=temperature
    )
    path = coefficient_file if out is None else out / coefficient_file.name
    refused = objections(bench.measurement_set, result.coefficients)
    for warning in result.warnings:
        say(f"warning: {warning}", err=True)
    for objection in refused:
        say(f"{'warning' if force else 'export: refused'}: {objection}", err=True)
    written = force or not refused
    if written:
        path.parent.mkdir(parents=True, exist_ok=True)
        write_coefficient_file(path, result.coefficients, title=bench.measurement)
    table = Table(title=f"Lanes, {len(result.orders)} of {lanes} in use")
    table.add_column("order", justify="right")
    table.add_column("amplitude ″", justify="right")
    for order, amplitude in zip(result.orders, result.amplitudes_arcsec, strict=True):
        table.add_row(str(order), f"{amplitude:.4f}")
    console.print(table)
    for text in result.left_out:
        console.print(f"not corrected: {text}")
    if written:
        console.print(f"wrote {path}")
    write_json(
        json_file,
        {
            "schema": 1,
            "file": str(path) if written else None,
            "refused": refused,
            "lanes": [
                {"order": order, "amplitude_arcsec": amplitude}
                for order, amplitude in zip(result.orders, result.amplitudes_arcsec, strict=True)
            ],
            "not_corrected": result.left_out,
        },
    )
    if not written:
        say(f"export: {path} was not written; --force writes it", err=True)
        raise SystemExit(NOT_WRITTEN)
