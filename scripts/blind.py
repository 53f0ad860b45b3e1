"""Blind test of the diagnosis: sealed sets, of which it sees the folder only.

``make blind``, or ``python -m scripts.blind [--quick] [--only TEXT] [--resume]``. Writes
build/blind/outcomes.json and build/blind/confusion.md. Exit code 1 when a set of ``--quick``
comes out worse than it should, 0 else: the long test is read, not passed.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections import Counter
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from scripts.blind_cases import FIRST_SEED, Case, all_cases, quick_cases
from scripts.blind_judge import GOOD, OUTCOMES, Outcome, is_stranger, run_case

OUT = Path(__file__).resolve().parents[1] / "build" / "blind"


SETTLED = ("right", "unknown, rightly")
"""What an ambiguous set should become."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the cases asked for and write both files after every set."""
    options = _options(arguments)
    cases = quick_cases() if options.quick else list(all_cases(options.seeds, options.first_seed))
    if options.only:
        cases = [case for case in cases if options.only in f"{case.experiment}:{case.label}"]
    if options.level:
        cases = [case for case in cases if case.level == options.level]
    if options.samples:
        cases = [
            Case(case.names, case.experiment, case.level, case.seed, options.samples, 10)
            for case in cases
        ]
    OUT.mkdir(parents=True, exist_ok=True)
    outcomes: list[Outcome] = []
    if options.resume:
        earlier = json.loads((OUT / "outcomes.json").read_text(encoding="utf-8"))
        outcomes = [Outcome.of(item) for item in earlier]
    done = {item.case for item in outcomes}
    for number, case in enumerate(cases, start=1):
        if case in done:
            continue
        outcome = run_case(case)
        outcomes.append(outcome)
        print(
            f"{number}/{len(cases)} {case.experiment} {case.label} ({outcome.size}, seed "
            f"{case.seed}): {outcome.outcome}; {_said(outcome)}; {outcome.seconds:.0f} s",
            flush=True,
        )
        (OUT / "outcomes.json").write_text(
            json.dumps([item.data() for item in outcomes], indent=1) + "\n", encoding="utf-8"
        )
        (OUT / "confusion.md").write_text(report(outcomes), encoding="utf-8")
    print(report(outcomes))
    return int(options.quick and any(item.outcome not in GOOD for item in outcomes))


