"""The source tree: the demo runs the VHDL, which no installed package holds."""

from __future__ import annotations

import os
from pathlib import Path

ROOT = Path(__file__).resolve().parents[3]


class DemoError(RuntimeError):
    """The demo cannot run, or its simulation failed; the text says what to do."""


def check_source_tree() -> None:
    """Raise DemoError unless the VHDL and its generated part are there."""
    if not (ROOT / "rtl").is_dir() or not (ROOT / "tb" / "demo").is_dir():
        raise DemoError(
            f"{ROOT} holds no rtl/ and tb/demo/: run the demo from a source tree, with 'make demo'"
        )
    if not any((ROOT / "build" / "generated" / "vhdl").glob("*.vhd")):
        raise DemoError(
            "build/generated/vhdl/ holds no register block: run 'python scripts/generate.py', "
            "or 'make demo', which does it"
        )


def child_environment() -> dict[str, str]:
    """The environment in which a child process finds both ``arctrue`` and ``tb``."""
    return {**os.environ, "PYTHONPATH": os.pathsep.join([str(ROOT), str(ROOT / "sim")])}
