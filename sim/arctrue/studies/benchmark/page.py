"""The page of the benchmark: what came out, beside what it should be."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from arctrue.studies.benchmark.intervals import Rate
from arctrue.studies.benchmark.outcome import OUTCOMES
from arctrue.studies.benchmark.score import SCORES, goal_of
from arctrue.studies.benchmark.worlds import WORLDS

MOST_FAILURES = 40

HEAD = """# How often the diagnosis is right

`arctrue benchmark` hides causes in simulated tables and lets the diagnosis see the folder of the
measurement set only. The truth is compared with the answer beside an *oracle*: the generalised
likelihood ratio that knows the cause's exact form and the covariance by which the noise was drawn.
It *sees* a cause that it would find in 95 % of such sets at a false alarm of 1 %, its own search
for an order, a frequency or an instant paid for. What moves the prediction by less than half a
count RMS does not count as visible.

    make blind                                   # dev: 600 sets; TIER=quick, public or sealed
    arctrue benchmark make FOLDER --tier sealed  # seals generator and scoring, then draws the seed
    arctrue benchmark run FOLDER                 # --workers N, --scheduler ADDRESS, --shard i/n
    arctrue benchmark score FOLDER               # every rate; --answers FILE: anybody's answers
    make peers                                   # the rivals on the 200 public sets
    arctrue benchmark page FOLDER --peers build/benchmark/public --to docs/blind.md

A run can be stopped with Ctrl-C and goes on where it stopped; results do not depend on the number
of workers or shards. One folder takes results of one state of the code only.
On a cluster: [campaigns](campaigns.md).
"""

WORLDS_TOLD = """## The sets

24,000 rows a set: four runs (up, down, three times as fast, warm) and ten polygon cycles. Each
world has sets with nothing in them, one cause of the catalogue, a product of parts that no
catalogue has, a stranger outside the grammar of parts, and two or three causes at once. Causes and
sizes are drawn from the ranges of `arctrue simulate --list`; draws that look like each other are
not avoided.

| world | what is bad in it |
|---|---|
"""

READING = """## How to read it

*Right*: named. *First in class*: this set cannot tell, and the truth stands first among those
listed. *In class*: it is listed, another stands first. Of several causes each counts. A separation
of the heads that is stated wrong is a `head_angle_error`. A name for a stranger is a false name.
*Silent*: `cannot_tell` though the oracle sees it. Intervals are Clopper–Pearson, 95 %.

