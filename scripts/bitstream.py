"""Makes the chip's configuration, build/bitstream/<board>/arctrue.bit (``make bitstream``).

Both flows, Vivado and the open tools, use the same VHDL and the same pin file (docs/device.md).
Exit code 1 when the timing is not met, 2 when a tool or a file is missing or fails.
"""

from __future__ import annotations

import argparse
import shutil
import sys
from dataclasses import replace
from pathlib import Path

from arctrue.generated import number_formats
from scripts.bitstream_constraints import ConstraintError, check_pins, ports_of
from scripts.bitstream_file import check_bitstream
from scripts.bitstream_job import (
    CONSTRAINTS,
    HEADS_TOPS,
    TOPS,
    TWO_HEADS_TOPS,
    Job,
    TimingError,
)
from scripts.bitstream_open import run_open
from scripts.bitstream_vivado import run_vivado
from scripts.netlist import ROOT, ToolError

FLOWS = {"vivado": run_vivado, "open": run_open}
FOLDS = (1, 2, 4, 8)
ROTATIONS = ("cordic", "table")
PART = "xc7z020clg400-1"
OPEN_PIPELINES = 16
"""Largest number of pipelines with which the open tools have reached 100 MHz (docs/timing.md)."""


def boards() -> list[str]:
    """Return the names that ``--board`` accepts: those of the pin files in constraints/."""
    files = (path for path in CONSTRAINTS.glob("*.xdc") if not path.stem.startswith("vivado"))
    return sorted(path.stem for path in files if not path.stem.endswith(".template"))


