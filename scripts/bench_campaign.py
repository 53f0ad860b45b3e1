"""Measures how campaigns scale: CPU time of the tasks and of the overhead, for 1 and 2 processes.

Run ``python -m scripts.bench_campaign``; ``--write`` puts the table into docs/campaigns.md. The
program measures CPU time, because other work on the machine changes it little; wall-clock seconds
are given together with the load during the measurement.
"""

from __future__ import annotations

import argparse
import os
import resource
import tempfile
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np

from arctrue.studies.benchmark.plan import TIERS, TierPlan
from arctrue.studies.campaign import Campaign, Task, read_results
from arctrue.studies.campaign.task import find_work
from arctrue.studies.monte_carlo.plan import TrialPlan as MonteCarlo
from scripts.bench_rows import Row, add_option, give_out
from scripts.marked_section import MarkedSection

PAGE = Path("docs/campaigns.md")
SECTION = MarkedSection(PAGE, "<!-- scaling: python -m scripts.bench_campaign --write -->\n")
WORKERS = (1, 2)
CLUSTER_CORES, CLUSTER_SETS = 64, 10_000
WORKS = {
    "nothing": "",
    "trial of Monte Carlo": "arctrue.studies.monte_carlo.trial:run_trial",
    "set of the benchmark, made and diagnosed": "arctrue.studies.benchmark.work:run_set",
}


def timed(task: Mapping[str, Any]) -> dict[str, Any]:
    """Do the work of a task of this bench; return the CPU time that the work took."""
    begin = time.process_time()
    if task["work"]:
        find_work(task["work"])(task["task"])
    return {"cpu_s": time.process_time() - begin}


@dataclass(frozen=True, slots=True)
class Measured:
    """Measured times of one campaign."""

    name: str
    workers: int
    tasks: int
    task_cpu_s: float
    """CPU time of the tasks alone."""
    whole_cpu_s: float
    """CPU time of all processes, from start to end."""
    wall_s: float

    @property
    def share(self) -> float:
        """Return the CPU time of the tasks as a share of the CPU time of all processes."""
        return self.task_cpu_s / self.whole_cpu_s


