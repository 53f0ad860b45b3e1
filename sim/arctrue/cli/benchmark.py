"""arctrue benchmark: measures how often the diagnosis of sets with a hidden cause is right."""

from __future__ import annotations

from os.path import relpath
from pathlib import Path

import click

from arctrue.base.whole_file import write_whole_text
from arctrue.cli._campaign import CampaignBar, campaign_options, interruptible
from arctrue.cli._group import Commands
from arctrue.cli._loaded_set import console, for_people, write_json
from arctrue.cli._numbers import SEED
from arctrue.cli._outputs import OutputFile, OutputFolder, near
from arctrue.cli._progress import Progress
from arctrue.cli._terminal import tell_error
from arctrue.measurement import write_measurement_set
from arctrue.studies.benchmark.answers import (
    judged_sets,
    score_folders,
    score_of_peers,
    write_sets,
)
from arctrue.studies.benchmark.cases import FILE as CASES_FILE
from arctrue.studies.benchmark.cases import keep, kept_reasons
from arctrue.studies.benchmark.digests import set_name
from arctrue.studies.benchmark.frozen import differing, freeze, is_public, task_digest
from arctrue.studies.benchmark.independent.injection import INJECTIONS
from arctrue.studies.benchmark.independent.world import HIDDEN, independent_worlds
from arctrue.studies.benchmark.intervals import Rate
from arctrue.studies.benchmark.plan import SOURCES, TIERS, make_plan, read_plan
from arctrue.studies.benchmark.score import SIMULATED, SURE, is_failure, scored
from arctrue.studies.benchmark.sets import make_set
from arctrue.studies.benchmark.subject import SUBJECTS, find_subject
from arctrue.studies.benchmark.worlds import CONTENTS, SAMPLES_A_RUN, WORLDS
from arctrue.studies.campaign import read_results
from arctrue.studies.campaign.store import COMMIT, read_header
from arctrue.studies.campaign.task import digest
from arctrue.studies.simulate.truth import refuse_recorded, write_truth

Folder = click.Path(path_type=Path, file_okay=False)


@click.group("benchmark", cls=Commands, short_help="Measure how often the diagnosis is right.")
def benchmark() -> None:
    """Make sets from seeds, diagnose them without their truth, and score the answers."""


@benchmark.command("make")
@click.argument("folder", type=Folder)
@click.option(
    "--tier", type=click.Choice(list(TIERS)), required=True, help="Kind and number of the sets."
)
@click.option(
    "--generator",
    type=click.Choice(list(SOURCES)),
    default=SIMULATED,
    show_default=True,
    help="Generator of the sets: the simulated table, the independent one, or both (4 : 1).",
)
@click.option(
    "--limit",
    type=click.IntRange(min=1),
    help="Number of sets, counted from the first set of the tier.",
)
@click.option("--seed", type=SEED, help="Seed of all sets.  [default: that of the tier]")
@click.option(
    "--samples", type=click.IntRange(min=100), help="Samples per run.  [default: as in the tier]"
)
@for_people
def make(
    folder: Path,
    tier: str,
    generator: str,
    limit: int | None,
    seed: int | None,
    samples: int | None,
) -> None:
    """Write the plan of a run: first the digests of generator and scoring, then the seed."""
    plan = make_plan(tier, folder, generator, limit, seed, samples)
    console.print(
        f"{plan.sets} sets, seed {plan.seed}; generator {plan.generator}, scoring {plan.scoring}"
    )


@benchmark.command("run")
@click.argument("folder", type=Folder)
@click.option(
    "--subject",
    type=click.Choice(list(SUBJECTS)),
    default="arctrue",
    show_default=True,
    help="Program that diagnoses the sets.",
)
@campaign_options
@interruptible
@for_people
def run(
    folder: Path,
    subject: str,
    workers: int | None,
    scheduler: str | None,
    shard: tuple[int, int] | None,
) -> None:
    """Make and diagnose every set of the plan that has no answer yet."""
    plan = read_plan(folder)
    campaign = plan.campaign(folder, subject)
    find_subject(subject)
    first = campaign.tasks[0]
    if is_public(plan) and differing({set_name(first): task_digest(first)}):
        raise ValueError(
            "the first public set made here differs from the frozen one: the generator differs, or "
            "sines and cosines round differently here (arctrue benchmark sets compares all sets)"
        )
    with CampaignBar("sets") as bar:
        done = campaign.run(
            workers=workers, scheduler=scheduler, shard=shard, report_speed=bar.show
        )
    console.print(f"{done} sets are done: {campaign.folder}", soft_wrap=True)


