"""The source tree: the demo runs VHDL and firmware, which no installed package holds."""

from __future__ import annotations

import os
from pathlib import Path

ROOT = Path(__file__).resolve().parents[4]


class DemoError(RuntimeError):
    """The demo cannot run, or its simulation failed; the text says what to do."""


def check_source_tree() -> None:
    """Raise DemoError unless the VHDL, the firmware and their generated parts are there."""
    missing = [name for name in ("rtl", "firmware", "tb/demo") if not (ROOT / name).is_dir()]
    if missing:
        raise DemoError(
            f"{ROOT} holds no {' and no '.join(f'{name}/' for name in missing)}: "
            f"run the demo from a source tree, with 'make demo'"
        )
    generated = ROOT / "build" / "generated"
    if not any((generated / "vhdl").glob("*.vhd")) or not any((generated / "c").glob("*.h")):
        raise DemoError(
            "build/generated/ holds no register block or no C header: run "
            "'python scripts/generate.py', or 'make demo', which does it"
        )


def child_environment() -> dict[str, str]:
    """The environment in which a child process finds both ``arctrue`` and ``tb``."""
    return {**os.environ, "PYTHONPATH": os.pathsep.join([str(ROOT), str(ROOT / "sim")])}