def fold_of(flow: str, lanes: int) -> int:
    """Return the number of lanes per pipeline that applies without --fold: the smallest number with
    which the flow's tools can route the lanes, or the largest possible number if there is none."""
    folds = [fold for fold in FOLDS if lanes % fold == 0]
    if flow == "vivado":
        return folds[0]
    return next((fold for fold in folds if lanes // fold <= OPEN_PIPELINES), folds[-1])


def pins_of_all_heads(pins: Path) -> Path:
    """Join a board's pin file with the pin file of its heads 3 and 4; write the result below
    build/.

    Raises ConstraintError if the board has no pins for these heads.
    """
    further = pins.parent / "heads" / pins.name
    if not further.exists():
        raise ConstraintError(
            f"{further}: there is no such file, so this board has no pins for heads 3 and 4. "
            "Write it, or name one file with the pins of all ports: PINS=file"
        )
    joined = ROOT / "build" / "bitstream" / "pins" / f"{pins.stem}_heads.xdc"
    joined.parent.mkdir(parents=True, exist_ok=True)
    texts = (path.read_text(encoding="utf-8") for path in (pins, further))
    joined.write_text("\n".join(texts), encoding="utf-8")
    return joined


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="bitstream", description=__doc__)
    parser.add_argument("--flow", choices=FLOWS, default="vivado", help="Vivado, or the open tools")
    parser.add_argument("--board", default="pynq_z2", help=f"{', '.join(boards())}, or your board")
    parser.add_argument("--pins", type=Path, help="pin file (constraints/<board>.xdc)")
    parser.add_argument("--part", default=PART, help=f"chip, package and speed grade ({PART})")
    parser.add_argument(
        "--top", choices=TWO_HEADS_TOPS, default="arctrue_zynq_top", help="top level"
    )
    parser.add_argument("--lanes", type=int, help="number of lanes (the generic's default: 32)")
    parser.add_argument("--fold", type=int, choices=FOLDS, help="lanes that share a pipeline")
    parser.add_argument("--rotation", choices=ROTATIONS, help="how a lane computes its cosine")
    parser.add_argument(
        "--modulators",
        choices=("true", "false"),
        help="amplitudes of lanes follow direction, speed or a word",
    )
    parser.add_argument(
        "--failover",
        choices=("true", "false"),
        help="the mean of three or four heads leaves out a failed head",
    )
    parser.add_argument(
        "--local-table",
        choices=("true", "false"),
        help="a table over the turn corrects errors that a sum of orders cannot correct",
    )
    parser.add_argument(
        "--real-orders",
        choices=("true", "false"),
        help="phases of lanes continue from turn to turn",
    )
    parser.add_argument(
        "--events",
        choices=("true", "false"),
        help="events of probe and compare wait in a queue",
    )
    parser.add_argument("--heads", type=int, choices=(2, 3, 4), default=2, help="read heads (2)")
    parser.add_argument(
        "--mean",
        choices=("true", "false"),
        help="correct the weighted mean of both heads; three and four heads always have their mean",
    )
    parser.add_argument("--seed", type=int, help="seed of nextpnr, which gives another placement")
    parser.add_argument("--capture-depth", type=int, help="samples a bank (default: 12288)")
    parser.add_argument("--output", type=Path, help="folder, made anew (build/bitstream/<board>)")
    return parser


def main(arguments: list[str] | None = None) -> int:
    """Make the bitstream that the command line describes; return the exit code."""
    parser = _parser()
    chosen = parser.parse_args(arguments)
    lanes = number_formats.LANES_DEFAULT if chosen.lanes is None else chosen.lanes
    if not 1 <= lanes <= number_formats.LANES_MAX:
        parser.error(f"--lanes: expected 1 to {number_formats.LANES_MAX}, found {lanes}")
    if chosen.fold and lanes % chosen.fold:
        parser.error(f"--fold: {chosen.fold} lanes a pipeline do not divide {lanes} lanes")
    if chosen.heads > 2 and chosen.top not in HEADS_TOPS:
        parser.error(f"--heads: {chosen.top} has two heads; take {' or '.join(HEADS_TOPS)}")
    if chosen.heads > 2 and chosen.mean == "false":
        parser.error("--mean: more than two heads always have their mean; leave MEAN out")
    if chosen.failover == "true" and chosen.heads == 2:
        parser.error("--failover: expected three or four heads, found two; set HEADS=3 or 4")
    pins = chosen.pins or CONSTRAINTS / f"{chosen.board}.xdc"
    folder = (chosen.output or ROOT / "build" / "bitstream" / chosen.board).resolve()
    generics = {
        "LANES": chosen.lanes,
        "CAPTURE_DEPTH": chosen.capture_depth,
        "FOLD": chosen.fold or fold_of(chosen.flow, lanes),
        "ROTATION": chosen.rotation,
        "MODULATORS": True if chosen.modulators == "true" else None,
        "FAILOVER": True if chosen.failover == "true" else None,
        "LOCAL_TABLE": True if chosen.local_table == "true" else None,
        "REAL_ORDERS": True if chosen.real_orders == "true" else None,
        "EVENTS": True if chosen.events == "true" else None,
        "HEADS": chosen.heads if chosen.heads > 2 else None,
        "MEAN": True if chosen.mean == "true" and chosen.heads == 2 else None,
    }
    top = TOPS[HEADS_TOPS[chosen.top] if chosen.heads > 2 else chosen.top]
    if not top.has_core:
        generics = {}
    job = Job(
        top=top,
        part=chosen.part,
        generics={name: value for name, value in generics.items() if value is not None},
        pins=pins.resolve(),
        folder=folder,
        seed=chosen.seed,
    )
    try:
        if not pins.exists():
            raise ConstraintError(
                f"{pins}: there is no pin file for the board {chosen.board}; there are "
                f"{', '.join(boards())}. For an own board copy constraints/own_board.template.xdc "
                "and name it: PINS=file"
            )
        if chosen.heads > 2 and not chosen.pins:
            job = replace(job, pins=pins_of_all_heads(pins))
            pins = job.pins
        check_pins(pins, ports_of(top.name))
        shutil.rmtree(folder, ignore_errors=True)
        folder.mkdir(parents=True)
        timing = FLOWS[chosen.flow](job)
        size = check_bitstream(job.bitstream, job.part)
    except TimingError as error:
        job.bitstream.unlink(missing_ok=True)
        print(f"bitstream: the timing is not met: {error}", file=sys.stderr)
        return 1
    except (ToolError, ConstraintError) as error:
        job.bitstream.unlink(missing_ok=True)
        print(f"bitstream: {error}", file=sys.stderr)
        return 2
    print(f"bitstream: {timing}")
    print(f"bitstream: {size}; logs and reports in {job.reports}")
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
