"""arctrue revolution: simulates two turns at the paper's size; the first turn is captured for the
calibration, the second turn is corrected."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from arctrue.base.figures import figure
from arctrue.cli._instrument import on_the_instrument
from arctrue.cli._loaded_set import console, for_people, write_json
from arctrue.cli._numbers import SEED
from arctrue.cli._options import json_option, lanes_option
from arctrue.cli._outputs import PICTURE_ENDINGS, OutputFile
from arctrue.cli._tables import number, table, words
from arctrue.cli._terminal import say, tell_error

if TYPE_CHECKING:
    from arctrue.studies.revolution import RevolutionResult

FULL_LINES = 16384
LEAST_LINES = 64
"""Smallest number of grating lines; with fewer lines, noise and quantisation alone exceed the
limits."""
FULL_LANES = 32
FULL_SAMPLES = 12000


@click.command(short_help="Calibrate a table of the paper's size, and correct it.")
@lanes_option(FULL_LANES)
@click.option(
    "--heads",
    type=click.Choice(["2", "4"]),
    default="2",
    show_default=True,
    help="Number of heads. 4: the firmware calibrates the mean of four heads.",
)
@click.option(
    "--lines",
    type=click.IntRange(LEAST_LINES, FULL_LINES),
    default=FULL_LINES,
    show_default=True,
    help="Lines of the disc, 1024 counts each. 1024 lines take a sixteenth of the time.",
)
@click.option(
    "--samples",
    type=click.IntRange(400, FULL_SAMPLES),
    default=FULL_SAMPLES,
    show_default=True,
    help="Number of samples captured per turn.",
)
@click.option(
    "--seed", type=SEED, default=1, show_default=True, help="Seed of the readings' noise."
)
@json_option
@click.option(
    "--picture", type=OutputFile(*PICTURE_ENDINGS), help="Write a picture (.svg, .png or .pdf)."
)
@for_people
def revolution(
    lanes: int,
    heads: str,
    lines: int,
    samples: int,
    seed: int,
    json_file: Path | None,
    picture: Path | None,
) -> None:
    """Capture a turn, calibrate it with the firmware's C, and measure the corrected next turn.

    Every edge of both heads passes the decoders of the compiled VHDL; the second turn is compared
    with the true angle. Exit code 1: the corrected output is outside its limit. 2: the instrument
    cannot run.
    """
    from arctrue.studies.revolution import RevolutionSettings, run_revolution

    settings = RevolutionSettings(
        heads=int(heads), lines=lines, lanes=lanes, samples=samples, seed=seed
    )
    with on_the_instrument() as shown:
        result = run_revolution(settings, report_run=shown.progress, report_step=shown.say)
    _print(result)
    write_json(json_file, result.as_json())
    if picture is not None:
        from arctrue.report.revolution_figure import plot_revolution

        picture.parent.mkdir(parents=True, exist_ok=True)
        plot_revolution(result, picture)
        say(f"wrote {picture}")
    for fault in result.faults:
        tell_error(str(fault))
    if result.faults:
        raise SystemExit(1)


def _heads_of(result: RevolutionResult) -> str:
    settings = result.settings
    if settings.heads == 2:
        return f"angle between the heads 33° + {settings.alpha_error_arcsec:g}″"
    heads = result.telemetry.get("mean_of_heads", 1)
    return f"mean of {heads} heads, each within 50″ of its planned place"


def _print(result: RevolutionResult) -> None:
    from arctrue.studies.revolution import PAPER_AFTER_ARCSEC, PAPER_BEFORE_ARCSEC

    settings = result.settings
    console.print(
        f"\n{settings.counts_per_rev:,} counts a turn ({settings.arcsec_per_count:.4f}″), "
        f"{result.telemetry['samples']:,} samples, {settings.lanes} lanes, "
        f"{result.applied_orders} orders applied; "
        f"{_heads_of(result)}, "
        f"noise {settings.noise_arcsec:g}″\n"
    )
    errors = table("Error against the true angle, ″", words(), *map(number, ("min", "max", "RMS")))
    for name, turn, paper in (
        ("before", result.before, PAPER_BEFORE_ARCSEC),
        ("after", result.after, PAPER_AFTER_ARCSEC),
    ):
        for kind, values in (
            ("means of half a degree", (turn.lowest_arcsec, turn.highest_arcsec, turn.rms_arcsec)),
            ("every edge", (*turn.every_edge_arcsec, None)),
            ("the paper (24 faces)", (*paper, None)),
        ):
            errors.add_row(f"{name}, {kind}", *(figure(value, 3) for value in values))
    console.print(errors)
    console.print(
        f"{result.clocks:,} clocks in {result.wall_s:.0f} s "
        f"({result.clocks / result.wall_s:,.0f} a second); "
        f"{'within' if not result.faults else 'outside'} ±{result.limit_arcsec:.2f}″"
    )