@benchmark.command("score")
@click.argument("folders", type=Folder, nargs=-1, required=True)
@click.option(
    "--subject", default="arctrue", show_default=True, help="Program whose answers are used."
)
@click.option(
    "--answers",
    type=click.Path(path_type=Path, exists=True, dir_okay=False),
    help="JSON with the answers of another program.",
)
@click.option("--keep", "kept", is_flag=True, help="Add the failures of a run to the kept cases.")
@click.option("--json", "json_file", type=OutputFile(), help="Write all results as JSON.")
@for_people
def score(
    folders: tuple[Path, ...],
    subject: str,
    answers: Path | None,
    kept: bool,
    json_file: Path | None,
) -> None:
    """Compare the answers with the truth and with the oracle, a test that is given the cause.

    Several folders are shards of one run. --answers reads a JSON object with one answer for each
    set, under the set's name in `benchmark sets`. An answer is an object with `verdict` and
    optionally `named`, `class`, `parts`, `further`, `probability` and `held_out_arcsec`, as in the
    JSON of `arctrue diagnose`.
    """
    from arctrue.report.benchmark_page import reason_words, said_words

    if kept and answers is not None:
        raise ValueError("--keep needs the answers of a run; leave --answers out")
    sets = judged_sets(folders, subject, answers)
    found = scored(sets)
    write_json(json_file, found)
    for name, by_world in found["rates"].items():
        console.print(f"{name}: {Rate(by_world['all']['hits'], by_world['all']['of'])}")
    for name, stated in found["probability_by_generator"].items():
        for figure in ("calibration_error", "log_score_gain") if stated else ():
            item = stated[figure]
            console.print(
                f"{figure.replace('_', ' ')}, {name}: "
                f"{item['value']:.3f} ({item['low']:.3f} … {item['high']:.3f})"
            )
    if found["failed_worlds"]:
        console.print(f"worlds that fail: {', '.join(found['failed_worlds'])}")
    for kind, wrong in (found["probability"] or {}).get("wrong_where_sure", {}).items():
        console.print(f"wrong, {kind} at more than {SURE:g}: {Rate(wrong['hits'], wrong['of'])}")
    reasons = kept_reasons()
    for item in found["failures"]:
        hidden = "; ".join(item["hidden"]) or "nothing"
        console.print(
            f"{item['outcome']} ({said_words(item)}), {item['world']}, {hidden}\n"
            f"  {item['command']}\n  {reason_words(item, reasons)}",
            soft_wrap=True,
        )
    if kept:
        new = keep(filter(is_failure, sets), read_header(folders[0] / subject).get(COMMIT))
        console.print(f"{new} new cases: {CASES_FILE}", soft_wrap=True)


@benchmark.command("bound")
@click.argument("folder", type=Folder)
@click.option(
    "--effect",
    "effects",
    multiple=True,
    type=click.Choice(list(INJECTIONS)),
    metavar="NAME",
    help="Inject only this effect; repeatable.  [default: all]",
)
@click.option(
    "--times",
    type=click.IntRange(min=1),
    default=100,
    show_default=True,
    help="Number of injections of each effect.",
)
@click.option(
    "--samples",
    type=click.IntRange(min=100),
    default=TIERS["quick"].samples,
    show_default=True,
    help="Samples per run.",
)
@click.option("--seed", type=SEED, default=1, show_default=True, help="Seed of all sets.")
@click.option("--json", "json_file", type=OutputFile(), help="Write the rates as JSON.")
@campaign_options
@interruptible
@for_people
def bound(
    folder: Path,
    effects: tuple[str, ...],
    times: int,
    samples: int,
    seed: int,
    json_file: Path | None,
    workers: int | None,
    scheduler: str | None,
    shard: tuple[int, int] | None,
) -> None:
    """Inject each effect at the smallest size that the diagnosis states as detectable.

    The diagnosis should detect this size in 95 % of the sets. The command marks an effect if the
    whole 95 % interval of its measured rate lies below 95 %.
    """
    from arctrue.studies.benchmark.bound import PROMISED, bound_campaign, bound_scores

    campaign = bound_campaign(folder, effects or tuple(INJECTIONS), times, samples, seed)
    with CampaignBar("injections") as bar:
        campaign.run(workers=workers, scheduler=scheduler, shard=shard, report_speed=bar.show)
    found = bound_scores((item.task, item.result) for item in read_results([folder]))
    write_json(
        json_file,
        {
            item.effect: {"found": item.found.data(), "by_name": item.by_name.data()}
            for item in found
        },
    )
    for item in found:
        mark = "" if item.kept else f"  below {100 * PROMISED:g} %"
        console.print(
            f"{item.effect}: found {item.found}, by name {item.by_name}{mark}", soft_wrap=True
        )


