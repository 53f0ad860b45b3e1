"""Composes the command line that does the same as a button of the page."""

from __future__ import annotations

import shlex
from collections.abc import Sequence
from pathlib import Path

from arctrue.page.session import Opened

MODEL = "model.toml"
"""File name of a model that a user downloads from the page."""
COEFFICIENTS = "coefficients.toml"


class Commands:
    """Composes command lines, including the folders of the user's own effects with which ``arctrue
    serve`` was started."""

    def __init__(self, effect_folders: Sequence[Path]) -> None:
        """Store the folders of effects; each folder becomes an option ``--effects FOLDER``."""
        self._folders = [word for folder in effect_folders for word in ("--effects", str(folder))]

    def _line(self, *words: str) -> str:
        return shlex.join(["arctrue", *words])

    def of_step(self, action: str, effect: str, opened: Opened) -> str:
        """Return the command line of a step: ``add`` or ``drop``, otherwise ``compare`` with its
        model.
        """
        if action in ("add", "drop"):
            return self.change(action, effect, opened)
        return self.on_model("compare", opened)

    def change(self, action: str, effect: str, opened: Opened) -> str:
        """Return the command line of ``arctrue add`` or ``arctrue drop``."""
        return self._line(action, effect, opened.named, "--model", MODEL, *self._folders)

    def on_model(self, command: str, opened: Opened) -> str:
        """Return the line of a command that needs only a set and a model, for example compare."""
        return self._line(command, opened.named, "--model", MODEL, *self._folders)

    def export(self, opened: Opened, temperature_c: float | None) -> str:
        """Return the command line of ``arctrue export``; it states a temperature if the set has
        one."""
        at = [] if temperature_c is None else ["--temperature", f"{temperature_c:g}"]
        words = ["export", opened.named, "--model", MODEL, *at, "--coefficients", COEFFICIENTS]
        return self._line(*words, *self._folders)

    def history(self) -> str:
        """Return the command line of ``arctrue history``."""
        return self._line("history", "--model", MODEL)

    def serve(self, folder: Path, state: Path, port: str) -> str:
        """Return the command line of ``arctrue serve`` with the same sets and sessions."""
        device = ["--port", port] if port else []
        words = ["serve", str(folder), "--state", str(state), *device]
        return self._line(*words, *self._folders)

    def load(self, port: str) -> str:
        """Return the command line of ``arctrue load``."""
        return self._line("load", port, COEFFICIENTS)

    def simulate(self, out: str, experiment: str, seed: int, *, hidden: bool) -> str:
        """Return the command line of ``arctrue simulate``."""
        drawn = ["--hidden"] if hidden else []
        return self._line("simulate", out, *drawn, "--experiment", experiment, "--seed", str(seed))

    def imported(self, files: Sequence[str], answers: Sequence[tuple[str, str]], out: str) -> str:
        """Return the command line of ``arctrue import``."""
        said = [word for option, answer in answers for word in (option, answer)]
        return self._line("import", *said, *files, out)
