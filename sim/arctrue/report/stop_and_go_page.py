"""Makes the page and the picture of ``arctrue stop-and-go`` from its result."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from arctrue.report.picture_file import save_picture
from arctrue.report.svg import AFTER, BEFORE, LIMIT, house_style

PICTURE = "stop_and_go.svg"


def stop_and_go_page(found: Mapping[str, Any]) -> str:
    """Return the page as Markdown."""
    raw, corrected = found["raw"], found["corrected"]
    printed, given = found["published"], found["settings"]
    axis, controller = given["axis"], given["controller"]

    def row(label: str, paper: str, key: str, digits: int = 2) -> str:
        values = (f"{one[key]:.{digits}f}" for one in (raw, corrected))
        return f"| {label} | {paper} | {' | '.join(values)} |"

    return "\n".join(
        [
            "# Stop and go",
            "",
            "This page simulates the paper's ten cycles with a servo: the servo moves the table to "
            f"each of {printed['faces']} faces, the table stops, and the",
            "autocollimator reads the face. ([The paper, point by point](paper.md) reads the faces "
            "in passing.) The servo's feedback is first head 1's",
            "own signal, then the corrected one. The command makes this page from "
            "[stop-and-go.json](data/stop-and-go.json).",
            "",
            "```sh",
            ".venv/bin/arctrue stop-and-go --page docs/stop-and-go.md "
            "--json docs/data/stop-and-go.json --out docs/images",
            "```",
            "",
            "| | |",
            "|---|---|",
            f"| axis | {axis['inertia_kg_m2']:g} kg m², friction {axis['coulomb_n_m']:g} N m and "
            f"{axis['static_n_m']:g} N m at rest (LuGre), motor to "
            f"{axis['torque_limit_n_m']:g} N m |",
            f"| controller | {controller['rate_hz'] / 1000:g} kHz: position loop "
            f"{controller['position_1_s']:g} 1/s around a speed loop with integral |",
            "| moves | 15° at 30°/s and 120°/s², 0.8 s to settle, 0.2 s to read |",
            f"| signal | 2²⁴ counts a turn, {given['noise_arcsec']:g}″ of noise on each reading; "
            f"{found['orders_applied']} orders from one captured turn, in the gateware's formats |",
            "",
            "| ″ | paper | head 1's signal | corrected |",
            "|---|---|---:|---:|",
            f"| error by polygon and autocollimator | [−150.0, 137.9] → [−1.3, 1.6] | "
            f"{_span(raw['mean_arcsec'])} | {_span(corrected['mean_arcsec'])} |",
            f"| true error of the table (less its mean) | not known | "
            f"{_span(raw['true_mean_arcsec'])} | {_span(corrected['true_mean_arcsec'])} |",
            f"| largest σ of a face, (13) | 0.2 | {max(raw['deviation_arcsec']):.2f} | "
            f"{max(corrected['deviation_arcsec']):.2f} |",
            row("u₃ repeatability", "0.2", "repeatability_arcsec"),
            row("U expanded, k = 2, (17)", "0.46", "expanded_arcsec"),
            row("movement of the table during a reading, median", "not stated", "tremble_arcsec"),
            row(
                "offset common to all faces, subtracted as the zero", "not stated", "common_arcsec"
            ),
            row("largest following error", "not stated", "following_arcsec", 0),
            row("settled after, s (within 5 counts), median", "not stated", "settled_s"),
            "",
            f"![Error at the faces, raw and corrected](images/{PICTURE})",
            "",
            "- Sign: if the signal reads too much by ε, the table stops at target − ε.",
            "- The servo adds to the scatter and hardly to the error: its integral brings the mean "
            "of the reading to the target.",
            "- The correction changes by less than 0.0003° in a degree, so that following error "
            "and settling equal those of head 1's signal.",
            "- The offset common to all faces is the zero: the error at the index mark, a₀ of (9), "
            "which two heads cannot see and the",
            "  autocollimator's zero removes. All moves have the same direction, so that the "
            "offset also contains the creep after a move, while",
            "  the integral releases the friction.",
            "- Latency has no effect: 0.4 µs against a controller's sample of "
            f"{1e6 / controller['rate_hz']:.0f} µs, at rest.",
            "- Gains, friction and inertia are of no particular table. Every move begins at rest "
            "at the previous face, so that all moves are simulated in parallel.",
            "",
        ]
    )


def plot_stop_and_go(found: Mapping[str, Any], folder: Path) -> Path:
    """Draw the errors at the faces as the reference instruments measure them, and the true
    errors."""
    path = folder / PICTURE
    faces = np.arange(len(found["raw"]["mean_arcsec"])) * 15.0
    with house_style():
        figure = Figure(figsize=(9.0, 5.6), layout="constrained")
        whole, enlarged = figure.subplots(2, 1, sharex=True)
        for name, colour, label in (
            ("raw", BEFORE, "head 1's signal"),
            ("corrected", AFTER, "corrected"),
        ):
            whole.plot(faces, found[name]["mean_arcsec"], "o-", color=colour, label=label)
        enlarged.errorbar(
            faces,
            found["corrected"]["mean_arcsec"],
            yerr=found["corrected"]["deviation_arcsec"],
            fmt="o-",
            color=AFTER,
            capsize=2,
            label="by polygon and autocollimator; bars: σ",
        )
        true = np.asarray(found["corrected"]["true_mean_arcsec"])
        enlarged.plot(faces, true, "s--", color=LIMIT, markersize=3, label="true")
        whole.set_title("Error at 24 faces, stop and go")
        for axes in (whole, enlarged):
            axes.set_ylabel("error, ″")
            axes.legend(fontsize=8)
        enlarged.set_xlabel("target, °")
        enlarged.set_xticks(range(0, 361, 45))
        return save_picture(figure, path)


def _span(values: list[float]) -> str:
    return f"[{min(values):.2f}, {max(values):.2f}]"
