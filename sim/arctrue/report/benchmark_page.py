"""The page of the benchmark: what came out, beside what it should be."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from arctrue.studies.benchmark.cases import Reason
from arctrue.studies.benchmark.intervals import Rate
from arctrue.studies.benchmark.outcome import OUTCOMES
from arctrue.studies.benchmark.plan import SCORING, files_digest
from arctrue.studies.benchmark.score import SCORES, Score, goal_of
from arctrue.studies.benchmark.worlds import WORLDS
from arctrue.studies.campaign.store import told_state

MOST_FAILURES = 200
PICTURE_TOLD = "The same as a matrix, and how often a stated probability is right"
RIGHT_FIRST = "right first, of what the oracle sees of the catalogue"
PROBABILITY_BELOW_RIGHT = 0.03
MOST_CALIBRATION_ERROR = 0.03
"""Goals, as those of the scores."""
TRUTH_PROBABILITY = "probability given to the truth in the catalogue"
CALIBRATION_ERROR = "expected calibration error"

HEAD = """# How often the diagnosis is right

`arctrue benchmark` hides causes in simulated tables and lets the diagnosis see the folder of the
measurement set only. The truth is compared with the answer beside an *oracle*: the generalised
likelihood ratio that knows the cause's exact form and the covariance by which the noise was drawn.
It *sees* a cause that it would find in 95 % of such sets at a false alarm of 1 %, its own search
for an order, a frequency or an instant paid for. What moves the prediction by less than half a
count RMS does not count as visible.

    make benchmark                               # dev: 600 sets; TIER=quick, public, sealed, cases
    make benchmark TIER=calibration              # 180 sets: how often a sure answer is wrong
    arctrue benchmark make FOLDER --tier sealed  # seals generator and scoring, then draws the seed
    arctrue benchmark run FOLDER                 # --workers N, --scheduler ADDRESS, --shard i/n
    arctrue benchmark score FOLDER               # every rate; --answers FILE: anybody's answers
    make peers                                   # the rivals on the 200 public sets: PUBLIC
    arctrue benchmark score FOLDER --keep        # its failures become cases, for TIER=cases
    arctrue benchmark page FOLDER --peers PUBLIC --to docs/benchmark.md --out docs/images

Why a case fails stands as `looked_into` beside it in
`sim/arctrue/studies/benchmark/cases.json`, and from there on this page. After a wanted change of
the generator, `arctrue benchmark sets` with `--freeze` takes the public sets anew.

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

*False name*: the set is said to have an effect that is not in it; a name for a stranger is one.
*Falsely adequate*: nothing is said to be missing though the oracle sees something. *Right*: named.
*First in class*: the answer is a class that this set cannot split, and the truth stands first in
it. *In class*: it is listed, another stands first. Of several causes each counts as the truth. A
separation of the heads that is stated wrong is a `head_angle_error`. *Silent*: `cannot_tell`
though the oracle sees something. *Stranger*: a cause that no effect of the catalogue and no product
of parts describes. *Product of parts*: a condition (temperature, speed, settling) times a wave of
one order on the disc, the stator or a head. *A second name that is not there*: a name beside the
right one, of an effect that is not in the set. Intervals are Clopper–Pearson, 95 %.

## How independent the simulation is of the effects

It moves discs, brackets and counters by exact plane geometry and solves for the reading; it shares
no code with the workbench. Where a cause's own formula *is* the effect's, agreement says that the
search and the statistics work, not that the physics is right.

