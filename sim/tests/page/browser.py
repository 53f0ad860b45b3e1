"""Finds and starts the system's Chromium, which takes screenshots of the page and tests it."""

from __future__ import annotations

import os
import shutil
from pathlib import Path

NAMES = ("chromium", "chromium-browser", "google-chrome")
INSTALL = (
    "apt-get install chromium (Debian), or name another Chromium or Chrome: ARCTRUE_CHROMIUM=PATH"
)


def chromium() -> Path | None:
    """Return the path of Chromium, or None. Ubuntu's chromium-browser does not count, because it is
    only a script that installs a snap."""
    named = os.environ.get("ARCTRUE_CHROMIUM")
    for name in [named] if named else NAMES:
        found = shutil.which(name)
        if found is not None and not _is_snap(Path(found)):
            return Path(found)
    return None


def _is_snap(program: Path) -> bool:
    head = program.resolve().read_bytes()[:4096]
    return head.startswith(b"#!") and b"snap" in head


def arguments() -> list[str]:
    """Return Chromium's options: no sandbox for root, and no shared memory, which is small in a
    container."""
    root = hasattr(os, "geteuid") and os.geteuid() == 0
    return ["--disable-dev-shm-usage", *(["--no-sandbox"] if root else [])]
