"""Stores the measurement set that was opened in the page, and every step of its model, in a
folder."""

from __future__ import annotations

import json
import re
import secrets
import shutil
from dataclasses import asdict, dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from arctrue.base.typed_content import read_json
from arctrue.base.whole_file import write_whole_text
from arctrue.report.ranking import Ranking
from arctrue.workbench.model.model import Model
from arctrue.workbench.model.model_file import read_model, write_model

_NAME = re.compile(r"[a-z0-9]{16}")
_BYTES = 8
_SESSION, _STEP, _MODEL, _RANKING = "session.json", "step.json", "model.toml", "ranking.json"
_KEY = "ranking.key"
SET = "set"
"""Name of the folder of a set that the user dropped into the page or generated."""


class NoSuchSessionError(LookupError):
    """Is raised if the session or step that an address names does not exist or no longer exists."""


@dataclass(frozen=True)
class Opened:
    """The measurement set that a session analyses."""

    title: str
    folder: str
    """Folder of the measurement set."""
    named: str
    """Name of the set on a command line."""
    command: str
    """Command that makes this set again; empty for a recorded set."""
    generated: bool
    date: str


@dataclass(frozen=True)
class Step:
    """One state of the model; ``parent`` is the number of the step from which it was made."""

    number: int
    parent: int | None
    action: str
    """Action that made the step: open, add, drop or load."""
    effect: str
    command: str
    """Command line that does the same as the action."""
    seconds: float
    """Time in seconds that the fit took."""


class Session:
    """One session: a folder with the set (unless the set is in the user's own folder) and a folder
    ``1``, ``2``, … for each step."""

    def __init__(self, folder: Path) -> None:
        """Open the existing session in ``folder``."""
        self.folder = folder
        self.name = folder.name

    @property
    def opened(self) -> Opened:
        """Read the description of the session's set."""
        return read_json(self.folder / _SESSION, Opened)

    def steps(self) -> list[Step]:
        """Return all steps of the session in the order of creation."""
        found = [
            read_json(path, Step)
            for path in self.folder.glob(f"*/{_STEP}")
            if path.parent.name.isdigit()
        ]
        return sorted(found, key=lambda step: step.number)

    def step(self, number: int) -> Step:
        """Return the step with this number. Raises NoSuchSessionError."""
        path = self.folder / str(number) / _STEP
        if not path.is_file():
            raise NoSuchSessionError(f"step {number} does not exist")
        return read_json(path, Step)

    def step_folder(self, number: int) -> Path:
        """Return the folder of a step's files."""
        return self.folder / str(number)

    def model_file(self, number: int) -> Path:
        """Return the path of a step's model file."""
        return self.folder / str(number) / _MODEL

    def model(self, number: int) -> Model:
        """Read the model of a step. Raises ModelFileError."""
        return read_model(self.model_file(number))

    def ranking(self, number: int) -> Ranking | None:
        """Read the ranking of a step; return None if it does not exist yet."""
        path = self.folder / str(number) / _RANKING
        return read_json(path, dict[str, Any]) if path.is_file() else None

    def ranking_is_whole(self, number: int) -> bool:
        """Tell whether the ranking of a step is complete."""
        found = self.ranking(number)
        return found is not None and bool(found["whole"])

    def ranking_key(self, number: int) -> str:
        """Read the key of a step's ranking; it is empty for a step that an earlier version made."""
        path = self.folder / str(number) / _KEY
        return path.read_text(encoding="utf-8") if path.is_file() else ""

    def write_ranking_key(self, number: int, key: str) -> None:
        """Store the key of a step's ranking. Raises OSError."""
        write_whole_text(self.folder / str(number) / _KEY, key, make_folder=False)

    def write_ranking(self, number: int, found: Ranking, key: str | None = None) -> None:
        """Store the ranking of a step, and the key of its inputs if ``key`` is given. Raises
        OSError."""
        text = json.dumps(found, ensure_ascii=False)
        write_whole_text(self.folder / str(number) / _RANKING, text, make_folder=False)
        if key is not None:
            self.write_ranking_key(number, key)

    def drop_ranking(self, number: int) -> None:
        """Delete the ranking of a step, whose inputs have changed. Raises OSError."""
        (self.folder / str(number) / _RANKING).unlink(missing_ok=True)

    def grow(
        self,
        model: Model,
        *,
        parent: int | None,
        action: str,
        effect: str,
        command: str,
        seconds: float,
    ) -> Step:
        """Add a step and store its model; existing steps remain unchanged. Raises OSError."""
        number = len(self.steps()) + 1
        while True:
            try:
                (self.folder / str(number)).mkdir()
                break
            except FileExistsError:  # a concurrent request has used the number
                number += 1
        write_model(self.model_file(number), model)
        step = Step(number, parent, action, effect, command, seconds)
        write_whole_text(self.folder / str(number) / _STEP, json.dumps(asdict(step)))
        return step


class Sessions:
    """Manages all sessions of a state folder."""

    def __init__(self, folder: Path) -> None:
        """Make the state folder if it is missing, readable only by its owner. Raises OSError."""
        self.folder = folder
        folder.mkdir(parents=True, exist_ok=True, mode=0o700)

    def make(self) -> Path:
        """Make the empty folder of a new session; :meth:`open` then makes it a session."""
        folder = self.folder / secrets.token_hex(_BYTES)
        folder.mkdir(mode=0o700)
        return folder

    def open(self, folder: Path, opened: Opened) -> Session:
        """Make ``folder`` a session; :meth:`all` then lists it. Raises OSError."""
        write_whole_text(folder / _SESSION, json.dumps(asdict(opened), ensure_ascii=False))
        return Session(folder)

    def __getitem__(self, name: str) -> Session:
        """Return the session with this name. Raises NoSuchSessionError."""
        folder = self.folder / name
        if not _NAME.fullmatch(name) or not (folder / _SESSION).is_file():
            raise NoSuchSessionError(f"there is no session {name[:32]!r}")
        return Session(folder)

    def all(self) -> list[Session]:
        """Return all sessions, newest first."""
        found = [
            Session(path.parent)
            for path in self.folder.glob(f"*/{_SESSION}")
            if _NAME.fullmatch(path.parent.name)
        ]
        return sorted(found, key=lambda item: item.opened.date, reverse=True)

    def ranked(self, key: str) -> Ranking | None:
        """Return a complete ranking with this key from any step of any session; None if there is
        none."""
        for session in self.all():
            for step in session.steps():
                if key == session.ranking_key(step.number):
                    found = session.ranking(step.number)
                    if found is not None and found["whole"]:
                        return found
        return None

    def forget(self, name: str) -> None:
        """Delete the session with this name and all its files. Raises NoSuchSessionError."""
        shutil.rmtree(self[name].folder, onerror=_make_writable)


def now() -> str:
    """Return the present time in UTC, ISO 8601."""
    return datetime.now(UTC).isoformat(timespec="seconds")


def _make_writable(function: Any, path: str, _: Any) -> None:
    """Make a file writable and repeat its deletion, which failed because the file is read-only."""
    Path(path).chmod(0o600)
    function(path)
