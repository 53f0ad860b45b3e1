"""arctrue heads: tests the calibrated mean of four heads on a simulated table."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from arctrue.base.json_text import plain
from arctrue.base.whole_file import write_whole_text
from arctrue.cli._loaded_set import console, for_people, write_json
from arctrue.cli._numbers import SEED
from arctrue.cli._options import json_option, page_option
from arctrue.cli._progress import Progress
from arctrue.cli._tables import number, table, words


@click.command(short_help="Test the mean of four heads on a simulated table.")
@click.option(
    "--samples",
    "samples_a_turn",
    type=click.IntRange(1200, 48_000),
    default=12_000,
    show_default=True,
    help="Samples per turn.",
)
@click.option(
    "--orders",
    "fine_orders",
    type=click.IntRange(12, 500),
    default=500,
    show_default=True,
    help="Number of orders of the error function.",
)
@click.option(
    "--turns",
    "fine_turns",
    type=click.IntRange(1, 100),
    default=10,
    show_default=True,
    help="Number of turns from which the error function is estimated.",
)
@click.option("--seed", type=SEED, default=1, show_default=True, help="Seed of noise and mounting.")
@json_option
@page_option
@for_people
def heads(
    samples_a_turn: int,
    fine_orders: int,
    fine_turns: int,
    seed: int,
    json_file: Path | None,
    page_file: Path | None,
) -> None:
    """Calibrate a simulated table of four heads once, and test their mean on other turns.

    The study covers ball-pass motion of the bearing, a disc whose centre moves, a head that is
    missing or has moved, and the disc's error up to high orders. It compares the mean of four heads
    with two heads on the same disc.
    """
    from arctrue.report.heads_page import heads_page
    from arctrue.studies.heads.shown import shown

    if samples_a_turn < 2 * fine_orders + 2:
        raise ValueError(
            f"--samples: order {fine_orders} needs at least {2 * fine_orders + 2} samples per "
            f"turn, found {samples_a_turn}"
        )
    with Progress("measuring") as step:
        found = plain(
            shown(
                samples_a_turn=samples_a_turn,
                fine_orders=fine_orders,
                fine_turns=fine_turns,
                seed=seed,
                report_step=step.now,
            )
        )
    _print(found)
    write_json(json_file, found)
    if page_file is not None:
        write_whole_text(page_file, heads_page(found))
        console.print(f"wrote {page_file}", soft_wrap=True)


def _print(found: dict[str, Any]) -> None:
    balls, shift = found["ball_pass"], found["hub_shift"][0]
    rows = table(
        "Errors on turns after the calibration, ″ RMS",
        words(),
        *map(number, ("two heads", "four heads, mean")),
    )
    rows.add_row(
        "ball pass 0.25 µm, orders 2 and 3 of the axis, 0.1″ of noise",
        f"{balls['two_heads_rms_arcsec']:.3f}",
        f"{balls['mean_rms_arcsec']:.3f}",
    )
    rows.add_row(
        "change when the disc's centre moves by 2 µm",
        f"{shift['on_head1_rms_arcsec']:.3f}",
        f"{shift['on_mean_rms_arcsec']:.4f}",
    )
    for one in found["missing"][1:]:
        rows.add_row(f"without head {one['missing']}", "", f"{one['rms_arcsec']:.3f}")
    console.print(rows)