How independent the simulation is of the effects: it moves discs, brackets and counters by exact
plane geometry, and solves for the reading. Where a cause's own formula *is* the effect's (a wave of
an order on the graduation, a drift in proportion to time, a scale error of the autocollimator, a
constant a face, a delay times a speed), agreement says that the search and the statistics work, not
that the physics is right.
"""


PEERS_TOLD = {
    "arctrue": "`arctrue diagnose`.",
    "stepwise_bic": (
        "Stepwise regression: the effect whose columns lower the BIC most is added, up to three, "
        "in white noise. It has a name for everything."
    ),
    "periodogram_rule": (
        "A rule of thumb: the strongest line of the residual in angle or time at a false alarm of "
        "1 % names one of four effects."
    ),
    "gaussian_process": (
        "A smooth discrepancy over all conditions (Kennedy and O'Hagan, by scikit-learn): it sees "
        "that something is there and has no names."
    ),
}


def page(
    plan: Mapping[str, Any],
    code: Mapping[str, str],
    found: Mapping[str, Any],
    peers: Mapping[str, Mapping[str, Any]] | None = None,
) -> str:
    """The page as Markdown, from the plan, the state of the code and what was scored.

    ``peers``: the scores of each subject over the frozen public sets.
    """
    lines = [HEAD, "## Result", "", *_provenance(plan, code, found), ""]
    lines += _rates(found)
    lines += ["", *_probabilities(found), "", *_held_out(found), "", *_sizes(found), ""]
    if peers:
        lines += ["### Beside simple rivals", "", *_peers(peers), ""]
    lines += ["### Outcomes by world", "", *_outcomes(found), ""]
    lines += ["### What was said of what", "", *_confusion(found), ""]
    lines += ["### Not as it should be", "", *_failures(found), "", WORLDS_TOLD.rstrip()]
    lines += [
        f"| {name} | {' '.join((make.__doc__ or '').split())} |" for name, make in WORLDS.items()
    ]
    lines += ["", READING.rstrip(), ""]
    return "\n".join(lines)


def _provenance(
    plan: Mapping[str, Any], code: Mapping[str, str], found: Mapping[str, Any]
) -> list[str]:
    libraries = ", ".join(
        f"{name} {value}" for name, value in sorted(code.items()) if name != "arctrue"
    )
    part = "" if found["sets"] == plan["sets"] else f" (of {plan['sets']}: the run was stopped)"
    return [
        f"Tier *{plan['tier']}*, seed {plan['seed']}: {found['sets']} sets{part}, "
        f"{found['visible']} with something that the oracle sees. "
        f"Source `{code['arctrue']}`, generator `{plan['generator']}`, "
        f"scoring `{plan['scoring']}`; {libraries}."
    ]


def _percent(data: Mapping[str, Any]) -> str:
    rate = Rate(data["hits"], data["of"])
    if not rate.of:
        return "–"
    low, high = rate.interval
    return f"{100 * rate.hits / rate.of:.1f} ({100 * low:.1f} … {100 * high:.1f}) of {rate.of}"


def _goal(most: float | None, least: float | None) -> str:
    if most is not None:
        return f"≤ {100 * most:g}"
    return "" if least is None else f"≥ {100 * least:g}"


def _rates(found: Mapping[str, Any]) -> list[str]:
    columns = ["all", *(name for name in WORLDS if name in found["outcomes"])]
    lines = [
        "Percent of the sets that count, with the interval, and how many count:",
        "",
        "| | goal | " + " | ".join(columns) + " |",
        "|---|---|" + "---|" * len(columns),
    ]
    for score in SCORES:
        by_world = found["rates"][score.name]
        goal = _goal(*goal_of(score, "all"))
        cells = [_percent(by_world[name]) for name in columns]
        lines.append(f"| {score.name} | {goal} | " + " | ".join(cells) + " |")
    return lines


def _peers(peers: Mapping[str, Mapping[str, Any]]) -> list[str]:
    first = next(iter(peers.values()))
    lines = [
        f"The same {first['sets']} of the frozen public sets (tier *public*), "
        f"{first['visible']} with something that the oracle sees. Percent, interval, and how many "
        "count:",
        "",
        "| | " + " | ".join(peers) + " |",
        "|---|" + "---|" * len(peers),
    ]
    for score in SCORES:
        cells = [_percent(scores["rates"][score.name]["all"]) for scores in peers.values()]
        lines.append(f"| {score.name} | " + " | ".join(cells) + " |")
    lines.append("")
    lines += [f"- `{name}`: {PEERS_TOLD[name]}" for name in peers]
    return lines


def _probabilities(found: Mapping[str, Any]) -> list[str]:
    stated = found["probability"]
    if stated is None:
        return ["The answers state no probability (schema 1), so none is scored."]
    lines = [
        f"Probability given to the truth where it is visible: "
        f"{stated['mean_of_truth_where_visible']:.3f}. Expected calibration error: "
        f"{stated['expected_calibration_error']:.3f} (goal ≤ 0.03).",
        "",
        "| largest probability, mean | right, percent |",
        "|---|---|",
    ]
    lines += [
        f"| {item['mean_probability']:.3f} | {_percent(item)} |" for item in stated["reliability"]
    ]
    return lines


def _held_out(found: Mapping[str, Any]) -> list[str]:
    ratios = found["held_out_over_floor"]
    if ratios is None:
        return []
    told = ", ".join(f"{name} {value:.3f}" for name, value in ratios.items())
    return [f"Held-out error over the noise that was put in, where the answer is right: {told}."]


def _sizes(found: Mapping[str, Any]) -> list[str]:
    lines = [
        "### Size against the oracle",
        "",
        "Sets with one cause of the catalogue: put first, percent, by the size in oracle limits.",
        "",
        "| size in limits | put first |",
        "|---|---|",
    ]
    for item in found["found_by_size_in_limits"]:
        above = f"{item['from']:g} … {item['to']:g}" if item["to"] else f"above {item['from']:g}"
        lines.append(f"| {above} | {_percent(item)} |")
    return lines


def _outcomes(found: Mapping[str, Any]) -> list[str]:
    used = [name for name in OUTCOMES if any(name in row for row in found["outcomes"].values())]
    lines = ["| world | " + " | ".join(used) + " |", "|---|" + "---|" * len(used)]
    for world, row in found["outcomes"].items():
        lines.append(f"| {world} | " + " | ".join(str(row.get(name, "")) for name in used) + " |")
    return lines


def _confusion(found: Mapping[str, Any]) -> list[str]:
    lines = ["| hidden | said |", "|---|---|"]
    for truth, said in found["confusion"].items():
        lines.append(
            f"| {truth} | {', '.join(f'{name} {number}' for name, number in said.items())} |"
        )
    return lines


def _failures(found: Mapping[str, Any]) -> list[str]:
    failures: Sequence[Mapping[str, Any]] = found["failures"]
    if not failures:
        return ["Nothing."]
    shown = failures[:MOST_FAILURES]
    lines = [
        f"{len(failures)} sets; the first {len(shown)} (`arctrue benchmark score` lists all). "
        "`FOLDER` is where the set goes.",
        "",
    ]
    for item in shown:
        bad = f" [{', '.join(item['bad'])}]" if item["bad"] else ""
        lines.append(
            f"- {item['world']}{bad}, {'; '.join(item['hidden']) or 'nothing'}: "
            f"{item['outcome']} ({item['said']}). `{item['command']}`"
        )
    return lines
