"""Checks the source tree for the demo, and makes the environment in which child processes find the
tree."""

from __future__ import annotations

import os

from arctrue.base.source_tree import ROOT, lack_of_source_tree


class DemoError(RuntimeError):
    """Raised if the demo cannot run or its simulation failed; the text states the remedy."""


def check_source_tree() -> None:
    """Raise DemoError if the VHDL, the firmware or their generated parts are missing."""
    if lack := lack_of_source_tree():
        raise DemoError(lack)
    generated = ROOT / "build" / "generated"
    if not any((generated / "vhdl").glob("*.vhd")) or not any((generated / "c").glob("*.h")):
        raise DemoError(
            "build/generated/ holds no register block or no C header: run "
            "'make generate', or 'make demo', which does it"
        )


def child_environment() -> dict[str, str]:
    """Return environment variables with which a child process can import ``arctrue`` and ``tb``."""
    return {**os.environ, "PYTHONPATH": os.pathsep.join([str(ROOT), str(ROOT / "sim")])}
