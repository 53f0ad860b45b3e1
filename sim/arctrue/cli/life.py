"""arctrue life: shows the history of one machine, computed from its measurement sets."""

from __future__ import annotations

import math
import shlex
from dataclasses import replace
from pathlib import Path

import click

from arctrue.base.extras import optional
from arctrue.base.figures import with_uncertainty
from arctrue.cli._effect_name import EFFECT_NAME
from arctrue.cli._loaded_set import (
    console,
    effects_for,
    effects_option,
    for_people,
    load_model,
    model_option,
    write_json,
)
from arctrue.cli._numbers import SEED, Finite
from arctrue.cli._options import json_option
from arctrue.cli._outputs import OutputFolder
from arctrue.cli._progress import Progress
from arctrue.cli._tables import number, table, words
from arctrue.cli._terminal import note, tell_error, tell_warning
from arctrue.device.connection import ask, daemon_of
from arctrue.device.console import ConsoleError
from arctrue.metrology.life.history import (
    FALSE_ALARMS_A_YEAR,
    HORIZON_DAYS,
    LifeHistory,
    history_of,
)
from arctrue.metrology.life.machine import fit_machine
from arctrue.workbench.model.model import ModelEffect


@click.command("life", short_help="Show when a machine changed and will reach a limit.")
@click.argument("folder", metavar="FOLDER", type=click.Path(path_type=Path, file_okay=False))
@click.option(
    "--limit",
    "limits",
    multiple=True,
    metavar="EFFECT=SIZE",
    help="Largest permitted size of an effect, arcsec, or of EFFECT.PARAMETER in its own unit; "
    "repeatable.",
)
@click.option(
    "--effect",
    "names",
    multiple=True,
    type=EFFECT_NAME,
    metavar="NAME",
    help="Effect in addition to those of the model; repeatable.",
)
@click.option(
    "--false-alarms",
    type=Finite(min=0.0, min_open=True),
    default=FALSE_ALARMS_A_YEAR,
    show_default=True,
    help="Permitted number of false change reports per year, if the command runs after each new "
    "set.",
)
@click.option(
    "--horizon",
    type=Finite(min=0.0),
    default=HORIZON_DAYS,
    show_default=True,
    help="Raise an alarm if a size may exceed its limit within this number of days.",
)
@model_option
@effects_option
@json_option
@click.option("--out", type=OutputFolder(), help="Folder for the page life.html.")
@click.option(
    "--device",
    "port",
    metavar="PORT",
    help="Send the alarms to the daemon of this serial port, or of HOST:PORT.",
)
@click.option("--seed", type=SEED, default=1, show_default=True, help="Seed of the random draws.")
@for_people
def life(
    folder: Path,
    limits: tuple[str, ...],
    names: tuple[str, ...],
    false_alarms: float,
    horizon: float,
    model_file: Path | None,
    folders: tuple[Path, ...],
    json_file: Path | None,
    out: Path | None,
    port: str | None,
    seed: int,
) -> None:
    """Fit every measurement set below FOLDER; report the changes of the machine and their dates.

    All sets come from one machine; each has a `date` in its measurement.toml. The command fits the
    model of --model, or the paper's model, to each set anew, and lists sets that it cannot use.
    FOLDER may be the store of arctrue device run, whose captures are dated sets. Exit code 1
    (alarm): a size exceeds its limit, or may exceed it within --horizon. 2: bad input, or no daemon
    accepted the alarms.
    """
    model = load_model(model_file)
    effects = effects_for(model, model_file, folders)
    model = replace(model, effects=[*model.effects, *(ModelEffect(name) for name in names)])
    for entry in model.effects:
        entry.effect(effects)
    allowed = dict(map(_limit, limits))
    if out is not None:
        optional("matplotlib")  # states a missing package before the sets are fitted
    with Progress("fitting the sets") as progress:
        machine = fit_machine(folder, model, effects, progress.now)
    history = history_of(
        machine, allowed, false_alarms_a_year=false_alarms, horizon_days=horizon, seed=seed
    )
    _print(history)
    # arctrue.report imports matplotlib if it is installed, which takes longer than the computation.
    from arctrue.report.life_report import life_data, life_sentences, write_life_page

    for sentence in life_sentences(history):
        console.print(sentence, soft_wrap=True)
    write_json(json_file, life_data(history))
    if out is not None:
        given = [word for text in limits for word in ("--limit", text)]
        command = shlex.join(["arctrue", "life", str(folder), *given])
        console.print(f"wrote {write_life_page(history, out, command=command)}", soft_wrap=True)
    if port is not None:
        _send_alarms(port, history)
    if history.alarms:
        raise SystemExit(1)


def _send_alarms(port: str, history: LifeHistory) -> None:
    """Replace the alarms that the daemon of ``port`` keeps; exit with code 2 if no daemon is
    running or the daemon does not accept them."""
    from arctrue.report.life_report import forecast_sentence

    alarms = {
        one.series.name: forecast_sentence(one, history.horizon_days) for one in history.alarms
    }
    try:
        daemon = daemon_of(port)
        if daemon is None:
            raise ConsoleError(f"{port}: no daemon runs; start: arctrue device run PORT")
        ask(daemon, "life", alarms=alarms)
    except ConsoleError as error:
        tell_error(f"the alarms were not sent: {error}")
        raise SystemExit(2) from error
    console.print(f"sent {len(alarms)} alarms to the daemon of {port}", soft_wrap=True)


def _limit(text: str) -> tuple[str, float]:
    """Parse EFFECT=SIZE. Raises ValueError for a text of another form."""
    name, _, size = text.partition("=")
    try:
        value = float(size)
    except ValueError:
        value = math.nan
    if not (name and math.isfinite(value)):
        raise ValueError(f"--limit {text}: expected EFFECT=SIZE such as hysteresis=0.5")
    return name, value


def _print(history: LifeHistory) -> None:
    if refused := history.machine.refused:
        tell_warning(f"{len(refused)} sets are not used:")
        for one in refused:
            note(f"  {one.name}: {one.reason}")
    sets = history.machine.sets
    sizes = table(
        f"{len(sets)} sets from {sets[0].date:%Y-%m-%d} to {sets[-1].date:%Y-%m-%d}",
        words("parameter"),
        number("first set"),
        number("last set"),
    )
    for series in history.series:
        sizes.add_row(
            series.name,
            with_uncertainty(float(series.size[0]), float(series.u[0]), series.unit),
            with_uncertainty(float(series.size[-1]), float(series.u[-1]), series.unit),
        )
    console.print(sizes)
