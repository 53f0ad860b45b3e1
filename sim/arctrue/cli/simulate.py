"""arctrue simulate: makes a measurement set from a simulated table with exact geometry, and a truth
file."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import click
import numpy as np

from arctrue.cli._loaded_set import console, for_people
from arctrue.cli._numbers import SEED, Finite
from arctrue.cli._outputs import OutputFolder, near
from arctrue.cli._tables import table, words
from arctrue.measurement import write_measurement_set
from arctrue.measurement.date import moment
from arctrue.studies.simulate.experiment import EXPERIMENTS, FURTHER
from arctrue.studies.simulate.hidden import hidden_effect
from arctrue.studies.simulate.simulated_set import INDEX_SCATTER_COUNTS, Wanted, simulate_set
from arctrue.studies.simulate.truth import refuse_recorded, write_truth
from arctrue.table.registry import REGISTRY


def _list_and_exit(context: click.Context, _: click.Parameter, asked: bool) -> None:
    if not asked or context.resilient_parsing:
        return
    kinds = {
        "catalogue": "",
        "parts": "not in the catalogue; a product of parts",
        "stranger": "not in the catalogue, and no product of parts",
        "noise": "--noise",
    }
    causes = table("Causes of --effect and --noise", words("name"), words("sizes"), words())
    for recipe in REGISTRY.values():
        sizes = f"{recipe.low:g} to {recipe.high:g} {recipe.unit}"
        causes.add_row(recipe.name, sizes, kinds[recipe.kind])
    console.print(causes)
    context.exit()


@click.command("simulate", short_help="Write the measurement set of a simulated table.")
@click.argument("out", metavar="OUT", type=OutputFolder())
@click.option(
    "--effect",
    "effects",
    multiple=True,
    metavar="NAME",
    help="Cause to simulate (see --list); repeatable. Without it the set has no hidden effect.",
)
@click.option(
    "--size",
    "sizes",
    multiple=True,
    type=Finite(),
    help="Size of each effect, in the order of --effect and in its unit; default: drawn.",
)
@click.option(
    "--noise",
    "noises",
    multiple=True,
    metavar="NAME[=SIZE]",
    help="Noise in addition to the white noise of every table (see --list); repeatable.",
)
@click.option(
    "--hidden",
    is_flag=True,
    help="Simulate one random cause of the catalogue and do not print its name.",
)
@click.option(
    "--experiment",
    type=click.Choice(sorted(EXPERIMENTS)),
    default="full",
    show_default=True,
    help="full: up, down, fast, warm, and a polygon; short: the same with fewer samples; "
    "lean: one run; one_pass: one turn, once over the faces; one_speed: up and down only, and a "
    "polygon.",
)
@click.option(
    "--index-scatter",
    type=click.IntRange(min=0),
    default=INDEX_SCATTER_COUNTS,
    show_default=True,
    help="Largest error, in counts, with which a head detects its index; drawn anew in each run.",
)
@click.option(
    "--heads",
    type=click.IntRange(2, 4),
    default=2,
    show_default=True,
    help="Number of heads of the table.",
)
@click.option("--seed", type=SEED, help="Seed of the set; default: a new one every time.")
@click.option(
    "--again",
    type=click.IntRange(min=0),
    default=0,
    show_default=True,
    help="Number of a repeated measurement of the same table: same --seed, new noise.",
)
@click.option(
    "--further",
    multiple=True,
    type=click.Choice(FURTHER),
    metavar="KIND",
    help="One more measurement after those of the experiment; repeatable. "
    f"One of {', '.join(FURTHER)}.",
)
@click.option("--date", metavar="DATE", help="Date of the measurement, such as 2026-03-12T09:30.")
@click.option(
    "--list",
    is_flag=True,
    is_eager=True,
    expose_value=False,
    callback=_list_and_exit,
    help="List names, sizes and units of the causes.",
)
@for_people
def simulate(
    out: Path,
    effects: tuple[str, ...],
    sizes: tuple[float, ...],
    noises: tuple[str, ...],
    hidden: bool,
    experiment: str,
    index_scatter: int,
    heads: int,
    seed: int | None,
    again: int,
    further: tuple[str, ...],
    date: str | None,
) -> None:
    """Write a measurement set to the folder OUT, and the simulated causes to OUT.truth.json."""
    if hidden and effects:
        raise ValueError("give either --hidden or --effect: --hidden draws the cause itself")
    if len(sizes) > len(effects):
        raise ValueError(f"found {len(sizes)} --size for {len(effects)} --effect")
    if again and seed is None:
        raise ValueError("--again needs the --seed of the table that is measured again")
    measured_at = None if date is None else moment(date, "--date")
    refuse_recorded(out)
    if seed is None:
        seed = int(np.random.SeedSequence().generate_state(1)[0])
    if hidden:
        effects = (hidden_effect(seed, EXPERIMENTS[experiment]()),)
    padded = [*sizes, *[None] * (len(effects) - len(sizes))]
    wanted = [Wanted(name, size) for name, size in zip(effects, padded, strict=True)]
    made = simulate_set(
        wanted,
        EXPERIMENTS[experiment](),
        seed,
        index_scatter_counts=index_scatter,
        again=again,
        further=further,
        noise=[_noise(text) for text in noises],
        heads=heads,
    )
    write_measurement_set(out, replace(made.measurement, date=measured_at))
    truth = write_truth(out, made.truth)
    console.print(f"wrote {out}; its truth is in {near(truth)}", soft_wrap=True)


def _noise(text: str) -> Wanted:
    """Parse a noise such as ``pink=0.05`` or ``pink``. Raises ValueError if the size is no
    number."""
    name, equals, size = text.partition("=")
    if not equals:
        return Wanted(name)
    try:
        return Wanted(name, float(size))
    except ValueError:
        raise ValueError(
            f"--noise {text}: expected a size such as {name}=0.05, found {size!r}"
        ) from None
