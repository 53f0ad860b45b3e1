"""Makes the page and the picture of ``arctrue alpha`` from its result."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from arctrue.base.units import RAD_PER_ARCSEC
from arctrue.report.picture_file import save_picture
from arctrue.report.svg import BEFORE, house_style
from arctrue.studies.head_angle.maps import gain_map, sensitivity_map

PICTURE = "alpha_maps.png"
_ALPHA_STEP_DEG = 0.25
_ORDERS = np.arange(1, 65)


def alpha_page(found: Mapping[str, Any]) -> str:
    """Return the page as Markdown."""
    alpha = found["alpha_deg"]
    rows = []
    for choice in found["choices"]:
        for one, name in ((choice["given"], f"{alpha:g}°"), *((b, "best") for b in choice["best"])):
            rows.append(
                f"| 1 to {choice['most_order']} | {name} | {one['alpha_deg']:.3f}° | "
                f"{_gain(one['worst_gain'])} at {one['worst_order']} | {one['gain_first']:.2f} | "
                f"{one['rms_gain']:.2f} | {one['noise_arcsec']:.4f} | "
                f"{one['by_mounting_arcsec']:.4f} | "
                f"{', '.join(map(str, one['blind'][:3])) or 'none'} |"
            )
    bits = found["bits"]
    table = [
        f"| {width} | " + " | ".join(f"{value:.2g}" for value in line) + " |"
        for width, line in zip(bits["widths"], bits["residual_arcsec"], strict=True)
    ]
    lanes = [f"| {one['lanes']} | {one['residual_arcsec']:.3f} |" for one in found["lanes"]]
    given = {choice["most_order"]: choice for choice in found["choices"]}[40]
    best = given["best"][0]
    return "\n".join(
        [
            "# The angle between the heads",
            "",
            "`arctrue alpha` computes, for each order, how the angle α between two heads amplifies "
            "noise and an error of α, and which α is",
            "best for given orders. The command makes this page from "
            "[alpha.json](data/alpha.json).",
            "",
            "```sh",
            ".venv/bin/arctrue alpha --page docs/head-angle.md --json docs/data/alpha.json "
            "--out docs/images",
            "```",
            "",
            "Equation (6) of the [paper](paper.md) multiplies the noise of order n by the noise "
            "gain |TF(n)| = 1/(2 |sin(nα/2)|). An error Δα of α changes the amplitude of order n",
            "by the relative amount n·|TF(n)|·Δα. If n·α is near a whole number of turns, the two "
            "heads determine order n poorly or not at all.",
            "",
            f"![Noise gain and sensitivity over α and order](images/{PICTURE})",
            "",
            "## Which α",
            "",
            "The worst gain of the orders 1 to N is at least 1/(2 sin(π/(N + 1))). The reason: of "
            "the N + 1 points n·α, n = 0 … N, on a circle, two are at most",
            "360°/(N + 1) apart. α = 360°·k/(N + 1) reaches this limit for each k that has no "
            "common divisor with N + 1. Of these angles, the table below lists the three with the "
            "smallest error",
            "for the paper's rotary table that are at least 20°, the space that two heads need.",
            "",
            "- *Noise*: RMS over the turn of the error of these orders that 0.1″ of noise on each "
            "reading causes, for one captured turn of 12,000 samples.",
            "- *Mounting*: RMS of the error if the true α differs from the nominal α, which the "
            "calibration uses, by a random angle within ± 50″.",
            "- *Not determined*: the first orders up to 128 that two heads at α do not determine.",
            "",
            "| Orders | Choice | α | Worst gain | Gain, order 1 | RMS gain | Noise, ″ | Mounting, "
            "″ | Not determined |",
            "|---|---|---:|---:|---:|---:|---:|---:|---|",
            *rows,
            "",
            f"The paper's α = {alpha:g}° is 11/120 of a turn. This angle suits orders up to 10; at "
            "order 11, n·α is 363°, near a whole turn, so that the noise of order 11 is amplified",
            f"{_gain(given['given']['worst_gain'])} times. For orders 1 to 40, α = "
            f"{best['alpha_deg']:.2f}° ({best['alpha_deg'] - alpha:+.1f}°) reduces this worst gain "
            f"to {_gain(best['worst_gain'])}, and the error by mounting to",
            f"{best['by_mounting_arcsec'] / given['given']['by_mounting_arcsec']:.2f} of its size, "
            "because order 1, the largest error, needs heads that are far apart. The paper's "
            "sentence “smaller angular separation",
            "improves calibration accuracy” (2.1) is therefore not true for n = 1: see "
            "[errata](errata.md). A third head improves the result more than any choice of α: see "
            "[methods](methods.md#how-many-heads).",
            "",
            *_places(found.get("places", [])),
            "## How many lanes, how many bits",
            "",
            "In this simulation the error of the paper's rotary table is corrected with exact "
            "coefficients. The first table shows the RMS of the orders that have no lane (a lane "
            "is the circuit for one order).",
            "",
            "| Lanes | Remaining error, ″ RMS |",
            "|---:|---:|",
            *lanes,
            "",
            "The second table shows the RMS of the remaining error in ″ with all lanes and the "
            "bit-true CORDIC, for the width of the CORDIC's cosine (rows) and the number of its "
            "iterations (columns).",
            "In each case the rounding of the corrected angle to a count adds "
            f"{found['rounding_arcsec']:.3f}″. The paper and this implementation use 18 bits and "
            "16 iterations.",
            "",
            "| Bits | " + " | ".join(map(str, bits["iterations"])) + " |",
            "|---:|" + "---:|" * len(bits["iterations"]),
            *table,
            "",
        ]
    )


def _places(choices: Sequence[Mapping[str, Any]]) -> list[str]:
    """Return the section about three and four heads."""
    if not choices:
        return []
    rows = [
        f"| {choice['heads']} | {2 if choice['heads'] == 4 else 1} to {choice['most_order']} | "
        f"{', '.join(f'{place:g}°' for place in one['places_deg'])} | "
        f"{_gain(one['worst_gain'])} at {one['worst_order']} | {one['mean_noise']:.2f} | "
        f"{_without(one)} |"
        for choice in choices
        for one in choice["best"][:2]
    ]
    return [
        "## Three and four heads",
        "",
        "`arctrue alpha --heads 4 --orders 64` searches the best places (angles) of all heads, "
        "first in steps of 4° and then in smaller steps, with the heads at least 20° apart;",
        "other places can be equally good. `--orders 2-8,12,24` lists orders; "
        "`--places 0,64.3,177,257.9` evaluates given places.",
        "",
        "- *Worst gain* is the largest noise of an order of the disc, divided by the noise of one "
        "head. For three heads the axis is assumed at rest; for four heads axis motion is unknown",
        "  at every order, and the orders begin at 2, because the mean does not contain order 1.",
        "- *Mean* is √Σwᵢ² of the weighted mean that is free of axis translation. *One missing* is "
        "the same value without one head, in the worst case.",
        "  Three heads have no mean without one head. The search accepts only places at which "
        "*Mean* and, for four heads, *One missing* are at most 0.85.",
        "",
        "| Heads | Orders | Places after head 1 | Worst gain | Mean | One missing |",
        "|---:|---|---|---:|---:|---:|",
        *rows,
        "",
    ]


def _without(one: Mapping[str, Any]) -> str:
    noises = one["noise_without"]
    return "no mean" if None in noises else f"{max(noises):.2f}"


def plot_alpha(found: Mapping[str, Any], folder: Path) -> Path:
    """Draw two maps over α and order: the noise gain and the sensitivity to α."""
    path = folder / PICTURE
    alpha = np.arange(_ALPHA_STEP_DEG, 180.0 + _ALPHA_STEP_DEG, _ALPHA_STEP_DEG)
    with house_style():
        figure = Figure(figsize=(9.6, 8.4), layout="constrained")
        top, bottom = figure.subplots(2, 1, sharex=True)
        for axes, values, title, high in (
            (top, gain_map(alpha, _ORDERS), "Noise gain |TF(n)|; dark: poorly determined", 2.0),
            (
                bottom,
                sensitivity_map(alpha, _ORDERS) * 10.0 * RAD_PER_ARCSEC * 1e3,
                "Error of an order if α is wrong by 10″, ‰ of the amplitude",
                2.0,
            ),
        ):
            image = axes.imshow(
                np.log10(np.minimum(values, 1e6)).T,
                origin="lower",
                aspect="auto",
                cmap="viridis_r",
                extent=(0.0, 180.0, 0.5, _ORDERS[-1] + 0.5),
                vmin=-0.3,
                vmax=high,
                interpolation="nearest",
            )
            axes.grid(visible=False)
            axes.set_ylabel("order")
            axes.set_title(title)
            bar = figure.colorbar(image, ax=axes, pad=0.01, ticks=[-0.3, 0, 0.5, 1, 1.5, 2])
            bar.ax.set_yticklabels(["½", "1", "3", "10", "32", "≥ 100"])
            axes.axvline(found["alpha_deg"], color=BEFORE, linewidth=1.2)
            for choice in found["choices"]:
                best = choice["best"][0]
                axes.plot(
                    [best["alpha_deg"]] * 2, [1, best["most_order"]], color="black", linewidth=1.2
                )
        bottom.set_xlabel(
            f"α, °; red: {found['alpha_deg']:g}°; black: best α for the orders that the line spans"
        )
        return save_picture(figure, path, dots_per_inch=110)


def _gain(value: float | None) -> str:
    return "∞" if value is None else f"{value:.3g}"
