"""arctrue explain: lists all causes that a set shows, ordered by size, and the remaining error."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from arctrue.base.figures import figure, with_uncertainty
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
from arctrue.cli._numbers import Finite
from arctrue.cli._progress import Progress
from arctrue.cli._tables import number, table, words
from arctrue.workbench.diagnose.diagnosis import MATTERS_COUNTS
from arctrue.workbench.diagnose.report import sentences
from arctrue.workbench.diagnose.report_json import diagnosis_data, parameter_data
from arctrue.workbench.model.explain import Explanation
from arctrue.workbench.model.explain import explain as explain_set


@click.command("explain", short_help="Add every effect that is named; list all by size.")
@set_argument
@common_options
@click.option(
    "--matters",
    type=Finite(min=0.0),
    default=MATTERS_COUNTS,
    show_default=True,
    help="RMS in counts below which an effect is negligible.",
)
@for_people
def explain(
    measurement_set: Path,
    model_file: Path | None,
    folders: tuple[Path, ...],
    json_file: Path | None,
    out: Path | None,
    seed: int,
    matters: float,
) -> None:
    """Diagnose SET and add the named effect to the model, until no further effect is named.

    The command estimates the noise anew after each addition, and drops an effect that the model no
    longer needs. --model names the file of the first model. The command writes the result to the
    same file.
    """
    with changing(model_file):
        loaded = load(measurement_set, model_file, folders, may_be_new=True)
        with Progress("explaining") as progress:
            found = explain_set(
                loaded.model,
                loaded.observations,
                loaded.effects,
                loaded.measurement,
                matters_counts=matters,
                report_step=progress.now,
            )
        if model_file is not None:
            comment = [item.sentence() for item in found.similar]
            store(model_file, found.model, loaded.model, measurement_set, folders, comment)
    _print(found)
    if model_file is not None:
        console.print(f"wrote {model_file}")
    write_json(json_file, _data(found))
    if out is not None:
        from arctrue.report.charts.ladder import ladder
        from arctrue.report.charts.matplotlib_chart import save_chart

        console.print(f"wrote {save_chart(ladder(found.model.history), out / 'history.png')}")


def _print(found: Explanation) -> None:
    console.print(ladder_table(found.model.history))
    if found.causes:
        causes = table(
            "Causes, by the error that each removes",
            words("effect"),
            words("parameter"),
            words("channel"),
            number("removes,\nheld out ″"),
        )
        for cause in found.causes:
            parameters = [
                f"{name} = {with_uncertainty(item.value, item.sigma, item.unit)}"
                for name, item in cause.entry.parameters.items()
            ]
            taken = [(channel, figure(value, 4)) for channel, value in cause.taken_arcsec.items()]
            for place in range(max(len(parameters), len(taken))):
                causes.add_row(
                    cause.entry.name if place == 0 else "",
                    parameters[place] if place < len(parameters) else "",
                    *(taken[place] if place < len(taken) else ("", "")),
                )
        console.print(causes)
    for name in found.dropped:
        console.print(f"{name} was added and dropped: the other effects explain the same error.")
    for channel, value in found.left.rms_arcsec.items():
        console.print(
            f"{channel}: left {figure(value, 4)}″ RMS, held out "
            f"{figure(found.left.heldout_rms_arcsec.get(channel), 4)}″, noise of the repeats "
            f"{figure(found.left.noise_arcsec[channel], 4)}″"
        )
    for item in found.similar:
        console.print(item.sentence())
    console.print(f"Verdict on the remaining error: {found.verdict.verdict}")
    for sentence in sentences(found.verdict):
        console.print(sentence)


def _data(found: Explanation) -> dict[str, Any]:
    not_separated = [
        {
            "effects": list(item.effects),
            "description": item.description,
            "why": item.why,
            "next_measurement": item.next_measurement,
            "next_measurement_kind": item.next_measurement_kind,
        }
        for item in found.similar
    ]
    return {
        "schema": 1,
        "model": found.model.names(),
        "causes": [
            {
                "effect": cause.entry.name,
                "parameters": parameter_data(cause.entry.parameters),
                "taken_arcsec": dict(cause.taken_arcsec),
            }
            for cause in found.causes
        ],
        "dropped": list(found.dropped),
        "not_separated": not_separated,
        # The earlier name of this key is kept for one release.
        "not_told_apart": not_separated,
        "left_arcsec": dict(found.left.rms_arcsec),
        "heldout_arcsec": dict(found.left.heldout_rms_arcsec),
        "noise_arcsec": dict(found.left.noise_arcsec),
        "diagnosis": diagnosis_data(found.verdict, found.model.names()),
    }
