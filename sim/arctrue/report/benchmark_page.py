"""Makes the page of the benchmark, which compares scores with their goals."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from arctrue.studies.benchmark.cases import Reason
from arctrue.studies.benchmark.intervals import Rate
from arctrue.studies.benchmark.outcome import (
    FALSE_ADEQUATE,
    FALSE_CLASS,
    FALSE_NAME,
    GOOD,
    OUTCOMES,
)
from arctrue.studies.benchmark.perfect import perfect_calibration
from arctrue.studies.benchmark.plan import SCORING, files_digest
from arctrue.studies.benchmark.score import (
    FALSE,
    INDEPENDENT,
    SCORES,
    SIMULATED,
    goal_of,
)
from arctrue.studies.campaign.store import stated_code

SETS_PAGE = "benchmark-sets.md"
MOST_FAILURES = 12
"""Largest number of failures on the page; the page lists them in the order of SEVEREST."""
SEVEREST = {FALSE_NAME: 0, FALSE_ADEQUATE: 1, FALSE_CLASS: 2}
PICTURE_TEXT = "Confusion matrix, and how often a stated probability is right"
RIGHT_FIRST = "right first, of what the oracle sees of the catalogue"
PROBABILITY_BELOW_RIGHT = 0.03
MOST_CALIBRATION_ERROR = {SIMULATED: 0.03, INDEPENDENT: 0.05}
"""Goals of the calibration error: the largest permitted error for the sets of the simulated table
(within) and for those of the package ``independent`` (across)."""
TRUTH_PROBABILITY = "probability given to the truth in the catalogue"
CALIBRATION_ERROR = "calibration error"
LOG_SCORE = "log score over that of a constant"
FIGURES = {CALIBRATION_ERROR: "calibration_error", LOG_SCORE: "log_score_gain"}
"""Keys of the scores of stated probabilities in the score file, by the names of the scores."""

HEAD = """# How often the diagnosis is right

`arctrue benchmark` hides causes in simulated tables and gives the diagnosis only the folder of the
measurement set. The answer is compared with the truth and with an *oracle*: the generalised
likelihood ratio, computed with the cause's exact form and the covariance by which the noise was
drawn. The oracle *sees* a cause that it would find in 95 % of such sets at a false alarm of 1 %,
including the search for an order, a frequency or an instant. A cause that changes the prediction by
less than half a count RMS does not count as visible.

    make benchmark                               # dev: 650 sets; TIER=quick, public, sealed, cases
    make benchmark TIER=calibration              # 195 sets: how often a sure answer is wrong
    make benchmark TIER=sealed SETS="--generator both --limit 1500"  # a fifth: second generator
    arctrue benchmark make FOLDER --tier sealed  # seals generator and scoring, then draws the seed
    arctrue benchmark run FOLDER                 # --workers N, --scheduler ADDRESS, --shard i/n
    arctrue benchmark score FOLDER               # every rate; --answers FILE: other answers
    arctrue benchmark bound FOLDER               # each effect at its stated detectable size
    make peers                                   # rivals; PUBLIC: build/benchmark/public
    arctrue benchmark score FOLDER --keep        # its failures become cases, for TIER=cases
    arctrue benchmark page FOLDER --peers PUBLIC --to docs/benchmark.md --out docs/images

The field `looked_into` of a case in `sim/arctrue/studies/benchmark/cases.json` states why it
fails, and this page repeats it. After an intended change of the generator, `arctrue benchmark
sets` with `--freeze` freezes the new public sets.

A run can be stopped with Ctrl-C and continues where it stopped; results do not depend on the
number of workers or shards. A folder holds results of one state of the code only. On a cluster:
[campaigns](campaigns.md).
"""

READING = """## How to read it