@benchmark.command("page")
@click.argument("folders", type=Folder, nargs=-1, required=True)
@click.option(
    "--subject", default="arctrue", show_default=True, help="Program whose answers are used."
)
@click.option(
    "--peers",
    type=Folder,
    help="Folder of the public tier; the page then compares all programs that answered its sets.",
)
@click.option("--to", "path", type=OutputFile(), required=True, help="Markdown file to write.")
@click.option("--out", type=OutputFolder(), help="Folder for the picture.")
@for_people
def page(
    folders: tuple[Path, ...], subject: str, peers: Path | None, path: Path, out: Path | None
) -> None:
    """Write the scores as a page."""
    from arctrue.report.benchmark_page import benchmark_page
    from arctrue.report.charts.benchmark_picture import plot_benchmark

    found = score_folders(folders, subject, None)
    header = read_header(folders[0] / subject)
    compared = None if peers is None else score_of_peers(peers)
    picture = None
    if out is not None:
        picture = Path(relpath(plot_benchmark(found, out), path.parent)).as_posix()
    write_whole_text(path, benchmark_page(header, found, compared, kept_reasons(), picture))
    console.print(f"wrote {path}")


@benchmark.command("set")
@click.argument("folder", type=OutputFolder())
@click.option(
    "--world",
    type=click.Choice([*WORLDS, *independent_worlds()]),
    metavar="NAME",
    required=True,
    help=f"Conditions of the set: one of {', '.join(WORLDS)}; for the independent generator one of "
    f"{', '.join(independent_worlds())}.",
)
@click.option(
    "--content",
    type=click.Choice([*CONTENTS, HIDDEN]),
    required=True,
    help="Hidden cause; the independent generator accepts only nothing and hidden.",
)
@click.option("--seed", type=SEED, required=True, help="Seed of the set.")
@click.option(
    "--samples",
    type=click.IntRange(min=100),
    default=SAMPLES_A_RUN,
    show_default=True,
    help="Samples per run.",
)
@for_people
def one_set(folder: Path, world: str, content: str, seed: int, samples: int) -> None:
    """Make one set again in FOLDER, and write its truth to FOLDER.truth.json."""
    refuse_recorded(folder)
    made = make_set({"world": world, "content": content, "seed": seed, "samples": samples})
    write_measurement_set(folder, made.measurement)
    console.print(f"wrote {folder}; its truth is in {near(write_truth(folder, made.truth))}")


@benchmark.command("sets")
@click.argument("folder", type=Folder)
@click.argument("out", type=OutputFolder())
@click.option(
    "--first",
    type=click.IntRange(min=1),
    help="Write only this number of sets, counted from the first.",
)
@click.option(
    "--freeze",
    "frozen",
    is_flag=True,
    help="Store the digests of these sets as those of the frozen sets (tier public).",
)
@for_people
def sets(folder: Path, out: Path, first: int | None, frozen: bool) -> None:
    """Write the plan's measurement sets to OUT without their truth, for other programs.

    The command compares sets of the tier public with the digests of the frozen sets. Exit code 1: a
    set differs, so its answers cannot be compared with answers to the frozen set.
    """
    plan = read_plan(folder)
    with Progress("writing sets") as progress:
        digests = write_sets(plan, out, first, progress.now)
    console.print(f"wrote {len(digests)} sets to {out}; digest {digest(digests)}", soft_wrap=True)
    if not is_public(plan):
        return
    if frozen:
        freeze(digests)
    other = differing(digests)
    if other:
        tell_error(
            f"{len(other)} of {len(digests)} sets differ from the frozen ones, first "
            f"{other[0]}: the generator differs, or sines and cosines round differently here"
        )
        raise SystemExit(1)
    console.print("all of them equal the frozen ones")
