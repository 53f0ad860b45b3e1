"""Counts the resources of the gateware on an XC7Z020 and checks the budgets: ``make synth``.

GHDL makes a netlist. Yosys maps it twice: flattened, for the sum that the budget limits, and unit
by unit, for the table. Results: build/synth/<entity>/resources.json and resources.md. With
``--folds 2 4 8`` the core is also mapped with each of these folds, flattened; one table compares
these folds with FOLD = 1 (build/synth/folds.md and folds.json). ``--everything`` maps, in place of
one entity, the core with four heads and all units, flattened, with both kinds of rotation
(build/synth/everything.md and everything.json). Exit code 1: a budget is exceeded, or a fold saves
no LUTs or no DSPs. 2: a tool is missing or fails.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from itertools import pairwise
from pathlib import Path

from scripts.entity_options import add_entity_options, generics_of
from scripts.netlist import ROOT, ToolError, find_ghdl, find_yosys, synthesise, write_netlist
from scripts.resources import Design, Resources

TOP = "arctrue_core"
LANES = 32
LANE_PARTS = ("phase_lane", "harmonic_lane")


@dataclass(frozen=True)
class Budget:
    """Largest permitted number of one kind of resource in a part of the gateware."""

    part: str
    kind: str
    limit: float


# These budgets apply to 32 lanes with register block and headers; the XC7Z020 has 53,200 LUT,
# 106,400 FF, 220 DSP48E1, 140 RAMB36.
BUDGETS = (
    Budget("core", "lut", 38_000),
    Budget("core", "ff", 40_000),
    Budget("core", "dsp", 170),
    Budget("core", "ramb36", 60),
    Budget("core", "latches", 0),
    Budget("lane", "lut", 1_050),
)


# The largest core that the generics of arctrue_core describe, apart from more lanes.
EVERYTHING: Mapping[str, int | str] = {
    "HEADS": 4,
    "MEAN": True,
    "MODULATORS": True,
    "REAL_ORDERS": True,
    "LOCAL_TABLE": True,
    "FAILOVER": True,
    "EVENTS": True,
}

# These budgets apply to EVERYTHING with 32 lanes and FOLD = 1, by ROTATION: 77 % of the LUTs of the
# XC7Z020 with the CORDIC and 56 % with the table, 80 % of its block RAMs. The core with the
# table takes 29,152 LUT; its budget is the goal.
BUDGETS_OF_EVERYTHING = {
    rotation: (
        Budget("core", "lut", lut),
        Budget("core", "dsp", 180),
        Budget("core", "ramb36", 112),
        Budget("core", "latches", 0),
    )
    for rotation, lut in (("cordic", 41_000), ("table", 30_000))
}


# ROTATION = table must save resources: its budget is 10,000 LUT below the budget with the CORDIC.
SAVED_BY_A_TABLE = 10_000


def budgets_of(generics: Mapping[str, int | str]) -> tuple[Budget, ...]:
    """Return the budgets for a ROTATION."""
    if generics.get("ROTATION") != "table":
        return BUDGETS
    return tuple(
        replace(budget, limit=budget.limit - SAVED_BY_A_TABLE)
        if (budget.part, budget.kind) == ("core", "lut")
        else budget
        for budget in BUDGETS
    )


def lane_of(units: Design) -> Resources | None:
    """Return the resources of a lane: its phase lane and the larger kind of harmonic lane; None
    without lanes."""
    parts = []
    for part in LANE_PARTS:
        kinds = [
            units.total(name)
            for name in units.cells
            if (name == part or name.startswith(f"{part}_")) and units.cells[name]
        ]
        if not kinds:
            return None
        parts.append(max(kinds, key=lambda kind: kind.lut))
    return parts[0] + parts[1]


def exceeded(core: Resources, lane: Resources | None, budgets: tuple[Budget, ...]) -> list[str]:
    """Return a sentence for every exceeded budget."""
    parts = {"core": core, "lane": lane}
    faults = []
    for budget in budgets:
        part = parts[budget.part]
        if part is None:
            continue
        used = asdict(part)[budget.kind]
        if used > budget.limit:
            faults.append(
                f"the {budget.part} takes {used:g} {budget.kind.upper()}, "
                f"{used - budget.limit:g} above its budget of {budget.limit:g}"
            )
    return faults


def _row(name: str, count: int | str, part: Resources) -> str:
    values = (part.lut, part.ff, part.dsp, f"{part.ramb36:g}", part.carry4)
    return f"| {name} | {count} | " + " | ".join(str(value) for value in values) + " |"


def table(title: str, core: Resources, lane: Resources | None, units: Design, top: str) -> str:
    """Return the table of resources in Markdown."""
    lines = [
        title,
        "",
        "| part | instances | LUT | FF | DSP48E1 | RAMB36 | CARRY4 |",
        "|---|---:|---:|---:|---:|---:|---:|",
        _row("**whole, flattened**", 1, core),
    ]
    if lane:
        lines.append(_row("**one lane** (phase_lane + larger harmonic_lane)", "", lane))
    for name, depth, count, part in units.units(top):
        indent = "&nbsp;&nbsp;" * depth
        # Leave out the hash that GHDL adds to the name.
        short = "_".join(word for word in name.split("_") if len(word) < 32)
        lines.append(_row(f"{indent}{short}", count, part))
    lines += [
        "",
        "The rows below the first are of one instance each, mapped unit by unit. Their sum is not",
        "the flattened figure: Yosys optimises across units there. A RAMB18 is half a RAMB36.",
    ]
    return "\n".join(lines) + "\n"


def report(
    entity: str, generics: dict[str, int | str], folder: Path
) -> tuple[Resources, list[str]]:
    """Synthesise, write and print the table; return total resources and exceeded budgets.

    The budgets of the core apply to arctrue_core with 32 lanes and are checked only for it, except
    that latches are never permitted. The budget of a lane is always checked. Raises ToolError.
    """
    versions = f"{find_ghdl()[1]}, {find_yosys()[1]}"
    netlist = write_netlist(entity, folder, generics=generics)
    units = Design.read(synthesise(netlist, flatten=False))
    flat = Design.read(synthesise(netlist, flatten=True))
    core, lane = flat.total(entity), lane_of(units)
    values = ", ".join(f"{name} = {value}" for name, value in generics.items())
    title = f"{entity}{f' ({values})' if values else ''}, {versions}, synth_xilinx -family xc7"
    text = table(title, core, lane, units, entity)
    whole = entity == TOP and generics.get("LANES", LANES) == LANES
    budgets = budgets_of(generics)
    if not whole:
        budgets = tuple(b for b in budgets if b.part == "lane" or not b.limit)
    faults = exceeded(core, lane, budgets)
    result = {
        "entity": entity,
        "generics": generics,
        "versions": versions,
        "whole": asdict(core),
        "lane": asdict(lane) if lane else None,
        "units": [
            {"unit": name, "depth": depth, "instances": count, "each": asdict(part)}
            for name, depth, count, part in units.units(entity)
        ],
        "budgets": [asdict(budget) for budget in budgets],
        "exceeded": faults,
    }
    (folder / "resources.json").write_text(json.dumps(result, indent=2) + "\n", encoding="utf-8")
    (folder / "resources.md").write_text(text, encoding="utf-8")
    print(text)
    return core, faults


def fold_table(cores: dict[int, Resources], generics: Mapping[str, int | str]) -> str:
    """Return a table in Markdown with a row for each FOLD."""
    built = "".join(f", {name} = {value}" for name, value in generics.items())
    lines = [
        f"{TOP} with {LANES} lanes{built}, folded: flattened, the whole core.",
        "",
        "| FOLD | an angle every | LUT | FF | DSP48E1 | RAMB36 | CARRY4 |",
        "|---:|---|---:|---:|---:|---:|---:|",
    ]
    for fold, core in sorted(cores.items()):
        clocks = "clock" if fold == 1 else f"{fold} clocks"
        values = (core.lut, core.ff, core.dsp, f"{core.ramb36:g}", core.carry4)
        lines.append(f"| {fold} | {clocks} | " + " | ".join(str(value) for value in values) + " |")
    return "\n".join(lines) + "\n"


def wasted_folds(cores: dict[int, Resources]) -> list[str]:
    """Return a sentence for every fold that needs at least as many LUTs or DSPs as the next smaller
    fold."""
    faults = []
    for less, more in pairwise(sorted(cores)):
        for kind in ("lut", "dsp"):
            before, after = asdict(cores[less])[kind], asdict(cores[more])[kind]
            if after >= before:
                faults.append(
                    f"FOLD = {more} takes {after} {kind.upper()}, FOLD = {less} only {before}"
                )
    return faults


def report_folds(
    folds: list[int],
    unfolded: Resources | None,
    folder: Path,
    generics: Mapping[str, int | str] | None = None,
) -> tuple[dict[int, Resources], list[str]]:
    """Map the core for each of ``folds``; write and print a table that also has ``unfolded``.

    ``generics``: all generics except FOLD, equal for all folds. Returns the resources by fold, and
    sentences about exceeded budgets and about folds that save nothing. Raises ToolError.
    """
    cores = {1: unfolded} if unfolded else {}
    faults = []
    for fold in folds:
        values = {**(generics or {}), "FOLD": fold}
        netlist = write_netlist(TOP, folder / f"fold{fold}", generics=values)
        cores[fold] = Design.read(synthesise(netlist, flatten=True)).total(TOP)
        faults += [
            f"FOLD = {fold}: {fault}" for fault in exceeded(cores[fold], None, budgets_of(values))
        ]
    faults += wasted_folds(cores)
    text = fold_table(cores, generics or {})
    result = {fold: asdict(core) for fold, core in sorted(cores.items())}
    (folder / "folds.json").write_text(json.dumps(result, indent=2) + "\n", encoding="utf-8")
    (folder / "folds.md").write_text(text, encoding="utf-8")
    print(text)
    return cores, faults


def report_everything(folder: Path) -> list[str]:
    """Map the core with all units for both kinds of rotation; write and print a table.

    Returns a sentence for every exceeded budget. Raises ToolError.
    """
    cores = {}
    faults = []
    for rotation, budgets in BUDGETS_OF_EVERYTHING.items():
        generics = {**EVERYTHING, "ROTATION": rotation}
        netlist = write_netlist(TOP, folder / f"everything_{rotation}", generics=generics)
        cores[rotation] = Design.read(synthesise(netlist, flatten=True)).total(TOP)
        faults += [f"{rotation}: {fault}" for fault in exceeded(cores[rotation], None, budgets)]
    built = ", ".join(f"{name} = {value}" for name, value in EVERYTHING.items())
    lines = [
        f"{TOP} with {LANES} lanes, FOLD = 1, {built}: flattened, the whole core.",
        "",
        "| ROTATION | instances | LUT | FF | DSP48E1 | RAMB36 | CARRY4 |",
        "|---|---:|---:|---:|---:|---:|---:|",
        *(_row(rotation, 1, core) for rotation, core in cores.items()),
    ]
    text = "\n".join(lines) + "\n"
    result = {rotation: asdict(core) for rotation, core in cores.items()}
    (folder / "everything.json").write_text(json.dumps(result, indent=2) + "\n", encoding="utf-8")
    (folder / "everything.md").write_text(text, encoding="utf-8")
    print(text)
    return faults


def main(arguments: list[str] | None = None) -> int:
    """Synthesise the entity that the command line names and check the budgets; return the exit
    code."""
    parser = argparse.ArgumentParser(description=__doc__)
    add_entity_options(parser, TOP)
    parser.add_argument(
        "--folds",
        nargs="*",
        type=int,
        default=[],
        choices=(2, 4, 8),
        help="map the core with these folds too",
    )
    parser.add_argument(
        "--everything",
        action="store_true",
        help="map the core with four heads and all units instead, with both kinds of rotation",
    )
    parser.add_argument("--output", type=Path, help="folder, made anew (build/synth/<entity>)")
    chosen = parser.parse_args(arguments)
    generics = generics_of(parser, chosen)
    if chosen.everything and (generics or chosen.folds):
        parser.error("--everything states the generics itself; omit --generic and --folds")
    folder = chosen.output or ROOT / "build" / "synth" / chosen.entity
    try:
        if chosen.everything:
            faults = report_everything(folder.resolve().parent)
        else:
            core, faults = report(chosen.entity, generics, folder.resolve())
        if chosen.folds:
            faults += report_folds(chosen.folds, core, folder.resolve().parent, generics)[1]
    except ToolError as error:
        print(f"synth: {error}", file=sys.stderr)
        return 2
    for fault in faults:
        print(f"synth: budget exceeded: {fault}", file=sys.stderr)
    if not faults:
        print("synth: all budgets kept")
    return 1 if faults else 0


if __name__ == "__main__":
    raise SystemExit(main())
