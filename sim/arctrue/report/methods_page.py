"""Makes the page and the picture of ``arctrue methods`` from its result."""

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
SMALLEST_ARCSEC = 1e-4
"""Lower end of the picture's scale."""
NOT_BUILT = (
    ("Ring laser gyroscope [2]", "another reference instrument, not a calibration from readings"),
    ("EDA with fewer heads at chosen places [6]",
     "not as cited; the means of four heads at uneven places show what such places do"),
    ("VEDA [7]",
     "as the paper describes it, its correction is that of the transfer function with the nominal "
     "α to 10⁻¹³: the row *α nominal*"),
    ("Filtering the moiré signals [10], correcting the signals' offset, gain and phase [12]",
     "act on the sine and cosine of a head before the counter; the world has no error within a "
     "line (effect `subdivision_error`)"),
    ("RBF neural network [11]",
     "a smooth curve through the errors that a reference shows: between the faces it knows no "
     "more than the harmonics from a reference"),
    ("Radial code tracks beside the scale [13]", "another disc"),
    ("Three calibration heads and one that measures [14]",
     "the rows of four heads by least squares, whose output is head 1"),
    ("Polynomial fit [16]", "of linear encoders over temperature; a turn is periodic"),
)  # fmt: skip
"""Methods of the paper's introduction that have no row, and the reason."""


def methods_page(found: Mapping[str, Any]) -> str:
    """Compose the page in Markdown."""
    given = found["settings"]
    raw = found["uncorrected"]
    rows = [
        f"| {one['title']} | {one['heads']} | {one['output']} | {_span(one['span_arcsec'])} | "
        f"{one['rms_arcsec']:.3f} | {one['rms_without_motion_arcsec']:.3f} | "
        f"{one['rms_later_arcsec']:.3f} | {_largest(one)} |"
        for one in found["methods"]
    ]
    needs = [
        f"| {one['title']} | {one['needs']} | {one['cannot_see']} | {one['source']} |"
        for one in found["methods"]
    ]
    heads = [
        f"| {one['title']} | {', '.join(f'{p:g}°' for p in one['places_deg'])} | "
        f"{_gain(one['gain'][0])} | {_gain(one['gain_weak_order'])} | "
        f"{_gain(one['worst_gain_to_40'])} | {_gain(one['worst_gain_to_64'])} | "
        f"{_gain(one['worst_gain_to_128'])} | {_gain(one['gain_blind_order'])} | "
        f"{'–' if one['mean_noise'] is None else format(one['mean_noise'], '.2f')} |"
        for one in found["places"]
    ]
    return "\n".join(
        [
            "# Methods on the same table",
            "",
            "`arctrue methods` measures one simulated table by the methods of the paper's "
            "introduction and by means of several heads,",
            "and compares the corrected angle with the true angle, which no method knows. "
            "It made this page from",
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
            f"± 50″ and ± {given['radius_tolerance_m'] * 1e3:g} mm of radius, index",
            f"marks detected ± {given['index_detection_arcsec']:g}″ off and repeating to ± 1 "
            f"count, a speed ripple of {given['ripple_rad'] * given['ripple_order'] * 100:.1f} %, "
            "the instruments of the paper's Table 3, the friction of",
            "[stop and go](stop-and-go.md). The disc is that of "
            "[`arctrue revolution`](instrument.md) with orders 11 (0.4″), 12 (0.2″), 24 (0.3″) and "
            "120 (0.2″) that are",
            "hard for one method or another, and orders 47 (0.05″) and 77 (0.03″) that no method "
            "fits. The axis moves by "
            f"{given['radial_motion_m'] * 1e6:g} µm at order 2 on a line, by half",
            "of that at order 3 on a circle, and by 0.2 to 0.3 of that backwards at orders 1 and "
            "13 "
            "and forwards at 9. A method fits orders 1 to "
            f"{given['most_order']} and 120",
            "if it can, and applies orders with a noise gain up to 50.",
            "",
            "*Later*: the same calibration after heat has moved the disc's centre by 2 µm, and "
            "with a ball pass of the bearing of 0.25 µm (0.95″), some turns later.",
            f"Uncorrected: {_span(raw['span_arcsec'])}″, {raw['rms_arcsec']:.2f}″ RMS.",
            "",
            "| Method | Heads | Output | Error, ″ | RMS, ″ | RMS, axis at rest, ″ | RMS, later, ″ "
            "| Largest remaining orders, ″ |",
            "|---|---:|---|---:|---:|---:|---:|---|",
            *rows,
            "",
            "| Method | Needs | Cannot see | Source |",
            "|---|---|---|---|",
            *needs,
            "",
            "Numbers in brackets are those of the paper's references. One draw of noise and "
            "mounting: `--seed` makes another.",
            "",
            "These methods of the paper's introduction have no row of their own:",
            "",
            "| | |",
            "|---|---|",
            *(f"| {name} | {why} |" for name, why in NOT_BUILT),
            "",
            f"![Error of each method by order](images/{PICTURE})",
            "",
            "## How many heads",
            "",
            "Noise of an order over the noise of one head's reading; places in degrees from head "
            "1. ∞: not seen. *Mean*: noise of one reading of the",
            "weighted mean that is free of translations of the axis; –: there is no such mean.",
            "",
            "| | Places | Order 1 | Order 11 | Worst to 40 | to 64 | to 128 | Order 120 | Mean |",
            "|---|---|---:|---:|---:|---:|---:|---:|---:|",
            *heads,
            "",
            *_verdict(found),
            "",
        ]
    )


