"""arctrue monte-carlo: tests whether the uncertainty that the calibration states is right."""

from __future__ import annotations

from pathlib import Path

import click

from arctrue.base.whole_file import write_whole_text
from arctrue.calibration.calibration import METHODS
from arctrue.cli._campaign import CampaignBar, campaign_options, interruptible
from arctrue.cli._loaded_set import console, for_people, write_json
from arctrue.cli._numbers import SEED
from arctrue.cli._options import page_option
from arctrue.cli._outputs import OutputFile, OutputFolder
from arctrue.studies.campaign import read_results
from arctrue.studies.campaign.store import read_header
from arctrue.studies.monte_carlo.plan import TrialPlan
from arctrue.studies.monte_carlo.score import scored

USUAL = TrialPlan(400, 1)


@click.command("monte-carlo", short_help="Count how often the stated uncertainty is right.")
@click.argument("folder", type=OutputFolder())
@click.option(
    "--trials",
    type=click.IntRange(min=2, max=1_000_000),
    default=USUAL.trials,
    show_default=True,
    help="Number of trials of each case.",
)
@click.option("--seed", type=SEED, default=USUAL.seed, show_default=True, help="Seed of all draws.")
@click.option(
    "--turns",
    type=click.IntRange(1, 100),
    default=USUAL.turns,
    show_default=True,
    help="Turns per run of the capture.",
)
@click.option(
    "--runs",
    type=click.IntRange(1, 20),
    default=USUAL.runs,
    show_default=True,
    help="Runs per capture.",
)
@click.option(
    "--samples",
    type=click.IntRange(200, 100_000),
    default=USUAL.samples,
    show_default=True,
    help="Samples per turn.",
)
@click.option(
    "--method",
    type=click.Choice(list(METHODS)),
    default=USUAL.method,
    show_default=True,
    help="Method of arctrue calibrate.",
)
@click.option("--json", "json_file", type=OutputFile(), help="Write all results as JSON.")
@page_option
@campaign_options
@interruptible
@for_people
def monte_carlo(
    folder: Path,
    trials: int,
    seed: int,
    turns: int,
    runs: int,
    samples: int,
    method: str,
    json_file: Path | None,
    page_file: Path | None,
    workers: int | None,
    scheduler: str | None,
    shard: tuple[int, int] | None,
) -> None:
    """Draw random tables and input quantities, calibrate each table, compare with the truth.

    The result is the coverage of the stated uncertainty over random tables, not the distribution of
    the result of one measurement (JCGM 101).

    The command writes the results to FOLDER and prints all results in it. If it is started again,
    it continues where it stopped.
    """
    from arctrue.report.monte_carlo_page import monte_carlo_page, where_off

    campaign = TrialPlan(trials, seed, turns, runs, samples, method).campaign(folder)
    with CampaignBar("trials") as bar:
        campaign.run(workers=workers, scheduler=scheduler, shard=shard, report_speed=bar.show)
    results = [(item.task, item.result) for item in read_results([folder])]
    if len(results) < len(campaign.tasks):
        console.print(f"{len(results)} of {len(campaign.tasks)} trials are done", soft_wrap=True)
    found = scored(results)
    for case, of in found.items():
        if "orders" not in of:
            console.print(f"{case}: every capture was refused: {of['refused']}", soft_wrap=True)
            continue
        rates = [order["rate"] for order in of["orders"]]
        console.print(
            f"{case}: {of['trials']} trials, {sum(of['refused'].values())} refused; coverage of "
            f"orders {100 * sum(rates) / len(rates):.1f} % (least {100 * min(rates):.1f} %), "
            f"over the turn {100 * of['turn']['rate']:.1f} %, "
            f"of the corrected angle {100 * of['corrected']['rate']:.1f} %",
            soft_wrap=True,
        )
    for line in where_off(found):
        console.print(line, soft_wrap=True, markup=False)
    write_json(json_file, found)
    if page_file is not None:
        write_whole_text(page_file, monte_carlo_page(read_header(folder), found))
        console.print(f"wrote {page_file}", soft_wrap=True)
