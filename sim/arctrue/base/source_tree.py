"""The source tree: VHDL and firmware are in it, and in no installed package."""

from __future__ import annotations

from pathlib import Path

ROOT = Path(__file__).resolve().parents[3]


def lack_of_source_tree() -> str:
    """What to do when this program was installed without its source tree; otherwise empty."""
    if all((ROOT / name).exists() for name in ("rtl", "firmware", "tb/demo")):
        return ""
    return (
        "this needs the VHDL and the firmware, which an installed package does not hold: "
        "start it from a source tree of ArcTrue, where 'make setup' makes .venv/bin/arctrue"
    )