*False name*: the answer names an effect that is not in the set; any name for a stranger is false.
*Falsely adequate*: the answer is that nothing is missing, although the oracle sees something.
*Right*: the answer names the truth. *First in class*: the answer is a class that this set cannot
separate, and the truth is first in it. *In class*: the truth is listed, but another effect is
first. If a set has several causes, each counts as the truth. A wrongly stated separation of the
heads is a `head_angle_error`. *Silent*: the answer is `cannot_tell`, although the oracle sees
something. *Stranger*: a cause that no effect of the catalogue and no product of parts describes.
*Product of parts*: a condition (temperature, speed, settling) times a wave of one order on the
disc, the stator or a head. *Damped oscillation*: a resonance that noise drives; every name is
false, and `unknown` is right if the frequency is stated within the half width at half power. *A
second name that is not there*: in addition to the right name, the answer names an effect that is
not in the set. Intervals are Clopper–Pearson, 95 %.
"""


PEERS_STATED = {
    "arctrue": "`arctrue diagnose`.",
    "stepwise_bic": (
        "Stepwise regression: it adds the effect whose columns lower the BIC most, up to three "
        "effects, and assumes white noise. It always names an effect."
    ),
    "periodogram_rule": (
        "A rule of thumb: the strongest line of the residual in angle or time at a false alarm of "
        "1 % names one of four effects."
    ),
    "gaussian_process": (
        "A smooth discrepancy over all conditions (Kennedy and O'Hagan, by scikit-learn): it "
        "detects an error and names no effect."
    ),
}


def benchmark_page(
    header: Mapping[str, Any],
    found: Mapping[str, Any],
    peers: Mapping[str, Mapping[str, Any]] | None = None,
    reasons: Mapping[str, Reason] | None = None,
    picture: str | None = None,
) -> str:
    """Return the page as Markdown, from the header of the campaign and the scores.

    ``peers``: the scores of each competing program on the frozen public sets. ``reasons``: the
    known reasons of failures, by the name of the set. ``picture``: address at which the page links
    the picture of confusion matrix and reliability curve.
    """
    lines = [HEAD, "## Result", "", *_provenance(header, found), ""]
    lines += [*_rates(found), "", *_by_world(found)]
    lines += ["", *_probabilities(found), "", *_held_out(found), "", *_sizes(found), ""]
    lines += [*_by_effect(found), ""]
    if peers:
        lines += ["### Against simple rivals", "", *_peers(peers, header), ""]
    if picture is not None:
        lines += [f"![{PICTURE_TEXT}]({picture})", ""]
    lines += ["### Outcomes that should not be", "", *_failures(found, reasons or {}), ""]
    lines += [
        READING.rstrip(),
        "",
        f"[The sets of the benchmark]({SETS_PAGE}) describes the sets.",
        "",
    ]
    return "\n".join(lines)


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
        f"that the oracle sees. {stated_code(header)}, generator `{plan['generator']}`, scored by "
        f"`{files_digest(SCORING)}`; {libraries}.",
        "",
        _goals_met(found),
    ]


def _goals_met(found: Mapping[str, Any]) -> str:
    """Return one sentence that lists the goals that are met and those that are missed, over all
    sets."""
    met: list[str] = []
    missed: list[str] = []
    for score in SCORES:
        goal, data = goal_of(score, "all"), found["rates"][score.name]["all"]
        if goal == (None, None) or not data["of"]:
            continue
        text = f"{score.name} ({100 * data['hits'] / data['of']:.1f} %, goal {_goal(*goal)})"
        (missed if _missed(data, *goal) else met).append(text)
    for name, value, goal_text, kept in _goals_of_probabilities(found):
        (met if kept else missed).append(f"{name} ({value:.3f}, goal {goal_text})")
    return f"Goals over all sets, met: {'; '.join(met) or 'none'}. Missed: " + (
        f"{'; '.join(missed)}." if missed else "none."
    )


def _goals_of_probabilities(found: Mapping[str, Any]) -> list[tuple[str, float, str, bool]]:
    """Return name, value and goal of each score of probabilities, and whether the goal is met;
    empty if the answers state no probability."""
    stated = found["probability"]
    if stated is None:
        return []
    goals = []
    right, truth = found["rates"][RIGHT_FIRST]["all"], stated["mean_of_truth_of_catalogue"]
    if truth is not None:
        least = right["hits"] / right["of"] - PROBABILITY_BELOW_RIGHT
        goals.append((TRUTH_PROBABILITY, truth, f"≥ {least:.3f}", truth >= least))
    for name, given in found["probability_by_generator"].items():
        if given is not None:
            error, most = given["calibration_error"]["value"], MOST_CALIBRATION_ERROR[name]
            goals.append((f"{CALIBRATION_ERROR}, {name}", error, f"≤ {most:g}", error <= most))
            gain = given["log_score_gain"]["value"]
            goals.append((f"{LOG_SCORE}, {name}", gain, "> 0", gain > 0))
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


def _rates(found: Mapping[str, Any]) -> list[str]:
    columns = ["all", *_generators(found)]
    lines = [
        "Each cell states the rate in percent, its 95 % interval, and the number of sets that "
        "count. A rate in bold misses its goal.",
        "",
        "| | goal | " + " | ".join(columns) + " |",
        "|---|---|" + "---|" * len(columns),
    ]
    for score in SCORES:
        rates = found["rates"][score.name]
        goal = goal_of(score, "all")
        cells = []
        for name in columns:
            text = _percent(rates[name])
            cells.append(f"**{text}**" if _missed(rates[name], *goal) else text)
        lines.append(f"| {score.name} | {_goal(*goal)} | " + " | ".join(cells) + " |")
    return lines


def _generators(found: Mapping[str, Any]) -> list[str]:
    """Return the names of the generators, which become columns of a table; return none if there is
    only one."""
    names: list[str] = found["generators"]
    return names if len(names) > 1 else []


def _by_world(found: Mapping[str, Any]) -> list[str]:
    """Return a table with one row per world: the rates that decide, and the number of wrong
    outcomes of each kind."""
    false, right = found["rates"][FALSE], found["rates"][RIGHT_FIRST]
    (first,) = (score for score in SCORES if score.name == RIGHT_FIRST)
    (false_goal,) = (score for score in SCORES if score.name == FALSE)
    assert false_goal.world_at_most is not None
    lines = [
        "The table has a row for each world. In bold: a rate of *false name or falsely adequate* "
        f"whose interval begins above {100 * false_goal.world_at_most:g} % (the world then fails), "
        "and a rate of *right first* below 90 % (white: 97 %).",
        "",
        "| world | false name or falsely adequate | right first, where seen | outcomes that should "
        "not be |",
        "|---|---|---|---|",
    ]
    for world, outcomes in found["outcomes"].items():
        text = _percent(false[world])
        wrong = ", ".join(
            f"{name} {outcomes[name]}" for name in OUTCOMES if name in outcomes and name not in GOOD
        )
        cells = [
            f"**{text}**" if world in found["failed_worlds"] else text,
            f"**{_percent(right[world])}**"
            if _missed(right[world], *goal_of(first, world))
            else _percent(right[world]),
        ]
        lines.append(f"| {world} | {' | '.join(cells)} | {wrong} |")
    return lines


def _peers(peers: Mapping[str, Mapping[str, Any]], header: Mapping[str, Any]) -> list[str]:
    first = next(iter(peers.values()))
    whole = first["header"]["plan"]["sets"]
    tier = first["header"]["plan"]["tier"]
    sets = f"The {whole}" if first["sets"] == whole else f"The same {first['sets']} of the {whole}"
    lines = [
        f"{sets} sets of the tier *{tier}*{', which are frozen' if tier == 'public' else ''}: "
        f"{first['visible']} with something that the oracle sees; one program scores all answers. "
        "Each cell states the rate in percent, its 95 % interval, and the number of sets that "
        "count:",
        "",
        "| | " + " | ".join(peers) + " |",
        "|---|" + "---|" * len(peers),
    ]
    for score in SCORES:
        cells = [_percent(scores["rates"][score.name]["all"]) for scores in peers.values()]
        lines.append(f"| {score.name} | " + " | ".join(cells) + " |")
    lines.append("")
    lines += [
        f"- `{name}`: {PEERS_STATED[name]} {stated_code(scores['header'])}."
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


def _perfect(bins: Sequence[Mapping[str, Any]]) -> tuple[float, float]:
    """Return mean and 95th percentile of the calibration error of a perfect calibration; every
    answer has the mean stated probability of its bin."""
    of_bins = [np.full(item["of"], item["mean_probability"]) for item in bins]
    return perfect_calibration(np.concatenate(of_bins).tolist())


def _probabilities(found: Mapping[str, Any]) -> list[str]:
    stated = found["probability"]
    if stated is None:
        return ["The answers state no probability (schema 1), so none is scored."]
    text, goals = {}, {}
    for name, value, goal, kept in _goals_of_probabilities(found):
        text[name], goals[name] = f"{value:.3f}" if kept else f"**{value:.3f}**", goal
    truth = []
    if stated["mean_of_truth_where_visible"] is not None:
        truth.append(f"{stated['mean_of_truth_where_visible']:.3f} over all that the oracle sees")
    if TRUTH_PROBABILITY in goals:
        truth.append(
            f"{text[TRUTH_PROBABILITY]} over the part in the catalogue (goal "
            f"{goals[TRUTH_PROBABILITY]}: the rate of right first minus "
            f"{PROBABILITY_BELOW_RIGHT:g})"
        )
    lines = [
        f"Mean probability that is given to the truth: {', '.join(truth) or 'nothing is seen'}. "
        "The calibration error is the mean distance between the stated probability and the share "
        "of right answers, over ten bins with equal numbers of sets. The second table shows the "
        "bins of all sets together. The log score of the largest probability of each answer is "
        "stated in nats above the best constant probability; its 95 % interval is from a bootstrap "
        "over the sets. In place of an interval, the calibration error has the mean error of a "
        "perfect calibration with the same stated values, and the value that 5 % of such runs "
        "exceed.",
        "",
        "| | goal | value |",
        "|---|---|---|",
    ]
    for name, by_generator in found["probability_by_generator"].items():
        if by_generator is None:
            continue
        for figure, key in FIGURES.items():
            item, label = by_generator[key], f"{figure}, {name}"
            interval = f"{item['low']:.3f} … {item['high']:.3f}"
            if figure == CALIBRATION_ERROR:
                interval = "perfect: {:.3f}, {:.3f}".format(*_perfect(by_generator["reliability"]))
            lines.append(f"| {label} | {goals[label]} | {text[label]} ({interval}) |")
    lines += ["", "| largest probability, mean | right, percent |", "|---|---|"]
    lines += [
        f"| {item['mean_probability']:.3f} | {_percent(item)} |" for item in stated["reliability"]
    ]
    kinds = (f"{kind} {of['hits']} of {of['of']}" for kind, of in stated["right_of"].items())
    return [
        *lines,
        "",
        f"Right answers, by the kind that has the largest probability: {', '.join(kinds)}.",
    ]


def _held_out(found: Mapping[str, Any]) -> list[str]:
    ratios = found["held_out_over_floor"]
    if ratios is None:
        return []
    text = ", ".join(f"{name} {value:.3f}" for name, value in ratios.items())
    return [
        f"Held-out error of the right answers, divided by the noise that the generator added: "
        f"{text}."
    ]


def _sizes(found: Mapping[str, Any]) -> list[str]:
    lines = [
        "### Size against the oracle",
        "",
        "For sets with one cause of the catalogue, the table states the percentage of the "
        "answers that put this cause first. The size is stated in limits; a limit is the smallest "
        "size that the oracle finds.",
        "",
        "| size in limits | put first |",
        "|---|---|",
    ]
    for item in found["found_by_size_in_limits"]:
        above = f"{item['from']:g} … {item['to']:g}" if item["to"] else f"above {item['from']:g}"
        lines.append(f"| {above} | {_percent(item)} |")
    return lines


def _by_effect(found: Mapping[str, Any]) -> list[str]:
    """Return a sentence that states for each effect the number of sets whose answer names it first,
    and the largest size at which an answer did not name it first."""
    text = []
    for name, item in found["found_by_effect"].items():
        largest = item["largest_not_put_first"]
        missed = "" if largest is None else f" ({largest:.3g})"
        text.append(f"{name} {item['hits']} of {item['of']}{missed}")
    return [
        "Answers that put the cause first, by effect; in brackets the largest size, in limits, "
        f"at which the cause was not put first: {', '.join(text) or 'none'}."
    ]


def said_words(item: Mapping[str, Any]) -> str:
    """Return the answer in a failed set in words: verdict or name, a second name, or the error."""
    further = f", and in addition {item['second_name']}" if item["second_name"] else ""
    error = f": {item['error']}" if item["error"] else ""
    return f"{item['said']}{further}{error}"


def reason_words(item: Mapping[str, Any], reasons: Mapping[str, Reason]) -> str:
    """Return a sentence with the reason of a failure, or that the failure is not examined."""
    reason = reasons.get(item["set"])
    if reason is None:
        return "Not examined yet."
    if reason.said != said_words(item):
        return f"Examined when the answer was {reason.said}: {reason.why}"
    return f"Why: {reason.why}"


def _failures(found: Mapping[str, Any], reasons: Mapping[str, Reason]) -> list[str]:
    failures: Sequence[Mapping[str, Any]] = found["failures"]
    if not failures:
        return ["Nothing."]
    shown = sorted(failures, key=lambda item: SEVEREST.get(item["outcome"], len(SEVEREST)))
    shown = shown[:MOST_FAILURES]
    whole = len(shown) == len(failures)
    number = f"All {len(failures)}" if whole else f"{len(shown)} of {len(failures)}"
    looked_into = sum(item["set"] in reasons for item in failures)
    rest = "" if whole else "; `arctrue benchmark score FOLDER` lists all"
    lines = [
        f"{number} sets with an outcome that should not be, or with a second name that is not "
        f"there{rest}. The size in limits is the size divided by the smallest size that the oracle "
        f"finds. The command in each line makes its set again; {looked_into} of {len(failures)} "
        "have been examined.",
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
