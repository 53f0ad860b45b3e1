"""arctrue report: writes the analysis of a set and a model as one file, which can be sent by
mail."""

from __future__ import annotations

import shlex
from pathlib import Path

import click

from arctrue.cli._loaded_set import (
    common_options,
    console,
    for_people,
    load,
    set_argument,
    write_json,
)
from arctrue.cli._progress import Progress
from arctrue.report.analysis import analyse
from arctrue.report.charts.chart import ARCSEC, URAD
from arctrue.report.display import DisplaySettings


@click.command("report", short_help="Write the page of a set as one HTML file.")
@set_argument
@common_options
@click.option(
    "--unit",
    type=click.Choice([ARCSEC, URAD]),
    default=ARCSEC,
    show_default=True,
    help="Unit of small angles.",
)
@click.option(
    "--whitened",
    is_flag=True,
    help="Draw measurement and model whitened: uncorrelated noise with standard deviation 1.",
)
@click.option(
    "--against",
    default="",
    metavar="CONDITION",
    help="Draw the residual against this condition.",
)
@for_people
def report(
    measurement_set: Path,
    model_file: Path | None,
    folders: tuple[Path, ...],
    json_file: Path | None,
    out: Path | None,
    seed: int,
    unit: str,
    whitened: bool,
    against: str,
) -> None:
    """Write the page of arctrue serve as one self-contained HTML file, its figures as SVG and PNG.

    The file shows the set, the measured error with the model, the residual, the result of the
    diagnosis with the missing effect, the history of the model, and the coefficients for a device.
    Default of --out: report.
    """
    from arctrue.base.json_text import plain
    from arctrue.report.analysis_report import write_analysis_report
    from arctrue.report.ranking import ranked

    loaded = load(measurement_set, model_file, folders)
    with Progress("fitting") as progress:
        analysis = analyse(
            loaded.measurement_set,
            loaded.measurement,
            loaded.model,
            loaded.effects,
            loaded.observations,
        )
        if against and against not in analysis.conditions:
            raise ValueError(
                f"--against {against}: expected one of {', '.join(analysis.conditions)}"
            )
        ranking = plain(ranked(analysis, progress.now, seed=seed))
        progress.now("drawing")
        display = DisplaySettings(
            unit=URAD if unit == URAD else ARCSEC, whitened=whitened, against=against
        )
        words = ["arctrue", "report", str(measurement_set)]
        words += [] if model_file is None else ["--model", str(model_file)]
        words += [word for folder in folders for word in ("--effects", str(folder))]
        paths = write_analysis_report(
            analysis,
            ranking,
            display,
            out or Path("report"),
            measurement_set=measurement_set,
            command=shlex.join(words),
        )
    write_json(json_file, ranking["diagnosis"])
    size = paths[0].stat().st_size / 1e6
    console.print(f"wrote {paths[0]} ({size:.1f} MB) and its figures", soft_wrap=True)
