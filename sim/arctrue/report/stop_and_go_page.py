"""Makes the page of ``arctrue stop-and-go`` from its result."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from arctrue.report.charts.stop_and_go_picture import PICTURE


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
            "`arctrue stop-and-go` simulates the paper's ten cycles with a servo: the servo moves "
            f"the table to each of {printed['faces']} faces, the table stops, and the",
            "autocollimator reads the face. (On the page [The paper, point by point](paper.md) the "
            "table does not stop at the faces.) The command runs the cycles twice, with",
            "head 1's signal and with the corrected signal as the servo's feedback. The command "
            "makes this page from [stop-and-go.json](data/stop-and-go.json).",
            "",
            "```sh",
            ".venv/bin/arctrue stop-and-go --page docs/stop-and-go.md "
            "--json docs/data/stop-and-go.json --out docs/images",
            "```",
            "",
            "| Part | Settings |",
            "|---|---|",
            f"| axis | moment of inertia {axis['inertia_kg_m2']:g} kg m²; friction (LuGre) "
            f"{axis['coulomb_n_m']:g} N m in motion and {axis['static_n_m']:g} N m at rest; motor "
            f"torque up to {axis['torque_limit_n_m']:g} N m |",
            f"| controller | sampled at {controller['rate_hz'] / 1000:g} kHz: position loop with "
            f"{controller['position_1_s']:g} 1/s around a speed loop with integral action |",
            "| moves | 15° at up to 30°/s and 120°/s², then 0.8 s to settle and 0.2 s to read |",
            f"| signal | 2²⁴ counts per turn, {given['noise_arcsec']:g}″ of noise on each reading; "
            f"the correction has {found['orders_applied']} orders from one captured turn, in the "
            "gateware's number formats |",
            "",
            "| Result, in ″ where no unit is given | paper | feedback: head 1's signal | feedback: "
            "corrected signal |",
            "|---|---|---:|---:|",
            f"| error measured with polygon and autocollimator | [−150.0, 137.9] → [−1.3, 1.6] | "
            f"{_span(raw['mean_arcsec'])} | {_span(corrected['mean_arcsec'])} |",
            f"| true error of the table, minus its mean | not known | "
            f"{_span(raw['true_mean_arcsec'])} | {_span(corrected['true_mean_arcsec'])} |",
            f"| largest σ of a face, (13) | 0.2 | {max(raw['deviation_arcsec']):.2f} | "
            f"{max(corrected['deviation_arcsec']):.2f} |",
            row("repeatability u₃", "0.2", "repeatability_arcsec"),
            row("expanded uncertainty U, k = 2, (17)", "0.46", "expanded_arcsec"),
            row("movement of the table during a reading, median", "not stated", "tremble_arcsec"),
            row("offset common to all faces, subtracted", "not stated", "common_arcsec"),
            row("largest following error", "not stated", "following_arcsec", 0),
            row("settling time to within 5 counts, median, s", "not stated", "settled_s"),
            "",
            f"![Error at the faces, raw and corrected](images/{PICTURE})",
            "",
            "- Sign: if the signal is too large by ε, the servo stops the table at target − ε.",
            "- The servo increases the scatter, but hardly the mean error: its integral action "
            "brings the mean of the signal to the target.",
            "- The correction changes by less than 0.001° per degree of rotation; therefore the "
            "following error and the settling time are the same with both signals.",
            "- The offset common to all faces is a₀ of equation (9), the error at the index mark. "
            "Two heads do not determine a₀, and the autocollimator's zero",
            "  removes the offset. All moves have the same direction; therefore the offset also "
            "contains the table's creep after a move, until the integral action balances",
            "  the friction.",
            "- The gateware's latency has no effect: it is 0.4 µs, the controller samples every "
            f"{1e6 / controller['rate_hz']:.0f} µs, and the table is at rest during a reading.",
            "- Gains, friction and inertia are assumed values, not from a real table. Every move "
            "begins at rest at the previous face, so that all moves can be simulated in parallel.",
            "",
        ]
    )


def _span(values: list[float]) -> str:
    return f"[{min(values):.2f}, {max(values):.2f}]"
