"""arctrue diagnose: which physical effect is missing."""

from __future__ import annotations

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
from arctrue.diagnose.adopted import adopt as write_adopted
from arctrue.diagnose.diagnosis import MATTERS_COUNTS, Diagnosis
from arctrue.diagnose.diagnosis import diagnose as diagnose_model
from arctrue.diagnose.parts import ProductOfParts
from arctrue.diagnose.report import diagnosis_data, sentences
from arctrue.model.growth import settle

SHOWN = 8


@click.command("diagnose")
@set_argument
@common_options
@click.option(
    "--matters",
    type=click.FloatRange(min=0.0),
    default=MATTERS_COUNTS,
    show_default=True,
    help="Counts RMS below which an effect is negligible.",
)
@click.option("--adopt", metavar="NAME", help="Write the found product of parts as an effect.")
@click.option(
    "--folder",
    type=click.Path(path_type=Path),
    default=Path("effects"),
    show_default=True,
    help="Where an adopted effect goes.",
)
@for_people
def diagnose(
    measurement_set: Path,
    model_file: Path | None,
    folders: tuple[Path, ...],
    json_file: Path | None,
    out: Path | None,
    seed: int,
    matters: float,
    adopt: str | None,
    folder: Path,
) -> None:
    """Say which physical effect the model lacks, or that the data cannot tell."""
    bench = load(measurement_set, model_file, folders)
    with progress_console.status("diagnosing") as status:
        terms = settle(bench.model, bench.observations, bench.effects)
        result = diagnose_model(
            bench.observations,
            terms,
            bench.effects,
            seed=seed,
            matters_counts=matters,
            progress=status.update,
        )
    _print(result)
    write_json(json_file, diagnosis_data(result, bench.model.names()))
    if adopt is not None:
        console.print(f"wrote {_adopted(result, adopt, folder)}")
        console.print(f"use it: arctrue add {adopt} {measurement_set} --effects {folder}")
    if out is not None and result.base is not None:
        from arctrue.report.residual_plots import plot_candidates

        console.print(f"wrote {plot_candidates(result, out)}")


def _adopted(result: Diagnosis, name: str, folder: Path) -> Path:
    """The file of the adopted product. Raises ValueError when the verdict gives none."""
    found = result.parts[0].effect if result.verdict == "unknown" and result.parts else None
    if not isinstance(found, ProductOfParts):
        raise ValueError(f"nothing to adopt: the verdict is {result.verdict}, not unknown")
    return write_adopted(found, name, result.description or "", folder)


def _print(result: Diagnosis) -> None:
    if result.candidates:
        table = Table(title="Candidates, best first")
        for heading in ("effect", "p (corrected)", "ΔBIC", "RMS after ″", "held-out fall ″"):
            table.add_column(heading, justify="left" if heading == "effect" else "right")
        for item in result.candidates[:SHOWN]:
            falls = ", ".join(
                f"{channel} {fall.fall_arcsec:.3f} ± {fall.standard_error_arcsec:.3f}"
                for channel, fall in item.improvement.items()
            )
            sigmas = [
                item.solution.capture_sigma_arcsec,
                item.solution.reference_sigma_arcsec,
            ]
            after = " / ".join(f"{value:.3f}" for value in sigmas if value is not None)
            table.add_row(
                item.name, f"{item.p_corrected:.2g}", f"{item.delta_bic:.1f}", after, falls
            )
        console.print(table)
    for channel, value in result.residual_rms_arcsec.items():
        console.print(
            f"{channel}: residual {value:.3f}″ RMS, noise of the repeats "
            f"{result.noise_arcsec[channel]:.3f}″, lack of fit p = "
            f"{result.lack_of_fit.get(channel, float('nan')):.2g}"
        )
    for name, lacking in result.untestable.items():
        console.print(f"{name} cannot be tested with this set: it lacks {'; '.join(lacking)}")
    console.print(f"[bold]Verdict: {result.verdict}[/bold]")
    for sentence in sentences(result):
        console.print(sentence)
