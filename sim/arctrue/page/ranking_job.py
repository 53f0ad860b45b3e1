"""Ranks one step of a session: ``python -m arctrue.page.ranking_job SESSION STEP [EFFECTS…]``."""

from __future__ import annotations

import json
import os
import sys
import time
from pathlib import Path

# The variable must be set before numpy is imported; arctrue.cli explains the reason.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

from arctrue.base.json_text import plain
from arctrue.base.whole_file import write_whole_text
from arctrue.page.analyses import analyse_opened
from arctrue.page.jobs import PROGRESS
from arctrue.page.session import Session
from arctrue.report.ranking import Ranking, ranked
from arctrue.workbench.effects.registry import catalogue

_BETWEEN_S = 0.2


class _DoingFile:
    """Writes the present activity to a file, at a limited rate; the page reads this file."""

    def __init__(self, path: Path) -> None:
        self._path, self._said = path, 0.0

    def __call__(self, doing: str) -> None:
        if time.monotonic() - self._said >= _BETWEEN_S:
            self._said = time.monotonic()
            write_whole_text(self._path, json.dumps({"doing": doing}), make_folder=False)


def main(session_folder: str, step: str, *effect_folders: str) -> None:
    """Write the ranking into the step's folder: first the partial ranking, then the complete
    one."""
    session, number = Session(Path(session_folder)), int(step)
    # The key is read before the set: if the set changes meanwhile, the page finds another key.
    key = session.ranking_key(number)
    progress = _DoingFile(session.step_folder(number) / PROGRESS)
    progress("reading the set")
    effects = catalogue([Path(folder) for folder in effect_folders])
    analysis = analyse_opened(session.opened, session.model(number), effects)

    def partly(found: Ranking) -> None:
        session.write_ranking(number, plain({**found, "whole": False}), key)

    found = ranked(analysis, progress, partly)
    session.write_ranking(number, plain({**found, "whole": True}), key)


if __name__ == "__main__":
    main(*sys.argv[1:])