| effect | the same formula? |
|---|---|
"""
INDEPENDENCE = {
    "high_order_graduation": "The same: a wave of one order on the graduation.",
    "head_angle_error": (
        "To first order: the bracket is turned about the axis and the ray from the disc's centre "
        "is exact; the effect is a constant and the slope of the fitted error."
    ),
    "subdivision_error": (
        "No: offset, gain and phase of sine and cosine through atan2; the effect is a series of "
        "the electrical phase."
    ),
    "radial_error_motion": (
        "To first order: the axis moves on an ellipse, the rays are exact; the effect is the "
        "motion over the radius."
    ),
    "bearing_ball_pass": (
        "To first order, as radial motion, at an order that is not whole and is searched."
    ),
    "vibration": (
        "The same: a sine of one frequency with a phase of its own each run. The head is turned "
        "about the axis by it and the ray is exact; the effect leaves the slope of the error out."
    ),
    "hysteresis": (
        "No: the shaft winds up on a loop of Dahl's friction, over a stroke after each reversal; "
        "the effect is a constant a direction."
    ),
    "timing_skew": (
        "To first order: head 2 is read where the table is by then, with the error of that place; "
        "the effect is delay times speed."
    ),
    "latency": "The same: what is read is the angle at which the table was one delay earlier.",
    "thermal_head_drift": (
        "To first order: the bracket is turned about the axis in proportion to the warming and "
        "the ray is exact; the effect leaves the slope of the error out."
    ),
    "thermal_eccentricity": (
        "To first order: the disc's centre moves in proportion to the warming, the rays are exact; "
        "the effect is a first order times the warming."
    ),
    "count_slip": (
        "The same: a step at an instant of one run. It is of whole counts; the effect's is of any "
        "size."
    ),
    "graduation_defect": (
        "No: dirt has edges of any steepness and may be lopsided; the effect is a bell."
    ),
    "drive_gear_error": (
        "No: the pitch wobbles once a turn, which modulates the phase of the teeth's wave: lines "
        "on both sides of it whose sizes and phases belong together. The effect is that wave with "
        "as many of its multiples and neighbouring lines as the data show, each free."
    ),
    "polygon_face_error": "The same: a constant a face.",
    "polygon_eccentricity": (
        "Nearly: tilt, roll and hollow faces are put in as such, and come to a wave of the first "
        "order and a gain of cos 1° − 1 = −0.015 %; the effect is the wave."
    ),
    "autocollimator_gain": (
        "The same: a share of the table's error. The effect takes the share of the fitted error."
    ),
    "reference_drift": (
        "No: a rate and on top a temperature that walks at random; the effect is in proportion to "
        "time."
    ),
    "warm_ovality": "The same product: warming times a wave of the second order on the disc.",
    "centrifugal_lobes": "The same product: speed squared times a wave of the third order on it.",
    "half_order": (
        "To first order: the axis moves on a line at a half-integer order, the rays are exact; the "
        "parts are a wave of any order fixed to the stator."
    ),
    "settling_bracket": (
        "The same: an exponential since the start or since the run began, whose time constant is "
        "searched; the bracket is turned about the axis and the ray is exact."
    ),
}
"""Of every cause of the catalogue and every product of parts: what agreement with it shows."""
NOISE_TOLD = """The strangers have no formula in the workbench. Noise is for the most part of the
form that a diagnosis fits, which is white noise and up to seven relaxations (Ornstein–Uhlenbeck) of
given time constants, with a scale a run and 36 scales around the turn: *ornstein_uhlenbeck* and
*wandering_reference* are one relaxation of another time constant, *pink* and *power_law* sums of
many, *autoregressive* is one in rows in place of seconds that begins anew in each run. *by_angle*
has a cosine in place of 36 steps. Outliers are Student's t of two degrees of freedom, shifts of an
index mark uniform whole counts; the workbench has neither distribution. It takes the temperature
as the sensor shows it, and the speed from the angle and the time of the rows.
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