def cpu_s() -> float:
    """Return the CPU time of this process and of its finished child processes."""
    used = [resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
    return sum(item.ru_utime + item.ru_stime for item in used)


def measure(name: str, tasks: Sequence[Task], workers: int, batch: int) -> Measured:
    """Run a campaign in a temporary folder; return the measured times."""
    work = "scripts.bench_campaign:timed"
    timed_tasks = [{"work": WORKS[name], "task": dict(task)} for task in tasks]
    with tempfile.TemporaryDirectory() as place:
        begin, wall = cpu_s(), time.monotonic()
        Campaign(work, timed_tasks, Path(place), {}, batch).run(workers=workers)
        whole, seconds = cpu_s() - begin, time.monotonic() - wall
        own = sum(float(item.result["cpu_s"]) for item in read_results([Path(place)]))
    return Measured(name, workers, len(tasks), own, whole, seconds)


HEADINGS = (
    "task",
    "processes",
    "tasks",
    "CPU s a task",
    "CPU s of all processes",
    "tasks' share of this time, %",
    "tasks a second on free cores",
    "tasks a second, measured",
)


def table(found: Sequence[Measured], load: float) -> list[str]:
    """Return the table as lines of Markdown.

    The first entry of ``found`` is a campaign of a few empty tasks.
    """
    lines = [f"| {' | '.join(HEADINGS)} |", "|" + "---|" * len(HEADINGS)]
    for item in found[1:]:
        cells = (
            item.name,
            str(item.workers),
            f"{item.tasks:,}",
            f"{item.task_cpu_s / item.tasks:.3g}",
            f"{item.whole_cpu_s:.3g}",
            f"{100 * item.share:.0f}",
            f"{item.tasks * item.workers / item.whole_cpu_s:.3g}",
            f"{item.tasks / item.wall_s:.3g}",
        )
        lines.append(f"| {' | '.join(cells)} |")
    few, many = found[0], found[1]
    message_s = (many.whole_cpu_s - few.whole_cpu_s) / (many.tasks - few.tasks)
    sets = found[-1]
    own_s = sets.task_cpu_s / sets.tasks
    around_s = sets.whole_cpu_s - sets.task_cpu_s - message_s * sets.tasks
    start_s = max(0.0, around_s) / sets.workers
    whole_s = CLUSTER_SETS * own_s / CLUSTER_CORES + start_s
    lines += [
        "",
        f"The load of the machine's {os.cpu_count()} cores was {load:.0f} during the measurement, "
        "so the measured rate contains waiting for other work. The rate on free cores is computed "
        "from the CPU time, which is assumed not to change; this holds for one process a core (one "
        f"BLAS thread each). The runner takes {1e3 * message_s:.2g} ms of CPU time per task to "
        f"send it and to write its lines, and {start_s:.2g} s per process for start and imports.",
        "",
        f"Computed time for {CLUSTER_SETS:,} sets on {CLUSTER_CORES} cores: {CLUSTER_SETS:,} · "
        f"{own_s:.2f} s / {CLUSTER_CORES} + {start_s:.2g} s = {whole_s / 60:.0f} min. One process "
        "hands out the tasks and writes the results; this takes "
        f"{CLUSTER_SETS * message_s:.0f} s in total ({CLUSTER_SETS / 1000:.0f} s more with Dask, "
        "which needs 1 ms a task), so no worker waits for it.",
    ]
    return lines


def row(runs: Sequence[Measured]) -> Row:
    """Return a row that compares the CPU time of a campaign, over several runs, with the CPU time
    of its tasks alone."""
    first = runs[0]
    own = float(np.median([item.task_cpu_s / item.tasks for item in runs]))
    share = float(np.median([item.share for item in runs]))
    return Row(
        f"{first.name}, {first.workers} "
        f"{'process' if first.workers == 1 else 'processes'}, {first.tasks:,} tasks",
        "CPU ms a task, all processes",
        tuple(1e3 * item.whole_cpu_s / item.tasks for item in runs),
        f"the work of the tasks alone {1e3 * own:.3g} ms, {100 * share:.0f} %",
    )


def median_run(runs: Sequence[Measured]) -> Measured:
    """Return the run whose CPU time is the median of all runs."""
    return sorted(runs, key=lambda item: item.whole_cpu_s)[len(runs) // 2]


def main(arguments: Sequence[str] | None = None) -> int:
    """Measure the campaigns and print the table; with ``--write`` update docs/campaigns.md."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--sets", type=int, default=4, help="benchmark sets per run")
    parser.add_argument(
        "--trials", type=int, default=10, help="Monte Carlo trials, in 8 cases each"
    )
    parser.add_argument("--empty", type=int, default=2000, help="number of empty tasks")
    parser.add_argument("--runs", type=int, default=3, help="runs of each campaign")
    parser.add_argument("--write", action="store_true", help=f"write the table into {PAGE}")
    add_option(parser)
    given = parser.parse_args(arguments)
    tier = TIERS["dev"]
    plan = TierPlan("dev", tier.sets, tier.samples, tier.seed or 0, "", "")
    works: dict[str, tuple[Sequence[Task], int]] = {
        "nothing": ([{"number": number} for number in range(given.empty)], 1),
        "trial of Monte Carlo": (MonteCarlo(given.trials, 1).tasks(), 10),
        "set of the benchmark, made and diagnosed": (plan.tasks("arctrue")[: given.sets], 1),
    }
    few = measure("nothing", works["nothing"][0][:20], 1, 1)
    found = [
        [measure(name, tasks, workers, batch) for _ in range(max(given.runs, 1))]
        for name, (tasks, batch) in works.items()
        for workers in WORKERS
    ]
    lines = table([few, *(median_run(runs) for runs in found)], os.getloadavg()[1])
    print("\n".join(lines))
    if given.write:
        SECTION.write("\n".join(lines) + "\n")
    return give_out([row(runs) for runs in found], given.rows)


if __name__ == "__main__":
    raise SystemExit(main())
