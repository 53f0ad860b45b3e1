"""The page and the picture of ``arctrue methods``, from its result as plain values."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from arctrue.report.legend_below import legend_below
from arctrue.report.log_scale import set_log_y
from arctrue.report.picture_file import save_picture
from arctrue.report.svg import AFTER, BEFORE, LIMIT, house_style

PICTURE = "methods.svg"
SHOWN = ("two_heads_dft", "two_heads_least_squares", "three_heads_least_squares",
         "four_heads_least_squares")  # fmt: skip
SMALLEST_ARCSEC = 1e-4
"""Lower end of the picture's scale."""


def methods_page(found: Mapping[str, Any]) -> str:
    """The page, Markdown."""
    given = found["settings"]
    raw = found["uncorrected"]
    rows = [
        f"| {one['title']} | {one['heads']} | {_span(one['span_arcsec'])} | "
        f"{one['rms_arcsec']:.3f} | {one['rms_without_motion_arcsec']:.3f} | {_largest(one)} |"
        for one in found["methods"]
    ]
    needs = [
        f"| {one['title']} | {one['needs']} | {one['cannot_see']} | {one['source']} |"
        for one in found["methods"]
    ]
    heads = [
        f"| {one['title']} | {', '.join(f'{p:g}°' for p in one['places_deg'])} | "
        f"{_gain(one['gain'][0])} | {_gain(one['gain_weak_order'])} | "
        f"{_gain(one['worst_gain_to_40'])} | {_gain(one['worst_gain_to_128'])} | "
        f"{_gain(one['gain_blind_order'])} |"
        for one in found["places"]
    ]
    return "\n".join(
        [
            "# Every method on the same table",
            "",
            "`arctrue methods` measures one simulated table by every method of the paper's "
            "introduction and scores",
            "each correction against the true angle, which no method sees. This page is made by it "
            "from",
            "[methods.json](data/methods.json).",
            "",
            "```sh",
            ".venv/bin/arctrue methods --page docs/methods.md --json docs/data/methods.json "
            "--out docs/images",
            "```",
            "",
            f"The same for all: {given['minutes']:g} minutes of measurement "
            f"({given['turns']} turns at {given['speed_deg_s']:g}°/s, or {given['cycles']} cycles "
            f"of 24 faces, {given['station_s']:g} s each),",
            f"{given['noise_arcsec']:g}″ of noise on a reading of a head, "
            f"{given['scatter_arcsec']:g}″ on a reading of the autocollimator, heads mounted to "
            "± 50″, index marks good to ± 1 count,",
            f"a speed ripple of {given['ripple_rad'] * given['ripple_order'] * 100:.1f} %, the "
            "instruments of the paper's Table 3. The disc is that of "
            "[`arctrue revolution`](instrument.md)",
            "with orders 11 (0.4″), 12 (0.2″), 24 (0.3″) and 120 (0.2″) that are hard for one "
            "method or another. The axis moves by "
            f"{given['radial_motion_m'] * 1e6:g} µm at order 2",
            "on a line and by half of it at order 3 on a circle. Every method fits orders 1 to "
            f"{given['most_order']} and 120 where it can.",
            "",
            f"Uncorrected: {_span(raw['span_arcsec'])}″, {raw['rms_arcsec']:.2f}″ RMS.",
            "",
            "| Method | Heads | Left, ″ | RMS, ″ | RMS, axis at rest, ″ | Largest orders left, ″ |",
            "|---|---:|---:|---:|---:|---|",
            *rows,
            "",
            "| Method | Needs | Cannot see | Source |",
            "|---|---|---|---|",
            *needs,
            "",
            "Numbers in brackets are those of the paper's references. One draw of noise and "
            "mounting: `--seed` makes another.",
            "",
            f"![What is left at every order](images/{PICTURE})",
            "",
            "## How many heads",
            "",
            "Noise of an order over the noise of one head's reading, for heads at the best places, "
            "degrees from head 1 (orders 1 to 128",
            "searched; the first two are the paper's). ∞: not seen. A motion of the axis of "
            "order 1 is the same as an eccentric disc, for any number of heads.",
            "",
            "| | Places | Order 1 | Order 11 | Worst to 40 | Worst to 128 | Order 120 |",
            "|---|---|---:|---:|---:|---:|---:|",
            *heads,
            "",
            *_verdict(found),
            "",
        ]
    )


