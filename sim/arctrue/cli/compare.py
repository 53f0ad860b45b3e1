"""arctrue compare: where the model fails."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path

import click
from rich.table import Table

from arctrue.cli._workbench import (
    common_options,
    console,
    for_people,
    load,
    progress_console,
    set_argument,
    write_json,
)
from arctrue.compare.comparison import SIGNIFICANCE, Comparison
from arctrue.compare.comparison import compare as compare_model
from arctrue.model.growth import as_stored, fitted


@click.command("compare")
@set_argument
@common_options
@click.option(
    "--no-fit", is_flag=True, help="Judge the stored coefficients; fit only run offsets and a₀."
)
@for_people
def compare(
    measurement_set: Path,
    model_file: Path | None,
    folders: tuple[Path, ...],
    json_file: Path | None,
    out: Path | None,
    seed: int,
    no_fit: bool,
) -> None:
    """Compare a model with a measurement set: how far, and where."""
    bench = load(measurement_set, model_file, folders)
    with progress_console.status("comparing"):
        if no_fit:
            solution = as_stored(bench.model, bench.observations, bench.effects)
        else:
            _, solution = fitted(bench.model, bench.observations, bench.effects)
        result = compare_model(solution, seed)
    _print(result)
    write_json(
        json_file,
        {
            "schema": 1,
            "model": bench.model.names(),
            "fitted": not no_fit,
            "channels": {
                name: {**asdict(item), "excess_arcsec": item.excess_arcsec}
                for name, item in result.channels.items()
            },
            "findings": [asdict(item) for item in result.findings],
            "maps": [asdict(item) for item in result.maps],
            "identifiability": {"rank": solution.rank, "condition": solution.condition},
        },
    )
    if out is not None:
        from arctrue.report.residual_plots import plot_comparison

        for path in plot_comparison(solution, result, out):
            console.print(f"wrote {path}")


def _print(result: Comparison) -> None:
    table = Table(title="Model against measurement")
    for heading in ("channel", "rows", "RMS ″", "peak ″", "noise of repeats ″", "lack of fit p"):
        table.add_column(heading, justify="left" if heading == "channel" else "right")
    for name, item in result.channels.items():
        table.add_row(
            name,
            f"{item.rows:,}",
            f"{item.rms_arcsec:.4f}",
            f"{item.peak_arcsec:.3f}",
            f"{item.noise_arcsec:.4f}",
            f"{item.lack_of_fit_p:.2g}",
        )
    console.print(table)
    lacking = [name for name, item in result.channels.items() if item.lack_of_fit_p < SIGNIFICANCE]
    if not result.findings and lacking:
        console.print(
            f"The model does not fit the {' and the '.join(lacking)}, yet the residual follows "
            "none of the conditions drawn here: ask arctrue diagnose."
        )
    elif not result.findings:
        console.print("Nothing beyond chance: the residual follows none of the conditions.")
    for finding in result.findings:
        console.print(f"• {finding.text}")
