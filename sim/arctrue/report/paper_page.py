"""Makes the page of ``arctrue paper``: equations, tables and figures, as published and as
reproduced."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from arctrue.base.units import arcsec_per_count
from arctrue.generated.number_formats import LANES_DEFAULT
from arctrue.report.paper_drawings import DRAWINGS, drawing_name
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
        "This page compares *Fully online calibration-compensation method for rotary table "
        "positioning error* (Shao, Zhu, Huang, Xue, Zhu)",
        "with this implementation: each equation, table and figure, the result here, and the "
        "command or page that shows it. `arctrue paper` makes it",
        "from [paper.json](data/paper.json). The [errata](errata.md) list the slips of the paper.",
        "",
        "```sh",
        ".venv/bin/arctrue paper --page docs/paper.md --json docs/data/paper.json --out docs/images"
        f"{_lanes_option(found['experiments'][0])}   # {_minutes(found['experiments'])}",
        ".venv/bin/arctrue paper --from docs/data/paper.json --page docs/paper.md --out docs/images"
        "   # without a run",
        ".venv/bin/arctrue paper --interpolation 64                  # the experiment alone, "
        "one minute, counts of 1.2″",
        "```",
        "",
        "## Equations and tables",
        "",
        "| | Paper | Here | How |",
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
        ("error, uncorrected", _span(printed["before_arcsec"], 1), *(
            _span(one["before"]["span_arcsec"]) for one in runs
        )),
        ("error, corrected", _span(printed["after_arcsec"], 1), *(
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
        ("u combined, (16)", f"{printed['combined_arcsec']:.2f}", *(
            f"{one['budget']['combined_arcsec']:.2f}" for one in runs
        )),
        ("U expanded, k = 2, (17)", f"{printed['expanded_arcsec']:.2f}", *(
            f"{one['budget']['expanded_arcsec']:.2f}" for one in runs
        )),
        ("largest order left, Fig. 11 (b)", "1", *(_largest_order(one) for one in runs)),
    ]  # fmt: skip
    given = full["settings"]
    return [
        "## The experiment: section 4, Table 3, Fig. 11",
        "",
        "The table of the [virtual instrument](instrument.md) turns at 30°/s. Every edge of both "
        "heads passes through the compiled gateware, and",
        "the firmware's C calibrates in every turn. At every 15° of the signal the autocollimator "
        f"reads the face before it, in {given['cycles']} cycles of {printed['faces']} faces.",
        "*Uncorrected* is head 1's own signal in the same turns.",
        "",
        "| Simulated | |",
        "|---|---|",
        "| Table | the paper's range of error: an eccentricity of 37.7 µm and six orders above it; "
        "heads 50″ off 33°; 0.1″ of noise on each reading |",
        "| Polygon | uncertainty of its certificate at each face: 0.1″ (u₁); faces lean by up to "
        "8″ and are hollow by 0.03 µm; its centre is 1 µm off the axis |",
        "| Autocollimator | an error of 0.05″ at each face (u₂); a reading scatters by "
        f"{given['scatter_arcsec']:g}″ |",
        "",
        "Faces and autocollimator are geometry: a hollow mirror met off its centre, and the law of "
        "reflection in space. The simulation does not use equations",
        "(14) and (15), so that a test compares them with it. The scatter is chosen so that the "
        "largest σ is about the paper's 0.2″.",
        "",
        "| ″ | paper | " + " | ".join(f"here, {_counts(one)}" for one in runs) + " |",
        "|---|---|" + "---|" * len(runs),
        *(f"| {' | '.join(row)} |" for row in rows),
        "",
        f"{full['applied_orders']} orders were applied, by a core of {_lanes(full)}; "
        f"{full['refused_turns']} turns refused, {full['clocks'] / 1e6:,.0f} million clocks. "
        "σ and u₃ are the",
        "standard deviation of a single value, as in the paper; the means of ten cycles in the "
        "first rows scatter less ([errata](errata.md)).",
        "",
        *_finest(full),
        f"![Fig. 11, drawn anew](images/{figure_11_name(full)})",
        "",
    ]


def _finest(one: Mapping[str, Any]) -> list[str]:
    """Return a sentence if no run has as many counts a turn as the paper; otherwise return
    nothing."""
    if _interpolation(one) == FULL:
        return []
    return ["This page's runs are coarser than the paper's 2²⁴ counts a turn.", ""]


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
    came_out = "".join(
        f" It came out as {one['budget']['repeatability_arcsec']:.2f}″." for one in coarse
    )
    return [
        "## What these figures are not",
        "",
        "- **The table never stops, and there is no servo.** A face is read in passing, at the "
        "count at which a servo would stop. A servo adds its own",
        "  error (following error, friction, dither between two counts): "
        "[stop and go](stop-and-go.md).",
        "- **The comparison excludes the latency**: an edge is compared with the angle at the "
        "instant at which the table made it. At 100 MHz an edge",
        f"  leaves {delay['pin_to_pin_ns']:.0f} ns later, {delay['travel_arcsec']:.2f}″ of travel "
        "at 30°/s and none at rest.",
        f"- **{delay['pipeline_ns']:.0f} ns are not far below the time of a count** "
        f"({delay['count_ns']:.0f} ns at 30°/s) but "
        f"{delay['pipeline_ns'] / delay['count_ns']:.1f} of it; above "
        f"{30.0 * delay['count_ns'] / delay['pipeline_ns']:.0f}°/s they are longer.",
        "- **Subdivision, heat and bearing as causes of the paper's remaining 1.6″ are a guess.** "
        "This table has none of them, and no published measurement",
        "  of the paper's table decides. The [budget](calibration-budget.md) and the "
        "[effects](effects.md) state what each would cause.",
        f"- **Orders below {values['(6)']['limit_u']:.1f} standard uncertainties are not "
        "applied.** They stay in the output; their sum is a line of the "
        "[budget](reports.md#uncertainty-budget).",
        "- **With `--interpolation 64`, σ, u₃ and U exceed the paper's**, because a count is "
        f"{count:.2f}″. An edge of the output leaves with an edge of head 1, so that",
        f"  the fraction of a count in the correction remains: {rounding:.2f}″ RMS (a count over "
        f"√12), with the scatter of head and autocollimator at most {expected:.2f}″.",
        f" {came_out} A part that repeats in every cycle goes into the mean. At 2²⁴ counts a turn "
        f"the same is {rounding / 16:.2f}″.",
        "- The remaining error here comes from polygon and autocollimator: 0.11″ a face is 0.046″ "
        "in an order (the broken line of Fig. 11 (b)).",
        "  The output's own error is smaller, and only a simulation shows it: 0.03″ RMS "
        "([virtual instrument](instrument.md#one-revolution-at-the-papers-size)).",
        "",
    ]


def _figures() -> list[str]:
    lines = [
        "## Figures",
        "",
        "`arctrue paper --out` draws them from the constants of this implementation. Figures 2 "
        "and 10 are photographs of the paper's board and table; there is",
        "no board here yet ([on the bench](hardware.md)). Fig. 11 is above.",
        "",
    ]
    for number, (title, _, _) in DRAWINGS.items():
        name = f"Fig. {number}" if number.isdigit() else f"Fig. A.{number[1:]}"
        lines += [f"![{name}: {title}](images/{drawing_name(number)})", ""]
    return lines[:-1]


def _lanes(one: Mapping[str, Any]) -> str:
    lanes = one["settings"]["revolution"]["lanes"]
    whole = (
        "" if lanes == LANES_DEFAULT else f" (the usual {LANES_DEFAULT} take longer to simulate)"
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
