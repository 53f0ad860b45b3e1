"""arctrue alpha: the choice of the angle between two heads, of lanes and of bits."""

from __future__ import annotations

from pathlib import Path

import click

from arctrue.cli._loaded_set import console, for_people, write_json, write_page
from arctrue.cli._numbers import Finite
from arctrue.cli._options import json_option, page_option
from arctrue.cli._outputs import OutputFolder
from arctrue.cli._tables import number, table
from arctrue.report.numbers import plain


@click.command(short_help="Choose the angle between two heads for given orders.")
@click.option(
    "--alpha",
    "alpha_deg",
    type=Finite(min=1.0, max=359.0),
    default=33.0,
    show_default=True,
    help="Angle to judge beside the best ones, degrees.",
)
@click.option(
    "--orders",
    type=click.IntRange(2, 1000),
    multiple=True,
    help="Judge orders 1 to N; may be repeated.  [default: 10, 12, 20, 32, 40, 64]",
)
@json_option
@page_option
@click.option("--out", type=OutputFolder(), help="Folder for the maps.")
@for_people
def alpha(
    alpha_deg: float,
    orders: tuple[int, ...],
    json_file: Path | None,
    page_file: Path | None,
    out: Path | None,
) -> None:
    """Give noise gain, blind orders and sensitivity to α, and the best α for orders 1 to N.

    The same for lanes and bits: what they leave of the paper's table.
    """
    from arctrue.studies.head_angle.choose import ORDERS, choose

    asked = sorted({*orders, 40}) if page_file is not None and orders else orders
    found = plain(choose(alpha_deg, tuple(asked) or ORDERS))
    headings = ("orders", "α", "worst gain", "order 1", "noise ″", "mounting ″", "blind")
    gains = table("Two heads: noise gain by α", *map(number, headings))
    for choice in found["choices"]:
        for one in (choice["given"], *choice["best"]):
            worst = one["worst_gain"]
            gains.add_row(
                f"1 to {choice['most_order']}",
                f"{one['alpha_deg']:.3f}°",
                "∞" if worst is None else f"{worst:.3g} at {one['worst_order']}",
                f"{one['gain_first']:.2f}",
                "∞" if one["noise_arcsec"] is None else f"{one['noise_arcsec']:.4f}",
                "∞" if one["by_mounting_arcsec"] is None else f"{one['by_mounting_arcsec']:.4f}",
                ", ".join(map(str, one["blind"][:3])),
            )
        gains.add_section()
    console.print(gains)
    write_json(json_file, found)
    if page_file is not None or out is not None:
        from arctrue.report.alpha_page import alpha_page, plot_alpha

        write_page(found, page_file, alpha_page, out, plot_alpha)
