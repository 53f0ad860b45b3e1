"""arctrue benchmark: how often the diagnosis is right, on sets whose truth it does not see."""

from __future__ import annotations

from pathlib import Path

import click

from arctrue.cli._campaign import CampaignBar, campaign_options, interruptible
from arctrue.cli._workbench import console, for_people
from arctrue.studies.benchmark.plan import TIERS, make_plan, read_plan

Folder = click.Path(path_type=Path, file_okay=False)


@click.group("benchmark", short_help="Measure how often the diagnosis is right.")
def benchmark() -> None:
    """Make sets from seeds, let the diagnosis see them only, and score its answers."""


@benchmark.command("make")
@click.argument("folder", type=Folder)
@click.option("--tier", type=click.Choice(list(TIERS)), required=True, help="How many sets.")
@for_people
def make(folder: Path, tier: str) -> None:
    """Write the plan: what is sealed, then the seed of all sets."""
    plan = make_plan(tier, folder)
    console.print(
        f"{plan.sets} sets, seed {plan.seed}; generator {plan.generator}, scoring {plan.scoring}"
    )


@benchmark.command("run")
@click.argument("folder", type=Folder)
@campaign_options
@interruptible
@for_people
def run(
    folder: Path,
    workers: int | None,
    scheduler: str | None,
    shard: tuple[int, int] | None,
) -> None:
    """Make and diagnose every set of the plan that is not done yet."""
    subject = "arctrue"
    campaign = read_plan(folder).campaign(folder, subject)
    with CampaignBar("sets") as bar:
        done = campaign.run(workers=workers, scheduler=scheduler, shard=shard, progress=bar.show)
    console.print(f"{done} sets are done: {campaign.folder}", soft_wrap=True)
