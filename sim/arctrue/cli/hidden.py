"""arctrue hidden: finds and corrects a hidden effect, from the gateware's capture to its corrected
output."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import TYPE_CHECKING

import click

from arctrue.base.figures import figure
from arctrue.cli._instrument import on_the_instrument
from arctrue.cli._ladder import ladder_table
from arctrue.cli._loaded_set import console, for_people, write_json
from arctrue.cli._options import json_option, lanes_option, refuse_given
from arctrue.cli._outputs import PICTURE_ENDINGS, OutputFile, OutputFolder
from arctrue.cli._tables import number, table, words
from arctrue.cli._terminal import say
from arctrue.studies.heads.cases import HEADS_CASES
from arctrue.studies.hidden_effect.cases import CASES

if TYPE_CHECKING:
    from arctrue.studies.hidden_effect.follow import FollowedTurn
    from arctrue.studies.hidden_effect.result import HiddenResult

FULL_LINES = 16384
USUAL_LINES = 1024
LEAST_COUNTS = 1 << 18
"""Smallest number of counts per turn; with fewer counts a turn ends before the firmware has
evaluated the previous turn."""
FOLLOWED_TURNS = 4
_FOLLOWED = ", ".join(name for name, case in CASES.items() if case.order1_warms)


_EFFECTS = list(dict.fromkeys((*CASES, *HEADS_CASES)))


@click.command(short_help="Hide an effect in a table, find it and correct it.")
@click.argument("effect", type=click.Choice(_EFFECTS))
@lanes_option(4)
@click.option(
    "--lines",
    type=click.IntRange(64, FULL_LINES),
    default=USUAL_LINES,
    show_default=True,
    help="Lines of the disc; the paper's size is --lines 16384 --interpolation 1024 --lanes 32 "
    "--samples 12000 and takes some hundred times as long.",
)
@click.option(
    "--interpolation",
    type=click.Choice(["64", "256", "1024"]),
    default="256",
    show_default=True,
    help="Counts per line.",
)
@click.option(
    "--samples",
    type=click.IntRange(400, 12000),
    default=1200,
    show_default=True,
    help="Samples that are captured in a turn.",
)
@click.option(
    "--heads",
    type=click.Choice(["2", "4"]),
    default="2",
    show_default=True,
    help="Number of heads. 4: no diagnosis; the command calibrates the mean of four heads, then "
    f"adds EFFECT at its real size. EFFECT is then {' or '.join(HEADS_CASES)}.",
)
@click.option(
    "--follow",
    is_flag=True,
    help="Afterwards warm the table and show order 1 of the corrected output turn by turn. Only "
    f"with EFFECT {_FOLLOWED}.",
)
@click.option(
    "--out",
    type=OutputFolder(),
    default=Path("build") / "hidden",
    show_default=True,
    help="Folder for measurement sets and coefficients, which go into its subfolder EFFECT.",
)
@json_option
@click.option(
    "--picture", type=OutputFile(*PICTURE_ENDINGS), help="Write a picture (.svg, .png or .pdf)."
)
@for_people
def hidden(
    effect: str,
    lanes: int,
    lines: int,
    interpolation: str,
    samples: int,
    heads: str,
    follow: bool,
    out: Path,
    json_file: Path | None,
    picture: Path | None,
) -> None:
    """Hide EFFECT in a table, find it with the workbench, correct it with the gateware.

    The gateware captures a turn. The workbench gets only this capture and a reference run. The
    coefficients that it exports are loaded, and the output of further turns is compared with the
    true angle. The size of an effect is proportional to the size of a count: 1″ at the paper's 2²⁴
    counts becomes 16″ at 2²⁰. Exit code 2: the instrument cannot run.
    """
    from arctrue.studies.hidden_effect.experiment import run_hidden
    from arctrue.studies.hidden_effect.follow import follow_warming
    from arctrue.studies.hidden_effect.settings import HiddenSettings

    if heads == "4":
        refuse_given(("follow", "out", "picture"), "is for --heads 2; --json writes the results")
        _on_four_heads(effect, lanes, lines * int(interpolation), samples, json_file)
        return
    if effect not in CASES:
        raise click.UsageError(
            f"{effect} needs --heads 4: two heads cannot separate it from the disc"
        )
    if follow and not CASES[effect].order1_warms:
        raise click.UsageError(
            f"--follow shows order 1 while the table warms, which {effect} does not change; use "
            f"--follow with {_FOLLOWED}"
        )
    if lines * int(interpolation) < LEAST_COUNTS:
        raise click.UsageError(
            f"{lines * int(interpolation):,} counts a turn are too few: the firmware could not "
            "evaluate a turn before the next one ends. Give --lines "
            f"{LEAST_COUNTS // int(interpolation)} or more with --interpolation {interpolation}"
        )
    settings = HiddenSettings.of_lines(lines, lanes, samples)
    scale = dataclasses.replace(settings.revolution, interpolation=int(interpolation))
    settings = dataclasses.replace(settings, revolution=scale)
    folder = out / effect
    followed: dict[str, list[FollowedTurn]] = {}
    with on_the_instrument() as shown:
        result = run_hidden(
            CASES[effect], settings, folder, report_run=shown.progress, report_step=shown.say
        )
        if follow:
            followed = follow_warming(result, FOLLOWED_TURNS, report_run=shown.progress)
    print_result(result)
    _print_followed(followed)
    data = result.as_json()
    if followed:
        data["followed"] = {
            way: [dataclasses.asdict(turn) for turn in turns] for way, turns in followed.items()
        }
    write_json(json_file, data)
    if picture is not None:
        from arctrue.report.charts.hidden_charts import three_curves
        from arctrue.report.charts.matplotlib_chart import save_chart

        save_chart(three_curves(result), picture)
        say(f"wrote {picture}")


def _on_four_heads(
    effect: str, lanes: int, counts: int, samples: int, json_file: Path | None
) -> None:
    from arctrue.studies.heads.device import run_on_heads
    from arctrue.studies.revolution.settings import RevolutionSettings

    if effect not in HEADS_CASES:
        raise click.UsageError(f"--heads 4 is for {', '.join(HEADS_CASES)}, not for {effect}")
    if counts < LEAST_COUNTS:
        raise click.UsageError(f"{counts:,} counts a turn are too few, expected {LEAST_COUNTS:,}")
    settings = RevolutionSettings(
        lines=counts // 1024, lanes=lanes, samples=samples, orders=8, clocks_per_count=1.15
    )
    with on_the_instrument() as shown:
        found = run_on_heads(
            HEADS_CASES[effect], settings, report_run=shown.progress, report_step=shown.say
        )
    say(
        f"{found.case.title}, at order {found.case.order:g}: {found.head1_arcsec:.3f}″ on head 1, "
        f"{found.mean_arcsec:.3f}″ on the mean of four heads (calibrated earlier); a count is "
        f"{settings.arcsec_per_count:.3f}″; {found.clocks:,} clocks"
    )
    write_json(json_file, found.as_json())


def print_result(result: HiddenResult) -> None:
    """Print the verdict, the history of the model, and the output's error before and after the
    correction."""
    scale = result.settings.revolution
    say(f"What was hidden: {result.case.title}")
    console.print(ladder_table(result.diagnosed.ladder))
    console.print(
        f"\nFresh turns against the true angle; {scale.counts_per_rev:,} counts a turn, one count "
        f"is {scale.arcsec_per_count:.3f}″"
    )
    curves = table(
        "Every edge, the mean removed, ″",
        words(),
        *map(number, ("min", "max", "RMS", "order 1", "order 2", "signal\nperiod")),
    )
    for name, curve, period in (
        ("head 1, raw", result.raw, result.raw_period),
        ("output, paper's model", result.paper, result.paper_period),
        ("output, with the effect", result.corrected, result.corrected_period),
    ):
        curves.add_row(
            name,
            *(figure(value, 2) for value in curve.every_edge_arcsec),
            figure(curve.edges_rms_arcsec, 3),
            figure(curve.amplitude_arcsec[0], 3),
            figure(curve.amplitude_arcsec[1], 3),
            figure(period.amplitude_arcsec[0], 3),
        )
    console.print(curves)
    without, with_effect = (result.fresh_capture_arcsec[key] for key in ("without", "with"))
    say(
        f"Fresh capture, nothing fitted: residual {without:.3f}″ RMS of the model without the "
        f"effect, {with_effect:.3f}″ with it"
    )
    if result.reversal_arcsec is not None:
        paper, corrected = (result.reversal_arcsec[key] for key in ("paper", "corrected"))
        say(
            f"Up minus down at the stations of the polygon: {paper:.2f}″ with the paper's model, "
            f"{corrected:.2f}″ with the exported model"
        )
    left = result.judged_arcsec()
    if "unit_left_out" in left:
        order = result.case.judged_order
        unit = "local table" if result.case.local_table else "lanes that follow a condition"
        if result.case.real_orders:
            unit = "lane of an order that is not an integer"
        say(
            ("Largest error" if order is None else f"Order {order} of the error")
            + f" in the fresh turns: {left['paper']:.2f}″ with the paper's model, "
            f"{left['unit_left_out']:.2f}″ with the exported model without the {unit}, "
            f"{left['corrected']:.2f}″ with the complete exported model"
        )
    for place, line in enumerate(result.case.lines):
        sizes = {name: figure(counts[place], 2) for name, counts in result.lines_counts.items()}
        say(
            f"Order {line:g}: {sizes['without']} counts without its lane; with the lane, "
            f"{sizes['forwards']} forwards and {sizes['backwards']} backwards"
        )
    for text in result.export.followed:
        say(f"follows its condition: {text}")
    for text in result.export.real:
        say(f"continues from turn to turn: {text}")
    for text in result.export.local:
        say(f"in the local table: {text}")
    for text in result.export.left_out:
        if text not in result.export.without_lane:
            say(f"not corrected: {text}")
    if result.diagnosed.effect_file is not None:
        say(f"wrote {result.diagnosed.effect_file}")
    say(
        f"{result.clocks:,} clocks in {result.simulating_s:.0f} s, workbench "
        f"{result.workbench_s:.0f} s; measurement set: {result.folder}"
    )


def _print_followed(followed: dict[str, list[FollowedTurn]]) -> None:
    if not followed:
        return
    first = next(iter(followed.values()))
    turns = table(
        "Order 1 of the corrected output while the table warms, turn by turn, ″",
        words("°C"),
        *(number(figure(turn.temperature_c, 2)) for turn in first),
    )
    for way, followed_turns in followed.items():
        turns.add_row(way, *(figure(turn.order1_arcsec, 2) for turn in followed_turns))
    console.print(turns)
