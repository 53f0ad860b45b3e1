"""arctrue methods: compares methods of calibration on the same simulated table."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from arctrue.base.figures import figure
from arctrue.cli._loaded_set import console, for_people, write_json, write_page
from arctrue.cli._numbers import SEED, Finite
from arctrue.cli._options import json_option, page_option
from arctrue.cli._outputs import OutputFolder
from arctrue.cli._progress import Progress
from arctrue.cli._tables import number, table, words

LEAST_MINUTES = 8.0
"""Smallest measuring time, minutes: five cycles of the polygon; in fewer cycles the polygon's
mountings do not reach all faces."""


@click.command(short_help="Compare calibration methods on the same simulated table.")
@click.option(
    "--minutes",
    type=Finite(min=LEAST_MINUTES, max=120.0),
    default=16.0,
    show_default=True,
    help="Measuring time of each method, minutes.",
)
@click.option("--seed", type=SEED, default=1, show_default=True, help="Seed of noise and mounting.")
@json_option
@page_option
@click.option("--out", type=OutputFolder(), help="Folder for the picture.")
@for_people
def methods(
    minutes: float, seed: int, json_file: Path | None, page_file: Path | None, out: Path | None
) -> None:
    """Compare reference, closure, equal division, free spin, and two to four heads or their mean.

    Each method measures the same simulated table with the same noise for the same time. The study
    compares the corrected angle of each method with the true angle.
    """
    from arctrue.studies.methods.compare import compare_methods
    from arctrue.studies.methods.world import MethodsSettings

    with Progress("measuring") as step:
        found = compare_methods(MethodsSettings.compared(minutes, seed), step.now)
    _print(found)
    write_json(json_file, found)
    if page_file is not None or out is not None:
        from arctrue.report.charts.methods_picture import plot_methods
        from arctrue.report.methods_page import methods_page

        write_page(found, page_file, methods_page, out, plot_methods)


def _print(found: dict[str, Any]) -> None:
    left = table(
        "Error after correction, ″",
        words("method"),
        words("output"),
        *map(number, ("heads", "range", "RMS", "axis\nat rest", "later")),
    )
    raw = found["uncorrected"]
    left.add_row(
        "uncorrected", "head 1", "1", _span(raw["span_arcsec"]), figure(raw["rms_arcsec"], 2), "",
        figure(raw["rms_later_arcsec"], 2),
    )  # fmt: skip
    for one in found["methods"]:
        left.add_row(
            one["title"],
            one["output"],
            str(one["heads"]),
            _span(one["span_arcsec"]),
            figure(one["rms_arcsec"], 3),
            figure(one["rms_without_motion_arcsec"], 3),
            figure(one["rms_later_arcsec"], 3),
        )
    console.print(left)
    for one in found["places"]:
        worst = one["worst_gain_to_128"]
        console.print(
            f"{one['title']} at {', '.join(f'{p:g}°' for p in one['places_deg'])}: worst noise "
            f"gain to order 128 {'∞ (not seen)' if worst is None else f'{worst:.2f}'}",
            soft_wrap=True,
        )


def _span(values: list[float]) -> str:
    return f"[{figure(values[0], 2)}, {figure(values[1], 2)}]"
