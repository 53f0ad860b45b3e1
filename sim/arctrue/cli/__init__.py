"""The command line: ``arctrue COMMAND``.

One file a command: ``arctrue/cli/<command>.py`` holds a click command called ``<command>`` (or
``command``), and is found by its name. A ``_`` in the file's name is a ``-`` on the command line,
one at its end (``import_``) is left out; a file whose name begins with ``_`` or without such a
command is no command.
"""

from __future__ import annotations

import importlib
import os
import pkgutil

import click

from arctrue import cli
from arctrue.cli._group import Program

# Before numpy is imported: its matrix products here are narrow, and threads that wait for each
# other on a busy machine took ten times as long as one.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")


GENERATED = "arctrue.generated"


class _NotGeneratedError(click.ClickException):
    """The modules that are made from registers and number formats are not there yet."""

    exit_code = 2

    def __init__(self) -> None:
        super().__init__(
            "sim/arctrue/generated is not there yet: run make generate in the source tree first"
        )


class _AllCommands(Program):
    """Imports a command's module only when it is asked for."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        return sorted(self._modules())

    @staticmethod
    def _modules() -> dict[str, str]:
        """The module of each command."""
        names = (module.name for module in pkgutil.iter_modules(cli.__path__))
        return {
            name.rstrip("_").replace("_", "-"): name for name in names if not name.startswith("_")
        }

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        name = self._modules().get(cmd_name)
        if name is None:
            return None
        try:
            module = importlib.import_module(f"arctrue.cli.{name}")
        except ModuleNotFoundError as error:
            if not (error.name or "").startswith(GENERATED):
                raise
            raise _NotGeneratedError from error
        command = getattr(module, name, getattr(module, "command", None))
        return command if isinstance(command, click.Command) else None


@click.command(cls=_AllCommands)
@click.version_option(package_name="arctrue")
def main() -> None:
    """Find the angle error of a rotary table from two read heads, and correct it."""
