"""Estimates the longest paths of an entity: ``python -m scripts.timing``.

The script reads the flat netlist that ``--netlist`` names, or makes one. For each of the longest
paths it states the delay, the levels of logic and the slack at 10 ns (100 MHz) and 5 ns (200 MHz).
The netlist is not placed, and wire delays are estimates: see scripts/cell_delays.py. It also checks
a rule that needs no estimate: no path has more than one wide adder or DSP, except the paths listed
in this file. Result: timing.md next to the netlist. Exit code 1: the rule is broken or a path is
longer than ``--limit``. 2: a tool is missing or fails.
"""

from __future__ import annotations

import argparse
import re
import sys
from pathlib import Path
from typing import Final

from scripts.entity_options import add_entity_options, generics_of
from scripts.netlist import ROOT, ToolError, synthesise, write_netlist
from scripts.timing_paths import Crowded, LongPath, Netlist, crowded_registers, longest_paths

TOP: Final = "arctrue_core"
PERIODS_NS: Final = (10.0, 5.0)
SHOWN: Final = 15

# Registers at which a path with more than one wide adder may end, and the reason for each.
EXCEPTIONS: Final[tuple[tuple[str, str], ...]] = ()


def split_exceptions(
    crowded: list[Crowded], exceptions: tuple[tuple[str, str], ...] = EXCEPTIONS
) -> tuple[list[Crowded], list[tuple[Crowded, str]]]:
    """Separate the paths that break the rule of one adder from the paths that are permitted for a
    stated reason."""
    broken, excused = [], []
    for entry in crowded:
        reasons = [reason for pattern, reason in exceptions if re.search(pattern, entry.end)]
        if reasons:
            excused.append((entry, reasons[0]))
        else:
            broken.append(entry)
    return broken, excused


def table(paths: list[LongPath], shown: int = SHOWN) -> str:
    """Return the longest paths in Markdown, one for each register."""
    head = " | ".join(f"left of {period:g} ns" for period in PERIODS_NS)
    lines = [
        f"| from | to | ns | LUT levels | CARRY4 | wires | {head} |",
        "|---|---|---:|---:|---:|---:|" + "---:|" * len(PERIODS_NS),
    ]
    for path in paths[:shown]:
        left = " | ".join(f"{period - path.delay_ns:.1f}" for period in PERIODS_NS)
        lines.append(
            f"| `{path.start}` | `{path.end}` | {path.delay_ns:.1f} | {path.levels} "
            f"| {path.carry4} | {path.wires} | {left} |"
        )
    return "\n".join(lines)


def report(
    netlist: Path, top: str, title: str, shown: int = SHOWN
) -> tuple[str, list[Crowded], float]:
    """Return the text of timing.md, the paths that break the rule, and the longest path in ns.

    Raises ValueError for an unknown cell, and for logic that feeds itself.
    """
    design = Netlist.read(netlist, top)
    found = design.reached()
    paths = longest_paths(design, found)
    broken, excused = split_exceptions(crowded_registers(design, found))
    slowest = paths[0].delay_ns if paths else 0.0
    lines = [
        title,
        "",
        "An estimate: delays of cells from Yosys' models, wires guessed, nothing placed.",
        f"Longest path {slowest:.1f} ns. Registers whose longest path is above "
        + ", ".join(
            f"{period:g} ns: {sum(path.delay_ns > period for path in paths)}"
            for period in PERIODS_NS
        )
        + f", of {len(paths)}.",
        "",
        table(paths, shown),
        "",
        f"Paths with more than one wide adder or DSP: {len(broken)} without a reason, "
        f"{len(excused)} with one.",
        *(f"- `{entry.end}` from `{entry.start}`: {entry.adders}" for entry in broken),
        *(f"- `{entry.end}`: {entry.adders}. {reason}" for entry, reason in excused),
    ]
    return "\n".join(lines) + "\n", broken, slowest


def main(arguments: list[str] | None = None) -> int:
    """Write timing.md for the entity that the command line names and check the rule; return the
    exit code."""
    parser = argparse.ArgumentParser(description=__doc__)
    add_entity_options(parser, TOP)
    parser.add_argument("--netlist", type=Path, help="a flat JSON netlist that is there already")
    parser.add_argument("--limit", type=float, metavar="NS", help="longest path that is accepted")
    parser.add_argument("--shown", type=int, default=SHOWN, help=f"paths in the table ({SHOWN})")
    parser.add_argument("--output", type=Path, help="folder, made anew (build/timing/<entity>)")
    chosen = parser.parse_args(arguments)
    generics = generics_of(parser, chosen)
    try:
        netlist = chosen.netlist
        if netlist is None:
            folder = (chosen.output or ROOT / "build" / "timing" / chosen.entity).resolve()
            written = write_netlist(chosen.entity, folder, generics=generics)
            netlist = synthesise(written, flatten=True)
        values = ", ".join(f"{name} = {value}" for name, value in generics.items())
        title = f"{chosen.entity}{f' ({values})' if values else ''}"
        text, broken, slowest = report(netlist, chosen.entity, title, chosen.shown)
    except (ToolError, ValueError, OSError) as error:
        print(f"timing: {error}", file=sys.stderr)
        return 2
    (netlist.parent / "timing.md").write_text(text, encoding="utf-8")
    print(text)
    for entry in broken:
        print(
            f"timing: {entry.adders} wide adders or DSPs on a path from {entry.start} to "
            f"{entry.end}; put a register between them, or name the reason in scripts/timing.py",
            file=sys.stderr,
        )
    too_long = chosen.limit is not None and slowest > chosen.limit
    if too_long:
        print(
            f"timing: the longest path takes {slowest:.1f} ns by the estimate, expected "
            f"{chosen.limit:g} ns at the most",
            file=sys.stderr,
        )
    return 1 if broken or too_long else 0


if __name__ == "__main__":
    raise SystemExit(main())
