"""arctrue add: adds one effect to the model."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from arctrue.base.figures import with_uncertainty
from arctrue.cli._effect_name import EFFECT_NAME
from arctrue.cli._ladder import ladder_table
from arctrue.cli._loaded_set import (
    LoadedSet,
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
from arctrue.cli._settings import settings_from
from arctrue.workbench.diagnose.diagnosis import diagnose
from arctrue.workbench.diagnose.report_json import parameter_data
from arctrue.workbench.inference.solution import Solution
from arctrue.workbench.model.growth import add_effect
from arctrue.workbench.model.model import HistoryStep, Model
from arctrue.workbench.model.noise_floor import floor_of


@click.command("add", short_help="Add an effect to a model; see the error fall.")
@click.argument("effect", type=EFFECT_NAME)
@set_argument
@common_options
@click.option(
    "--set",
    "pairs",
    multiple=True,
    metavar="KEY=VALUE",
    help="Value of a setting of EFFECT; also for an EFFECT that the model already has.",
)
@for_people
def add(
    effect: str,
    measurement_set: Path,
    model_file: Path | None,
    folders: tuple[Path, ...],
    json_file: Path | None,
    out: Path | None,
    seed: int,
    pairs: tuple[str, ...],
) -> None:
    """Add EFFECT to the model, fit the model to SET, and show how the error falls.

    Without --set, the command chooses from SET the multiples and side lines of the tooth count for
    drive_gear_error, and the transition for hysteresis. If the model already has EFFECT, --set
    changes a setting of EFFECT and the command fits the model again.
    """
    settings = settings_from(pairs)
    with changing(model_file):
        loaded = load(measurement_set, model_file, folders, may_be_new=True)
        with Progress(f"adding {effect}"):
            model, solution = add_effect(
                loaded.model,
                effect,
                settings,
                loaded.observations,
                loaded.effects,
                loaded.measurement,
            )
        if model_file is not None:
            store(model_file, model, loaded.model, measurement_set, folders)
    console.print(ladder_table(model.history))
    console.print(f"{model.effects[-1].name}, with standard uncertainties:")
    for name, parameter in model.effects[-1].parameters.items():
        console.print(
            f"{name} = {with_uncertainty(parameter.value, parameter.sigma, parameter.unit)}"
        )
    if model_file is not None:
        console.print(f"wrote {model_file}")
    if json_file is not None:
        with Progress("diagnosing the residual"):
            write_json(json_file, step_data(loaded, model, solution))
    if out is not None:
        from arctrue.report.charts.ladder import ladder
        from arctrue.report.charts.matplotlib_chart import save_chart

        console.print(f"wrote {save_chart(ladder(model.history), out / 'history.png')}")


def step_data(loaded: LoadedSet, model: Model, solution: Solution) -> dict[str, Any]:
    """Return the errors before and after the latest step of the history, and the verdict on the
    residual."""
    after = model.history[-1]
    before = model.history[-2] if len(model.history) > 1 else after
    left = diagnose(loaded.observations, solution.terms, loaded.effects)
    entry = model.effects[-1]
    return {
        "schema": 1,
        "action": after.action,
        "effect": after.effect,
        "model": model.names(),
        **_change("rms", before, after),
        **_change("peak", before, after),
        **_change("heldout", before, after),
        "noise_arcsec": floor_of(model.history),
        "parameters": parameter_data(entry.parameters),
        "verdict_after": left.verdict,
        "named_after": None if left.named is None else left.named.name,
    }


def _change(figure: str, before: HistoryStep, after: HistoryStep) -> dict[str, Any]:
    attribute = {"rms": "rms_arcsec", "peak": "peak_arcsec", "heldout": "heldout_rms_arcsec"}[
        figure
    ]
    return {
        f"{figure}_before_arcsec": getattr(before, attribute),
        f"{figure}_after_arcsec": getattr(after, attribute),
    }