def benchmark_page(
    header: Mapping[str, Any],
    found: Mapping[str, Any],
    peers: Mapping[str, Mapping[str, Any]] | None = None,
    reasons: Mapping[str, Reason] | None = None,
    picture: str | None = None,
) -> str:
    """The page as Markdown, from the header of the campaign and from what was scored.

    ``peers``: the scores of each subject over the frozen public sets. ``reasons``: what was found
    by looking into failures, by the name of the set. ``picture``: the address of the confusion
    matrix and the reliability curve, as the page would link them.
    """
    lines = [HEAD, "## Result", "", *_provenance(header, found), ""]
    lines += _rates(found)
    lines += ["", *_probabilities(found), "", *_held_out(found), "", *_sizes(found), ""]
    lines += [*_by_effect(found), ""]
    if peers:
        lines += ["### Beside simple rivals", "", *_peers(peers, header), ""]
    lines += ["### Outcomes by world", "", *_outcomes(found), ""]
    lines += ["### What was said of what", "", *_confusion(found), ""]
    if picture is not None:
        lines += [f"![{PICTURE_TOLD}]({picture})", ""]
    lines += ["### Not as it should be", "", *_failures(found, reasons or {}), ""]
    lines += _static()
    return "\n".join(lines)


def _static() -> list[str]:
    """What does not depend on a result."""
    lines = [WORLDS_TOLD.rstrip()]
    lines += [
        f"| {name} | {' '.join((make.__doc__ or '').split())} |" for name, make in WORLDS.items()
    ]
    lines += ["", READING.rstrip()]
    lines += [f"| `{name}` | {told} |" for name, told in INDEPENDENCE.items()]
    return [*lines, "", NOISE_TOLD]


def _provenance(header: Mapping[str, Any], found: Mapping[str, Any]) -> list[str]:
    plan, code = header["plan"], header["code"]
    libraries = ", ".join(
        f"{name} {value}" for name, value in sorted(code.items()) if name != "arctrue"
    )
    sets = f"{found['sets']} sets"
    if found["sets"] != plan["sets"]:
        sets = f"**{found['sets']} of its {plan['sets']} sets** (the run was not finished)"
    return [
        f"Tier *{plan['tier']}*, seed {plan['seed']}: {sets}, {found['visible']} with something "
        f"that the oracle sees. {told_state(header)}, generator `{plan['generator']}`, scored by "
        f"`{files_digest(SCORING)}`; {libraries}.",
        "",
        _goals_met(found),
    ]


def _goals_met(found: Mapping[str, Any]) -> str:
    """The goals over all sets in one sentence."""
    met: list[str] = []
    missed: list[str] = []
    for score in SCORES:
        goal, data = goal_of(score, "all"), found["rates"][score.name]["all"]
        if goal == (None, None) or not data["of"]:
            continue
        told = f"{score.name} ({100 * data['hits'] / data['of']:.1f} %, goal {_goal(*goal)})"
        (missed if _missed(data, *goal) else met).append(told)
    for name, value, goal_told, kept in _goals_of_probabilities(found):
        (met if kept else missed).append(f"{name} ({value:.3f}, goal {goal_told})")
    return f"Goals over all sets, met: {'; '.join(met) or 'none'}. Missed: " + (
        f"{'; '.join(missed)}." if missed else "none."
    )


def _goals_of_probabilities(found: Mapping[str, Any]) -> list[tuple[str, float, str, bool]]:
    """Name, value, goal in words and whether it is kept; none where no probability is stated."""
    stated = found["probability"]
    if stated is None:
        return []
    goals = []
    right, truth = found["rates"][RIGHT_FIRST]["all"], stated["mean_of_truth_of_catalogue"]
    if truth is not None:
        least = right["hits"] / right["of"] - PROBABILITY_BELOW_RIGHT
        goals.append((TRUTH_PROBABILITY, truth, f"≥ {least:.3f}", truth >= least))
    error = stated["calibration_error"]["value"]
    kept = error <= MOST_CALIBRATION_ERROR
    goals.append((CALIBRATION_ERROR, error, f"≤ {MOST_CALIBRATION_ERROR:g}", kept))
    return goals


def _percent(data: Mapping[str, Any]) -> str:
    rate = Rate(data["hits"], data["of"])
    if not rate.of:
        return "–"
    low, high = rate.interval
    return f"{100 * rate.hits / rate.of:.1f} ({100 * low:.1f} … {100 * high:.1f}) of {rate.of}"


