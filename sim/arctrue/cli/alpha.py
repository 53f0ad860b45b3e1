"""arctrue alpha: chooses the places of two to four heads, and the numbers of lanes and bits."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import click

from arctrue.base.json_text import plain
from arctrue.cli._loaded_set import console, for_people, write_json, write_page
from arctrue.cli._numbers import Finite
from arctrue.cli._options import json_option, page_option, refuse_given
from arctrue.cli._orders import Orders
from arctrue.cli._outputs import OutputFolder
from arctrue.cli._places import Places
from arctrue.cli._tables import number, table


@click.command(short_help="Choose the places of two to four heads for given orders.")
@click.option(
    "--heads",
    type=click.IntRange(2, 4),
    default=2,
    show_default=True,
    help="Number of heads. 2: compare angles α; 3 or 4: compare places of all heads.",
)
@click.option(
    "--places",
    "places_deg",
    type=Places(),
    metavar="0,P2,P3[,P4]",
    help="Places of the heads to compare with the best ones, degrees (with --heads 3 or 4).",
)
@click.option(
    "--alpha",
    "alpha_deg",
    type=Finite(min=1.0, max=359.0),
    default=33.0,
    show_default=True,
    help="Angle to compare with the best ones, degrees.",
)
@click.option(
    "--orders",
    type=Orders(),
    multiple=True,
    metavar="N|LIST",
    help="Evaluate orders 1 to N, or the orders of a list such as 2-8,12,24; repeatable.  "
    "[default: 10, 12, 20, 32, 40, 64; with --heads 3 or 4: 40, 64]",
)
@json_option
@page_option
@click.option("--out", type=OutputFolder(), help="Folder for the maps.")
@for_people
def alpha(
    heads: int,
    places_deg: tuple[float, ...] | None,
    alpha_deg: float,
    orders: tuple[int | tuple[int, ...], ...],
    json_file: Path | None,
    page_file: Path | None,
    out: Path | None,
) -> None:
    """Print noise gain, unseen orders and mounting error at α, and the best α for orders 1 to N.

    The page of --page also states the error that remains on the paper's table for each number of
    lanes and bits. With --heads 3 or 4 the command prints the places with the least noise gain for
    orders 1 to N. At these places the mean of all heads, and of any three of four, has less noise
    than one head. With a list in --orders the command prints the best places for these orders.
    With four heads it ignores order 1, which the mean of four heads does not contain.
    """
    from arctrue.studies.head_angle.choose import ORDERS, PLACES_ORDERS, choose, choose_places

    if heads > 2 or any(isinstance(one, tuple) for one in orders):
        if page_file is not None or out is not None:
            raise ValueError(
                "--page and --out need --heads 2, and no list of orders; that page covers 3 and 4 "
                "heads too"
            )
        if heads > 2:
            refuse_given(
                ("alpha_deg",), "is for two heads; --places states the places of more heads"
            )
        elif places_deg is None:
            places_deg = (0.0, alpha_deg)
        judged = plain(choose_places(heads, orders or PLACES_ORDERS, places_deg))
        console.print(_of_places(judged, heads))
        write_json(json_file, judged)
        return
    if places_deg is not None:
        raise ValueError("--places needs --heads 3 or 4, or a list of orders")
    most = [one for one in orders if isinstance(one, int)]
    asked = sorted({*most, 40}) if page_file is not None and most else most
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
    if page_file is not None or out is not None:
        from arctrue.report.alpha_page import alpha_page, plot_alpha

        for number_of_heads in (3, 4):
            found.setdefault("places", []).extend(plain(choose_places(number_of_heads))["places"])
        write_page(found, page_file, alpha_page, out, plot_alpha)
    write_json(json_file, found)


def _of_places(judged: Mapping[str, Any], heads: int) -> Any:
    headings = ["orders", "places", "worst gain"]
    if heads > 2:
        headings += ["noise of\nthe mean", "one head\nmissing"]
    shown = table("Places of the heads, degrees after head 1", *map(number, headings))
    for choice in judged["places"]:
        for one in (choice["given"], *choice["best"]):
            if one is None:
                continue
            worst = one["worst_gain"]
            cells = [
                _of_orders(choice),
                ", ".join(f"{place:g}" for place in one["places_deg"]),
                "∞" if worst is None else f"{worst:.3g} at {one['worst_order']}",
            ]
            if heads > 2:
                without = [value for value in one["noise_without"] if value is not None]
                cells += [
                    "∞" if one["mean_noise"] is None else f"{one['mean_noise']:.3f}",
                    f"{max(without):.2f}" if len(without) == heads else "no mean",
                ]
            shown.add_row(*cells)
        shown.add_section()
    return shown


def _of_orders(choice: Mapping[str, Any]) -> str:
    """Return the orders that count, with dashes for three or more consecutive orders."""
    if "orders" not in choice:
        return f"{2 if choice['heads'] == 4 else 1} to {choice['most_order']}"
    parts: list[list[int]] = []
    for order in choice["orders"]:
        if parts and order == parts[-1][-1] + 1:
            parts[-1].append(order)
        else:
            parts.append([order])
    return ", ".join(
        f"{part[0]}-{part[-1]}" if len(part) > 2 else ", ".join(map(str, part)) for part in parts
    )
