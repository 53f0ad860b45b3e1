"""Defines the command line ``arctrue COMMAND``.

Each command has one file: ``arctrue/cli/<command>.py`` holds a click command called ``<command>``
or ``command``. A ``_`` in the file's name becomes a ``-`` on the command line; a ``_`` at its end
(``import_``) is dropped. Files whose name begins with ``_`` contain code that several commands
share.

A command imports inside its function what only its run needs, so that help and completion start
quickly.
"""

from __future__ import annotations

import importlib
import os
import pkgutil

import click

from arctrue import cli
from arctrue.base.extras import MissingExtraError, missing_extra
from arctrue.cli._group import Program

# numpy reads this variable when it is imported. One thread is enough for the narrow matrices here;
# several threads took ten times as long on a busy machine.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")


GENERATED = "arctrue.generated"
SECTIONS = {
    "Your own data": (
        *("import", "join", "serve", "calibrate", "compare", "diagnose", "explain"),
        *("effects", "add", "drop", "history", "life", "report", "budget", "certificate"),
        *("iso230", "export"),
    ),
    "Device": ("device", "commission", "capture", "monitor", "probe", "load", "save", "flash"),
    "Simulate and study": (
        *("demo", "simulate", "run", "revolution", "hidden", "long-run", "stop-and-go", "paper"),
        *("methods", "heads", "error-sources", "monte-carlo", "alpha", "benchmark"),
    ),
}
"""The commands in the order in which the help lists them."""


class _NotGeneratedError(click.ClickException):
    """Is raised if the package ``arctrue.generated``, which the build generates, is missing."""

    exit_code = 2

    def __init__(self) -> None:
        super().__init__(
            "sim/arctrue/generated does not exist yet: first run make generate in the source tree"
        )


def _without_extra(name: str, missing: MissingExtraError) -> click.Command:
    """Return a command that only names the missing extra; it replaces the command that needs the
    extra."""

    def refuse(_: click.Context, __: click.Parameter, ___: object) -> None:
        raise missing

    return click.Command(
        name,
        help=f"Not installed: {missing}",
        short_help=f"Not installed; pip install {str(missing).rpartition(' ')[2]}",
        params=[click.Argument(["words"], nargs=-1, type=click.UNPROCESSED, callback=refuse)],
        context_settings={"ignore_unknown_options": True},
    )


class _AllCommands(Program):
    """The group of all commands; it imports the module of a command only when the command is
    needed."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        listed = [name for names in SECTIONS.values() for name in names]
        # The help also lists commands that SECTIONS does not name.
        return [*listed, *sorted(self._modules().keys() - set(listed))]

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write the commands of the help in sections."""
        names = self.list_commands(ctx)
        width = formatter.width - 6 - max(map(len, names))
        for title, listed in SECTIONS.items():
            commands = [(name, self.get_command(ctx, name)) for name in listed]
            with formatter.section(title):
                formatter.write_dl(
                    [
                        (name.ljust(max(map(len, names))), command.get_short_help_str(width))
                        for name, command in commands
                        if command is not None
                    ]
                )

    @staticmethod
    def _modules() -> dict[str, str]:
        """Return the name of each command's module, by the name of the command."""
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
            if (error.name or "").startswith(GENERATED):
                raise _NotGeneratedError from error
            if (missing := missing_extra(error)) is None:
                raise
            return _without_extra(cmd_name, missing)
        command = getattr(module, name, getattr(module, "command", None))
        return command if isinstance(command, click.Command) else None


@click.command(cls=_AllCommands)
@click.version_option(package_name="arctrue")
def main() -> None:
    """Find the angle error of a rotary table from two read heads, and correct it."""