def _missed(data: Mapping[str, Any], most: float | None, least: float | None) -> bool:
    if not data["of"]:
        return False
    share = data["hits"] / data["of"]
    return (most is not None and share > most) or (least is not None and share < least)


def _goal(most: float | None, least: float | None) -> str:
    if most is not None:
        return f"≤ {100 * most:g}"
    return "" if least is None else f"≥ {100 * least:g}"


def _goals(score: Score) -> str:
    """The goal over all, and those of worlds that differ from it."""
    over_all = _goal(*goal_of(score, "all"))
    others = {world: _goal(*goal_of(score, world)) for world in WORLDS}
    if len(set(others.values())) == 1:
        (each,) = set(others.values())
        return over_all if each == over_all else f"{over_all}; in each world {each}"
    told = [f"{world} {goal}" for world, goal in others.items() if goal != over_all]
    return "; ".join([over_all, *told])


def _rates(found: Mapping[str, Any]) -> list[str]:
    worlds = [name for name in WORLDS if name in found["outcomes"]]
    columns = ["all", *worlds]
    lines = [
        "Percent of the sets that count, with the interval of 95 %, and how many sets count. In "
        "bold: the rate misses its goal.",
        "",
        "| | goal | " + " | ".join(columns) + " |",
        "|---|---|" + "---|" * len(columns),
    ]
    for score in SCORES:
        by_world = found["rates"][score.name]
        cells = []
        for name in columns:
            told = _percent(by_world[name])
            missed = _missed(by_world[name], *goal_of(score, name))
            cells.append(f"**{told}**" if missed else told)
        lines.append(f"| {score.name} | {_goals(score)} | " + " | ".join(cells) + " |")
    return lines


def _peers(peers: Mapping[str, Mapping[str, Any]], header: Mapping[str, Any]) -> list[str]:
    first = next(iter(peers.values()))
    whole = first["header"]["plan"]["sets"]
    tier = first["header"]["plan"]["tier"]
    sets = f"The {whole}" if first["sets"] == whole else f"The same {first['sets']} of the {whole}"
    lines = [
        f"{sets} sets of the tier *{tier}*{', which are frozen' if tier == 'public' else ''}: "
        f"{first['visible']} with something that the oracle sees, one scorer for all. Percent, "
        "interval of 95 %, and how many sets count:",
        "",
        "| | " + " | ".join(peers) + " |",
        "|---|" + "---|" * len(peers),
    ]
    for score in SCORES:
        cells = [_percent(scores["rates"][score.name]["all"]) for scores in peers.values()]
        lines.append(f"| {score.name} | " + " | ".join(cells) + " |")
    lines.append("")
    lines += [
        f"- `{name}`: {PEERS_TOLD[name]} {told_state(scores['header'])}."
        for name, scores in peers.items()
    ]
    own = peers.get(header.get("subject", "arctrue"))
    if own is not None and own["header"]["code"] != header["code"]:
        lines += [
            "",
            "The answers of `arctrue` in this table are of another state of the code than the "
            "result above.",
        ]
    return lines