def _options(arguments: Sequence[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(description="Blind test of the diagnosis.")
    parser.add_argument("--quick", action="store_true", help="a small fixed part, small sets")
    parser.add_argument("--only", default="", help="cases with this text: full:hysteresis")
    parser.add_argument("--level", default="", help="small, middle or large only")
    parser.add_argument("--seeds", type=int, default=2, help="sets of each kind and size")
    parser.add_argument(
        "--first-seed", type=int, default=FIRST_SEED, help="other sets: the seed of the first one"
    )
    parser.add_argument("--samples", type=int, default=0, help="samples a run, if not all")
    parser.add_argument("--resume", action="store_true", help="go on where the last run ended")
    return parser.parse_args(arguments)


def _said(outcome: Outcome) -> str:
    if outcome.second is not None:
        return f"{outcome.named}, then {outcome.second}"
    if outcome.verdict == "unknown":
        return f"unknown: {', '.join(outcome.parts)}"
    if outcome.verdict == "ambiguous":
        told = f"ambiguous: {', '.join(outcome.effect_class)}"
        return f"{told}; after {outcome.next_kind}: {outcome.after_next}"
    return outcome.named or outcome.verdict


def report(outcomes: Sequence[Outcome]) -> str:
    """Summary, confusion table and held-out error as Markdown."""
    lines = ["# Blind test of the diagnosis", "", *summary(outcomes), ""]
    for experiment in ("full", "lean"):
        chosen = [item for item in outcomes if item.case.experiment == experiment]
        if chosen:
            lines += [f"## {experiment.capitalize()} sets", "", *confusion(chosen), ""]
    wrong = faults(outcomes)
    if wrong:
        lines += ["## Not as it should be", "", *wrong, ""]
    return "\n".join(lines)


def faults(outcomes: Sequence[Outcome]) -> list[str]:
    """Sets whose outcome is not good, one line each."""
    return [
        f"- {item.case.experiment}, {item.hidden}, {item.size}, seed {item.case.seed}: "
        f"{item.outcome} ({_said(item)})"
        for item in outcomes
        if item.outcome not in GOOD
    ]


def _share(part: int, whole: int) -> str:
    return f"{part} of {whole} ({100 * part / whole:.0f} %)" if whole else "no such set"


def summary(outcomes: Sequence[Outcome]) -> list[str]:
    """Shares that the goals are stated for, one line each."""
    full = [item for item in outcomes if item.case.experiment == "full"]
    single = [item for item in full if len(item.case.names) == 1]
    known = [item for item in single if not is_stranger(item.case) and item.visible]
    strange = [item for item in single if is_stranger(item.case) and item.visible]
    none = [item for item in full if not item.case.names]
    lean = [item for item in outcomes if item.case.experiment == "lean"]
    pairs = [item for item in full if len(item.case.names) == 2 and not is_stranger(item.case)]
    asked = [item for item in outcomes if item.after_next is not None]
    both = sum({item.named, item.second} == set(item.case.names) for item in pairs)

    def count(items: Sequence[Outcome], *wanted: str) -> str:
        return _share(sum(item.outcome in wanted for item in items), len(items))

    after = [
        pair[1]
        for item in [*known, *strange]
        if item.outcome in ("right", "unknown, rightly")
        for pair in item.held_out_over_floor.values()
    ]
    worst = f"{np.median(after):.3f} median, {max(after):.3f} largest" if after else "no such set"
    return [
        f"- visible effects of the catalogue, full sets, right first: {count(known, 'right')}",
        f"- the same, right or first in the class: {count(known, 'right', 'first in class')}",
        f"- the same, right or in the class: {count(known, 'right', 'first in class', 'in class')}",
        f"- the same, falsely adequate: {count(known, 'falsely adequate')}",
        f"- false name, all full sets with one effect: {count(single, 'false name')}",
        f"- false name on sets without any effect: {count(none, 'false name')}",
        "- effects in no catalogue called unknown with the right parts: "
        f"{count(strange, 'unknown, rightly')}",
        f"- two effects at once, both named one after the other: {_share(both, len(pairs))}",
        f"- false name on lean sets: {count(lean, 'false name')}",
        "- ambiguous sets that are named after the next measurement was made and added: "
        f"{_share(sum(item.after_next in SETTLED for item in asked), len(asked))}",
        f"- held-out error over the floor, after what was rightly named is added: {worst}",
    ]


def confusion(outcomes: Sequence[Outcome]) -> list[str]:
    """Outcomes by hidden cause; held-out error over the floor, the worse channel, median."""
    used = [name for name in OUTCOMES if any(item.outcome == name for item in outcomes)]
    lines = [
        "| hidden | sets | visible | " + " | ".join(used) + " | held-out/floor before | after |",
        "|---|---|---|" + "---|" * (len(used) + 2),
    ]
    for hidden in dict.fromkeys(item.hidden for item in outcomes):
        rows = [item for item in outcomes if item.hidden == hidden]
        counts = Counter(item.outcome for item in rows)
        cells = [str(counts[name] or "") for name in used]
        ratios = [max(item.held_out_over_floor.values()) for item in rows if _has_ratios(item)]
        worst = [f"{np.median([pair[k] for pair in ratios]):.2f}" if ratios else "" for k in (0, 1)]
        visible = sum(item.visible for item in rows)
        lines.append(
            f"| {hidden} | {len(rows)} | {visible} | " + " | ".join([*cells, *worst]) + " |"
        )
    return lines


def _has_ratios(item: Outcome) -> bool:
    return bool(item.held_out_over_floor)


if __name__ == "__main__":
    sys.exit(main())
