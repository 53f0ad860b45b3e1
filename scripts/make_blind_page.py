"""Writes docs/blind.md and its picture from what the blind tests found.

``python -m scripts.make_blind_page``, after ``python -m scripts.blind`` and
``python -m scripts.detection``, whose results lie in build/blind.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from arctrue.studies.simulate.experiment import SAMPLES
from arctrue.table.causes.registry import RECIPES
from scripts.blind import confusion, faults, summary
from scripts.blind_judge import Outcome
from scripts.detection import FALSE_ALARM, LADDER, POWER, START, Detection

ROOT = Path(__file__).resolve().parents[1]
BUILD = ROOT / "build" / "blind"
PAGE = ROOT / "docs" / "blind.md"
PICTURE = ROOT / "docs" / "images" / "detection.png"
GOAL = 1.5
GOOD_COLOUR, POOR_COLOUR = "#1f5f99", "#c2571a"

INTRODUCTION = """\
# What the diagnosis can do, measured blind

[scripts/blind.py](../scripts/blind.py) hides causes in simulated tables, seals the truth, and
lets the diagnosis see the folder of the measurement set only. The simulator moves discs, brackets
and counters by exact geometry and shares no code with the effects of the workbench. This page
is written by [scripts/make_blind_page.py](../scripts/make_blind_page.py) from what the scripts
found:

    make blind                             # all sets; BLIND="--first-seed N" takes others
    .venv/bin/python -m scripts.detection  # how small an effect is still found
    .venv/bin/python -m scripts.make_blind_page

A *full* set has four runs (up, down, three times as fast, warm) and ten polygon cycles; a *lean*
set has one run and nothing else. Each cause comes in three sizes within the range that has been
seen on real tables. A cause is *visible* when even its exact form, known beforehand, would stand
out (χ² > 30 over what the base model absorbs) and it moves the prediction by half a count or more.
*Right*: named, nothing beside it. *First in class*, *in class*: the data cannot tell, and the truth
is among those listed. The *floor* of the held-out error is the noise that was put in.

Goals: right first in 97 % of the visible ones, a false name on 1 % of the sets without any effect
at most, effects of no catalogue unknown with the right parts in 90 %, held-out error up to 1.05
times the floor, no false name on lean sets.
"""

READING = """\
## How to read the classes

A class is no failure where the set holds no answer. A gear whose tooth count meets the polygon's
faces as order 6 looks like a radial motion of order 6; an eccentric polygon that happens to lie
in the direction of the disc's own eccentricity looks like a wrong gain of the autocollimator. On
a lean set a head angle and a skew between the latches are the same constant, and a line in time
is a line in angle. The diagnosis then asks for a measurement. It finds it by trial on paper: for
each further run or reference that could be made, the likeliest effect is taken for the truth and
the others have to explain what it would show. The blind test makes that measurement on the same
simulated table, adds it, and diagnoses again.