def _probabilities(found: Mapping[str, Any]) -> list[str]:
    stated = found["probability"]
    if stated is None:
        return ["The answers state no probability (schema 1), so none is scored."]
    told, goals = {}, {}
    for name, value, goal, kept in _goals_of_probabilities(found):
        told[name], goals[name] = f"{value:.3f}" if kept else f"**{value:.3f}**", goal
    truth = []
    if stated["mean_of_truth_where_visible"] is not None:
        truth.append(f"{stated['mean_of_truth_where_visible']:.3f} of all that the oracle sees")
    if TRUTH_PROBABILITY in goals:
        truth.append(
            f"{told[TRUTH_PROBABILITY]} of that in the catalogue (goal "
            f"{goals[TRUTH_PROBABILITY]}: the rate of right first less "
            f"{PROBABILITY_BELOW_RIGHT:g})"
        )
    lines = [
        f"Mean probability that is given to the truth: {', '.join(truth) or 'nothing is seen'}. "
        "Expected calibration error, the mean distance of the curve below from what is stated: "
        f"{told[CALIBRATION_ERROR]} (goal {goals[CALIBRATION_ERROR]}).",
        "",
        "| largest probability, mean | right, percent |",
        "|---|---|",
    ]
    lines += [
        f"| {item['mean_probability']:.3f} | {_percent(item)} |" for item in stated["reliability"]
    ]
    kinds = (f"{kind} {of['hits']} of {of['of']}" for kind, of in stated["right_of"].items())
    return [*lines, "", f"Right, by what it is given to: {', '.join(kinds)}."]


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
        "Sets with one cause of the catalogue: put first, percent, by the size in limits (over the "
        "smallest that the oracle finds).",
        "",
        "| size in limits | put first |",
        "|---|---|",
    ]
    for item in found["found_by_size_in_limits"]:
        above = f"{item['from']:g} … {item['to']:g}" if item["to"] else f"above {item['from']:g}"
        lines.append(f"| {above} | {_percent(item)} |")
    return lines


def _by_effect(found: Mapping[str, Any]) -> list[str]:
    lines = [
        "By effect, in limits: the smallest that was put first, the largest that was not.",
        "",
        "| effect | put first | smallest put first | largest not put first |",
        "|---|---|---|---|",
    ]
    for name, item in found["found_by_effect"].items():
        smallest, largest = (
            "–" if value is None else f"{value:.3g}"
            for value in (item["smallest_put_first"], item["largest_not_put_first"])
        )
        lines.append(f"| {name} | {item['hits']} of {item['of']} | {smallest} | {largest} |")
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


def said_words(item: Mapping[str, Any]) -> str:
    """What was said of a failure: the name or verdict, a second name, the words of an error."""
    beside = f", and beside it {item['second_name']}" if item["second_name"] else ""
    error = f": {item['error']}" if item["error"] else ""
    return f"{item['said']}{beside}{error}"


def reason_words(item: Mapping[str, Any], reasons: Mapping[str, Reason]) -> str:
    """Why a failure is one, as far as somebody looked into it."""
    reason = reasons.get(item["set"])
    if reason is None:
        return "Not looked into yet."
    if reason.said != said_words(item):
        return f"Looked into when {reason.said} was said: {reason.why}"
    return f"Why: {reason.why}"


def _failures(found: Mapping[str, Any], reasons: Mapping[str, Reason]) -> list[str]:
    failures: Sequence[Mapping[str, Any]] = found["failures"]
    if not failures:
        return ["Nothing."]
    shown = failures[:MOST_FAILURES]
    whole = len(shown) == len(failures)
    number = f"All {len(failures)}" if whole else f"{len(shown)} of {len(failures)}"
    looked_into = sum(item["set"] in reasons for item in failures)
    rest = "" if whole else "; `arctrue benchmark score FOLDER` lists all"
    lines = [
        f"{number} sets whose outcome is none that a set should come to, or of which a second name "
        f"is said that is not there{rest}. Each: its world and what is bad in it, what is hidden, "
        "its size (also in limits: over the smallest that the oracle finds), the outcome, what was "
        "said, the command that makes the set again in the folder `FOLDER`, and why it fails: "
        f"{looked_into} of {len(failures)} have been looked into.",
        "",
    ]
    for item in shown:
        bad = f" [{', '.join(item['bad'])}]" if item["bad"] else ""
        lines.append(
            f"- {item['world']}{bad}, {'; '.join(item['hidden']) or 'nothing'}: "
            f"{item['outcome']} ({said_words(item)}). `{item['command']}` "
            f"*{reason_words(item, reasons)}*"
        )
    return lines