def _verdict(found: Mapping[str, Any]) -> list[str]:
    """State what a third and a fourth head and the mean contribute."""
    by_name = {one["name"]: one for one in found["methods"]}
    two, three, four = (by_name[f"{n}_heads_least_squares"] for n in ("two", "three", "four"))
    pair, third = found["places"][:2]
    listed, every = found["places"][3:5]
    plain, mean3 = by_name["mean_of_two"], by_name["mean_of_three_calibrated"]
    mean4 = by_name["mean_of_four_calibrated"]
    own = "; ".join(
        f"{one['motion']} {min(one['u_arcsec']):.0f} to {max(one['u_arcsec']):.0f}″"
        for one in found["own_places"]
    )
    return [
        f"- **A third head** at {third['places_deg'][2]:g}° removes the blind orders: the worst "
        f"gain to order 40 falls from {_gain(pair['worst_gain_to_40'])} to "
        f"{_gain(third['worst_gain_to_40'])}, order 120 is seen.",
        f"  With the axis at rest the error is {three['rms_without_motion_arcsec']:.3f}″ RMS, "
        "with two "
        f"heads {two['rms_without_motion_arcsec']:.3f}″. At an order at which the axis moves, "
        "three heads cannot separate axis and",
        "  disc: the table's motion and the two circles of the axis use up all three "
        f"readings ({three['rms_arcsec']:.3f}″ with the bearing that moves).",
        "  But three heads have a weighted mean that is free of any motion of the axis "
        f"({mean3['rms_later_arcsec']:.3f}″ before and after the disc's centre moves); its "
        "remaining error is motion that the calibration took for the disc.",
        "- **A fourth head** separates disc and axis. If the axis is known to move at "
        f"orders 1 to 8 alone the worst gain to 128 is {_gain(listed['worst_gain_to_128'])}; with "
        "unknown motion at every order it is",
        f"  {_gain(every['worst_gain_to_128'])} at these places, and other places are better. "
        "Head 1, "
        f"corrected with such a list, keeps {four['rms_arcsec']:.3f}″ from the orders outside the "
        f"list, and {four['rms_later_arcsec']:.3f}″ once the axis moves differently.",
        "- **Order 1 of the axis**: its forward circle looks like an eccentric disc, for any "
        "number of heads; its backward circle, or a line, does not, and four heads detect it.",
        f"- **The mean of four heads, calibrated**, keeps {mean4['rms_arcsec']:.3f}″, and "
        f"{mean4['rms_later_arcsec']:.3f}″ later: mostly the orders of the disc that were not "
        "fitted. Its disc error comes from the one",
        "  combination of four readings that contains neither the table's motion nor that of the "
        "axis. Uncalibrated means keep the disc error that all heads share "
        f"({plain['rms_arcsec']:.2f}″ with two at 180°).",
        "- The data determine the places of the heads only if the axis is known not to move at "
        "some orders of the disc; standard uncertainties from one turn, the axis at",
        f"  rest: {own}. With unknown motion at every order they are not determined, and the "
        "calibration "
        "refuses the request.",
        "  For the mean an error of 10″ of a place is harmless. Unequal radii add order 1 to the "
        "mean: "
        "they are unknowns of the calibration, determined as well as the axis is known to make no",
        "  backward circle once per turn.",
    ]


def plot_methods(found: Mapping[str, Any], folder: Path) -> Path:
    """Draw the residual of every method by order, and the gain of two, three and four heads."""
    path = folder / PICTURE
    with house_style():
        figure = Figure(figsize=(9.6, 9.6), layout="constrained")
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
        colours = (BEFORE, LIMIT, "#3a7d44", "#8a6fb0", AFTER, "#888888")
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