Where a smaller effect explains all that a larger one does, the smaller is named and the larger
listed. For a polygon whose eccentricity lies along the disc's own that is a wrong name: a gain,
with the truth in its class. Putting the polygon on again tells them apart.
"""


def main() -> None:
    """Write page and picture."""
    outcomes = [
        Outcome.of(item)
        for item in json.loads((BUILD / "outcomes.json").read_text(encoding="utf-8"))
    ]
    found = [
        Detection(**item)
        for item in json.loads((BUILD / "detection.json").read_text(encoding="utf-8")).values()
    ]
    PAGE.write_text(page(outcomes, found), encoding="utf-8")
    draw(found)


def page(outcomes: Sequence[Outcome], found: Sequence[Detection]) -> str:
    """The whole page as Markdown."""
    seeds = [item.case.seed for item in outcomes]
    sizes = sorted({item.case.samples or SAMPLES for item in outcomes})
    samples = " or ".join(f"{size:,}" for size in sizes)
    lines = [
        INTRODUCTION,
        f"{len(outcomes)} sets, seeds {min(seeds)} to {max(seeds)}, {samples} samples a run.",
        "",
        *summary(outcomes),
        "",
    ]
    for experiment in ("full", "lean"):
        chosen = [item for item in outcomes if item.case.experiment == experiment]
        lines += [f"## {experiment.capitalize()} sets", "", *confusion(chosen), ""]
    lines += ["## Not as it should be", "", *(faults(outcomes) or ["Nothing."]), "", READING]
    lines += [*detection_section(found), ""]
    return "\n".join(lines)


def detection_section(found: Sequence[Detection]) -> list[str]:
    """Smallest sizes beside the limit of the ideal test."""
    numbers = sorted({len(item.limits) for item in found})
    sets = " to ".join(str(number) for number in (numbers[0], numbers[-1])[: len(numbers)])
    good = sum(item.smallest is not None and item.smallest <= GOAL for item in found)
    lines = [
        "## How small an effect is still found",
        "",
        "The ideal test is the generalised likelihood ratio that knows the true form and searches "
        "only what the truth leaves open (an order, a frequency, an instant), at a false alarm of "
        f"{100 * FALSE_ALARM:g} %. Its limit is the size that it finds in {100 * POWER:g} % of "
        "the sets. The whole diagnosis, with all candidates and all its corrections, gets "
        f"{sets} sets a size (four runs of 2,000 samples, or 9,000 for what is narrow or fast), "
        "each size in limits of the same set "
        f"({', '.join(f'{step:g}' for step in LADDER)}), and must find the effect, by name or in "
        f"its class, in {100 * POWER:g} % of them. `--matters 0`: sizes below half a count count "
        f"too. The goal is {GOAL:g} limits; {good} of {len(found)} effects reach it.",
        "",
        "![Smallest size found beside the limit of the ideal test](images/detection.png)",
        "",
        "| hidden | limit of the ideal test, median | smallest size found in 95 %, in limits | "
        "sets found, by size in limits |",
        "|---|---|---|---|",
    ]
    for item in found:
        tried = "; ".join(
            f"{step}: {hits} of {sets}"
            for step, (hits, sets) in sorted(item.found.items(), key=lambda pair: float(pair[0]))
        )
        smallest = "—" if item.smallest is None else f"{item.smallest:g}"
        if item.smallest == LADDER[START] and len(item.found) == 1:
            smallest = f"≤ {smallest}"
        limit = f"{np.median(item.limits):.2g} {item.unit}"
        lines.append(f"| {item.name} | {limit} | {smallest} | {tried} |")
    if len(numbers) > 1:
        lines += [
            "",
            "Different numbers of sets mean different runs: an effect that a change of the "
            "diagnosis was about was measured again, with more. The rows of "
            f"{numbers[0]} are older.",
        ]
    lines += [
        "",
        "A size is left as soon as too many sets are missed; ≤: smaller ones were not tried "
        "(`--fine` does). What has no name pays for the products of parts that were tried, a low "
        "order less than a high one. A slip is a whole number of counts: a limit below one count "
        "cannot be met.",
    ]
    return lines


def draw(found: Sequence[Detection]) -> None:
    """Smallest size over limit, one bar an effect."""
    names = [name for name in RECIPES if any(item.name == name for item in found)]
    by_name = {item.name: item for item in found}
    sizes = [by_name[name].smallest or LADDER[-1] for name in names]
    figure = Figure(figsize=(8.0, 5.6), layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.subplots()
    place = np.arange(len(names))[::-1]
    colours = [GOOD_COLOUR if size <= GOAL else POOR_COLOUR for size in sizes]
    axes.barh(place, sizes, color=colours, height=0.7)
    for row, name, size in zip(place, names, sizes, strict=True):
        limit = f"{np.median(by_name[name].limits):.2g} {by_name[name].unit}"
        axes.annotate(limit, (size, row), xytext=(4, 0), textcoords="offset points", va="center")
    axes.axvline(GOAL, color="0.3", linewidth=1.0, linestyle="--")
    axes.set_yticks(place, names)
    axes.set(xlabel="smallest size found in 95 % of the sets, in limits of the ideal test", xlim=0)
    axes.set_title("Detection; beside the bar: the limit itself", loc="left")
    axes.spines[["top", "right"]].set_visible(False)
    figure.savefig(PICTURE, dpi=110)


if __name__ == "__main__":
    main()
