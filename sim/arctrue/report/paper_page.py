"""Makes the page of ``arctrue paper``: equations, tables and figures, as published and as
reproduced."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from arctrue.base.units import arcsec_per_count
from arctrue.generated.number_formats import LANES_DEFAULT
from arctrue.report.charts.paper_drawings import DRAWINGS, drawing_name
from arctrue.report.paper_figures import figure_11_name

FULL, COARSE = 1024, 64
"""Interpolation factors of the paper and of the quick run."""
_OUTCOME = (
    ("u₁ polygon", "polygon_arcsec"),
    ("u₂ autocollimator", "autocollimator_arcsec"),
    ("u₃ repeatability (mean σ)", "repeatability_arcsec"),
    ("u₄ mounting eccentricity, (14)", "mounting_eccentricity_arcsec"),
    ("u₅ tower difference (pyramidal error), (15)", "tower_difference_arcsec"),
)
ROUNDING_DIVISOR = math.sqrt(12.0)


def paper_page(found: Mapping[str, Any]) -> str:
    """Return the page; ``found`` is the result of
    :func:`arctrue.studies.paper.page_items.paper_items`."""
    lines = [
        "# The paper, point by point",
        "",
        "This page compares the paper *Fully online calibration-compensation method for rotary "
        "table positioning error* (Shao, Zhu, Huang, Xue, Zhu)",
        "with this implementation. For each equation, table and figure the page states the result "
        "of this implementation, and the command or page that shows the result.",
        "`arctrue paper` makes the page from [paper.json](data/paper.json). The "
        "[errata](errata.md) list the mistakes of the paper.",
        "",
        "```sh",
        ".venv/bin/arctrue paper --page docs/paper.md --json docs/data/paper.json --out docs/images"
        f"{_lanes_option(found['experiments'][0])}   # {_minutes(found['experiments'])}",
        ".venv/bin/arctrue paper --from docs/data/paper.json --page docs/paper.md --out docs/images"
        "   # without a run",
        ".venv/bin/arctrue paper --interpolation 64                  # only the experiment, "
        "one minute, counts of 1.2″",
        "```",
        "",
        "## Equations and tables",
        "",
        "| Item | Paper | This implementation | Shown by |",
        "|---|---|---|---|",
        *(
            f"| {one['label']} | {one['paper']} | {one['here']} | {one['how']} |"
            for one in found["items"]
        ),
        "",
        *_experiment(found),
        *_remarks(found),
        *_figures(),
    ]
    return "\n".join(lines) + "\n"


def _experiment(found: Mapping[str, Any]) -> list[str]:
    runs = found["experiments"]
    full = runs[0]
    printed = full["published"]
    rows = [
        ("error without correction", _span(printed["before_arcsec"], 1), *(
            _span(one["before"]["span_arcsec"]) for one in runs
        )),
        ("error with correction", _span(printed["after_arcsec"], 1), *(
            _span(one["after"]["span_arcsec"]) for one in runs
        )),
        ("largest σ of a face, (13)", "0.2", *(
            f"{max(one['after']['deviation_arcsec']):.2f}" for one in runs
        )),
        *(
            (label, f"{printed['budget'][key]:g}", *(
                f"{one['budget'][key]:.2g}" for one in runs
            ))
            for label, key in _OUTCOME
        ),
        ("combined uncertainty u, (16)", f"{printed['combined_arcsec']:.2f}", *(
            f"{one['budget']['combined_arcsec']:.2f}" for one in runs
        )),
        ("expanded uncertainty U, k = 2, (17)", f"{printed['expanded_arcsec']:.2f}", *(
            f"{one['budget']['expanded_arcsec']:.2f}" for one in runs
        )),
        ("largest remaining order, Fig. 11 (b)", "1", *(_largest_order(one) for one in runs)),
    ]  # fmt: skip
    given = full["settings"]
    return [
        "## The experiment: section 4, Table 3, Fig. 11",
        "",
        "The table of the [virtual instrument](instrument.md) turns at 30°/s. Every edge of both "
        "heads passes through the compiled gateware, and",
        "the firmware's C code calibrates in every turn. Each time the signal passes a multiple of "
        f"15°, the autocollimator reads the face in front of it, in {given['cycles']} cycles of "
        f"{printed['faces']} faces.",
        "*Error without correction* is the error of head 1's signal in the same turns.",
        "",
        "| Simulated part | Errors |",
        "|---|---|",
        "| Table | errors in the paper's range: an eccentricity of 37.7 µm and six higher orders; "
        "the heads' separation differs from 33° by 50″; 0.1″ of noise on each reading |",
        "| Polygon | error of 0.1″ at each face, within its certificate (u₁); faces are tilted by "
        "up to 8″ and concave by 0.03 µm; the polygon's centre is 1 µm off the axis |",
        "| Autocollimator | error of 0.05″ at each face (u₂); standard deviation of a reading "
        f"{given['scatter_arcsec']:g}″ |",
        "",
        "The simulation computes the readings from geometry: a concave mirror that is hit off its "
        "centre, and the law of reflection in space. It does not use equations",
        "(14) and (15), so that a test can compare these equations with the simulation. The "
        "standard deviation of a reading is chosen so that the largest σ is about the paper's "
        "0.2″.",
        "",
        "| Value in ″ | paper | "
        + " | ".join(f"this implementation, {_counts(one)}" for one in runs)
        + " |",
        "|---|---|" + "---|" * len(runs),
        *(f"| {' | '.join(row)} |" for row in rows),
        "",
        f"The firmware applied {full['applied_orders']} orders in a core of {_lanes(full)} and "
        f"refused {full['refused_turns']} turns; the run took {full['clocks'] / 1e6:,.0f} million "
        "clocks. σ and u₃ are",
        "standard deviations of a single value, as in the paper; the means of ten cycles in the "
        "first two rows scatter less ([errata](errata.md)).",
        "",
        *_finest(full),
        f"![Fig. 11, reproduced](images/{figure_11_name(full)})",
        "",
    ]


def _finest(one: Mapping[str, Any]) -> list[str]:
    """Return a sentence if no run has as many counts a turn as the paper; otherwise return
    nothing."""
    if _interpolation(one) == FULL:
        return []
    return ["The runs of this page have fewer counts per turn than the paper's 2²⁴.", ""]


def _lanes_option(one: Mapping[str, Any]) -> str:
    lanes = one["settings"]["revolution"]["lanes"]
    return "" if lanes == LANES_DEFAULT else f" --lanes {lanes}"


def _minutes(runs: list[Mapping[str, Any]]) -> str:
    """Compute the running time from the number of clocks, because the wall time depends on other
    programs."""
    seconds = sum(
        one["clocks"]
        / CLOCKS_A_SECOND.get(
            one["settings"]["revolution"]["lanes"], CLOCKS_A_SECOND[LANES_DEFAULT]
        )
        for one in runs
    )
    return f"{seconds / 60:.0f} minutes on one core"


CLOCKS_A_SECOND = {8: 630_000, 32: 287_000}
"""Simulated clocks per second of the compiled core, by its number of lanes (docs/instrument.md)."""


def _remarks(found: Mapping[str, Any]) -> list[str]:
    values = {one["label"]: one["values"] for one in found["items"]}
    given = found["experiments"][0]["settings"]
    coarse = [one for one in found["experiments"] if _interpolation(one) == COARSE]
    delay = values["Table 1"]
    count = arcsec_per_count(16384 * COARSE)
    rounding = count / ROUNDING_DIVISOR
    expected = math.hypot(given["revolution"]["noise_arcsec"], given["scatter_arcsec"], rounding)
    measured = "".join(
        f" The run gives {one['budget']['repeatability_arcsec']:.2f}″, because the part of the "
        "rounding that repeats in every cycle does not scatter."
        for one in coarse
    )
    return [
        "## Limits of these results",
        "",
        "- **The table never stops, and there is no servo.** The autocollimator reads a face while "
        "the table turns, at the count at which a servo would stop. A servo adds its own",
        "  error (following error, friction, dither between two counts): see "
        "[stop and go](stop-and-go.md).",
        "- **The comparison excludes the latency**: each edge of the output is compared with the "
        "angle at which the table caused this edge. At 100 MHz the edge",
        f"  leaves {delay['pin_to_pin_ns']:.0f} ns later; meanwhile the table turns by "
        f"{delay['travel_arcsec']:.2f}″ at 30°/s.",
        f"- **The pipeline's {delay['pipeline_ns']:.0f} ns are not far below a count's duration**, "
        f"contrary to the paper: they are {delay['pipeline_ns'] / delay['count_ns']:.1f} of this "
        f"duration ({delay['count_ns']:.0f} ns at 30°/s); above "
        f"{30.0 * delay['count_ns'] / delay['pipeline_ns']:.0f}°/s a count is shorter than the "
        "latency.",
        "- **The causes of the paper's remaining 1.6″ are unknown.** Subdivision, heat and bearing "
        "are possible causes, but the table simulated here has none of them, and there is no",
        "  published measurement of the paper's table that shows them. The "
        "[budget](calibration-budget.md) and the [effects](effects.md) state the error that each "
        "of them would cause.",
        f"- **The firmware does not apply orders below {values['(6)']['limit_u']:.1f} standard "
        "uncertainties.** These orders remain in the output; the "
        "[uncertainty budget](reports.md#uncertainty-budget) has a line for their sum.",
        "- **With `--interpolation 64`, σ, u₃ and U are larger than the paper's**, because a count "
        f"is {count:.2f}″. The output changes only at edges of head 1, so it is rounded to a "
        "count.",
        f"  This rounding, {rounding:.2f}″ RMS (a count/√12), and the noise of head and "
        f"autocollimator give u₃ = {expected:.2f}″ at most.{measured}",
        f"  At 2²⁴ counts per turn the rounding error is {rounding / 16:.2f}″ RMS.",
        "- The error with correction comes mainly from the errors of polygon and autocollimator: "
        "0.11″ at each face cause 0.046″ in an order (the dashed line of Fig. 11 (b)).",
        "  The error of the output itself is smaller: 0.03″ RMS. Only a simulation can show it "
        "([virtual instrument](instrument.md#one-revolution-at-the-papers-size)).",
        "",
    ]


def _figures() -> list[str]:
    lines = [
        "## Figures",
        "",
        "`arctrue paper --out` draws the figures from the constants of this implementation. "
        "Figures 2 and 10 of the paper are photographs of its board and table; this project has",
        "no board yet ([on the bench](hardware.md)). Fig. 11 is above.",
        "",
    ]
    for number, (title, _, _) in DRAWINGS.items():
        name = f"Fig. {number}" if number.isdigit() else f"Fig. A.{number[1:]}"
        caption = title if title.startswith(name) else f"{name}: {title}"
        lines += [f"![{caption}](images/{drawing_name(number)})", ""]
    return lines[:-1]


def _lanes(one: Mapping[str, Any]) -> str:
    lanes = one["settings"]["revolution"]["lanes"]
    whole = (
        ""
        if lanes == LANES_DEFAULT
        else f" (the default, {LANES_DEFAULT} lanes, takes longer to simulate)"
    )
    return f"{lanes} lanes{whole}"


def _span(values: list[float], digits: int = 2) -> str:
    return f"[{values[0]:.{digits}f}, {values[1]:.{digits}f}]"


def _largest_order(one: Mapping[str, Any]) -> str:
    amplitude = one["residual_orders_arcsec"]
    largest = max(range(len(amplitude)), key=amplitude.__getitem__)
    return f"{largest + 1}, {amplitude[largest]:.2f}″"


def _interpolation(one: Mapping[str, Any]) -> int:
    return int(one["settings"]["revolution"]["interpolation"])


def _counts(one: Mapping[str, Any]) -> str:
    given = one["settings"]["revolution"]
    return f"{given['lines'] * _interpolation(one):,} counts"
