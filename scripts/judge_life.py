"""Tests the forecast of ``arctrue life`` on simulated lives, which are series of calibrations of
one machine over the years.

Run ``python -m scripts.judge_life``; ``--write`` puts the table into docs/life.md. The exit code is
1 if fewer than 95 % of the failing lives have an alarm before the limit, or if there is more than
one false alarm per machine and year: these are the requirements of the forecast.
"""

from __future__ import annotations

import argparse
import os
import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

from arctrue.metrology.life.history import FALSE_ALARMS_A_YEAR, HORIZON_DAYS
from arctrue.studies.campaign import Campaign, read_results
from arctrue.studies.life.judge import summary, tasks
from scripts.marked_section import MarkedSection

PAGE = Path("docs/life.md")
SECTION = MarkedSection(PAGE, "<!-- lives: python -m scripts.judge_life --write -->\n")
IN_TIME, FALSE_A_YEAR = 0.95, 1.0
"""Required share of failing lives with an alarm in time, and permitted number of false alarms per
machine and year."""
HEADINGS = (
    "kind of life",
    "lives",
    "lives that pass the limit",
    "alarm before the limit, %",
    "median days from alarm to limit",
    "interval contains the day",
    "machine-years without damage",
    "false alarms per year",
)


def table(rows: Sequence[Mapping[str, Any]], lives: int, seed: int) -> list[str]:
    """Return the table as lines of Markdown."""
    lines = [f"| {' | '.join(HEADINGS)} |", "|" + "---|" * len(HEADINGS)]
    for row in rows:
        share, rate = row["in_time_interval"], row["false_interval"]
        cells = [row["kind"], str(row["lives"]), str(row["passing"])]
        if share is None:
            cells += ["–", "–", "–"]
        else:
            cells += [
                f"{100 * row['in_time'] / row['passing']:.1f} "
                f"({100 * share[0]:.1f} to {100 * share[1]:.1f})",
                "–" if row["lead_days"] is None else f"{row['lead_days']:.0f}",
                f"{row['covered']} of {row['forecasts']}",
            ]
        cells += [
            f"{row['years']:.1f}",
            f"{row['false_alarms'] / row['years']:.2f} ({rate[0]:.2f} to {rate[1]:.2f})",
        ]
        lines.append(f"| {' | '.join(cells)} |")
    return [
        *lines,
        "",
        f"{lives} lives, seed {seed}; in brackets 95 % intervals (Clopper and Pearson; Garwood). "
        f"`--false-alarms {FALSE_ALARMS_A_YEAR:g} --horizon {HORIZON_DAYS:g}`, the defaults.",
    ]


def main(arguments: Sequence[str] | None = None) -> int:
    """Evaluate the lives and print the table; with ``--write`` update the page."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--lives", type=int, default=300, help="lives, of all kinds together")
    parser.add_argument("--seed", type=int, default=1, help="seed of the first life")
    parser.add_argument("--workers", type=int, default=1, help="processes")
    parser.add_argument("--write", action="store_true", help=f"write the table into {PAGE}")
    given = parser.parse_args(arguments)
    with tempfile.TemporaryDirectory() as place:
        work = "arctrue.studies.life.judge:run_lives"
        campaign = Campaign(work, tasks(given.lives, given.seed), Path(place), {}, 10)
        campaign.run(workers=given.workers)
        rows = summary([item.result for item in read_results([Path(place)])])
    lines = table(rows, given.lives, given.seed)
    print("\n".join(lines))
    if given.write:
        SECTION.write("\n".join(lines) + "\n")
    whole = rows[-1]
    enough = whole["in_time"] >= IN_TIME * whole["passing"]
    return 0 if enough and whole["false_alarms"] <= FALSE_A_YEAR * whole["years"] else 1


if __name__ == "__main__":
    raise SystemExit(main())
