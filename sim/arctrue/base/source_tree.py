"""Checks whether the source tree with VHDL and firmware exists; an installed package lacks it."""

from __future__ import annotations

from pathlib import Path

ROOT = Path(__file__).resolve().parents[3]


def lack_of_source_tree() -> str:
    """Return the remedy if this program runs without its source tree, otherwise an empty text."""
    if all((ROOT / name).exists() for name in ("rtl", "firmware", "tb/demo")):
        return ""
    return (
        "this needs the VHDL and the firmware, which an installed package does not hold: "
        "start it from a source tree of ArcTrue, where 'make setup' makes .venv/bin/arctrue"
    )