def _verdict(found: Mapping[str, Any]) -> list[str]:
    """What the figures say of a third and a fourth head."""
    by_name = {one["name"]: one for one in found["methods"]}
    two, three, four = (by_name[name] for name in SHOWN[1:])
    pair, third, _, fourth = found["places"]
    return [
        f"- **A third head** at {third['places_deg'][2]:g}° takes the blind orders away: the worst "
        f"gain to order 40 falls from {_gain(pair['worst_gain_to_40'])} to "
        f"{_gain(third['worst_gain_to_40'])}, order 120 is seen.",
        f"  With the axis at rest the error falls from {two['rms_without_motion_arcsec']:.3f}″ to "
        f"{three['rms_without_motion_arcsec']:.3f}″ RMS; nearly all of that is order 120.",
        "- **It does not separate the axis' motion from the disc.** At one order, three readings "
        "show three numbers, and the table's own motion",
        "  and the two circles of the axis already take all three. With the bearing that moves, "
        f"{three['rms_arcsec']:.3f}″ are left, with two heads {two['rms_arcsec']:.3f}″.",
        f"- **A fourth head** does: {four['rms_arcsec']:.3f}″ with the same bearing, and the worst "
        f"gain is {_gain(fourth['worst_gain_to_128'])} although the motion is unknown.",
        "- So the gateware's next step is four heads, or it stays with two: a third pays for weak "
        "and blind orders alone, which a table",
        "  with a smooth disc does not have.",
    ]


def plot_methods(found: Mapping[str, Any], folder: Path) -> Path:
    """Residual of every method by order, and the gain of two, three and four heads."""
    path = folder / PICTURE
    with house_style():
        figure = Figure(figsize=(9.6, 8.2), layout="constrained")
        table, gains = figure.subplots(2, 1, height_ratios=[3, 2])
        entries = found["methods"]
        amplitude = np.array([one["amplitude_arcsec"] for one in entries])
        image = table.imshow(
            np.log10(np.maximum(amplitude[:, :40], SMALLEST_ARCSEC)),
            aspect="auto",
            cmap="magma_r",
            extent=(0.5, 40.5, len(entries) - 0.5, -0.5),
            vmin=np.log10(SMALLEST_ARCSEC),
            vmax=0.0,
            interpolation="nearest",
        )
        table.set_yticks(range(len(entries)), [one["title"] for one in entries], fontsize=8)
        table.set_xlabel("order")
        table.grid(visible=False)
        table.set_title("What each method leaves, amplitude by order")
        bar = figure.colorbar(image, ax=table, pad=0.01, ticks=[-4, -3, -2, -1, 0])
        bar.ax.set_yticklabels(["10⁻⁴″", "10⁻³″", "0.01″", "0.1″", "1″"])
        colours = (BEFORE, LIMIT, "#3a7d44", AFTER)
        for one, colour in zip(found["places"], colours, strict=True):
            gain = [np.nan if value is None else value for value in one["gain"]]
            places = ", ".join(f"{p:g}°" for p in one["places_deg"])
            gains.plot(
                range(1, len(gain) + 1), gain, color=colour, linewidth=1.2,
                label=f"{one['title']}: {places}",
            )  # fmt: skip
        set_log_y(gains)
        gains.set_xlabel("order")
        gains.set_ylabel("noise over that of a head")
        gains.set_title("Noise gain of two, three and four heads (gap: not seen)")
        legend_below(gains, columns=2)
        return save_picture(figure, path)


def _span(values: list[float]) -> str:
    return f"[{values[0]:.3f}, {values[1]:.3f}]"


def _gain(value: float | None) -> str:
    return "∞" if value is None else f"{value:.2g}" if value < 10 else f"{value:.0f}"


def _largest(one: Mapping[str, Any]) -> str:
    amplitude = np.asarray(one["amplitude_arcsec"])
    worst = np.argsort(-amplitude)[:3]
    return ", ".join(f"{order + 1}: {amplitude[order]:.3f}" for order in worst)
