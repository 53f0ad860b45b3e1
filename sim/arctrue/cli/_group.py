"""Defines groups of commands with one format of errors, the option ``-h``, and a suggestion for a
mistyped name."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from typing import Any

import click

from arctrue.base.extras import MissingExtraError, missing_extra
from arctrue.base.similar import did_you_mean
from arctrue.cli._terminal import note, tell_error

EXIT_INTERRUPTED = 130
"""Exit code that a shell reports for an interrupted program: 128 + SIGINT."""
EXIT_BAD_INPUT = 2


class Commands(click.Group):
    """A group that answers a mistyped command name with similar names."""

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        """Return the command that the first word names. Raises UsageError if there is none."""
        name = args[0]
        if not name.startswith("-") and self.get_command(ctx, name) is None:
            meant = did_you_mean(name, self.list_commands(ctx))
            raise click.UsageError(f"No such command '{name}'.{meant}", ctx)
        return super().resolve_command(ctx, args)


class Program(Commands):
    """The outermost group; it prints all errors in the same format."""

    def __init__(self, *arguments: Any, **settings: Any) -> None:
        """Create the group; all its commands accept ``-h`` and ``--help``."""
        settings.setdefault("context_settings", {})["help_option_names"] = ["-h", "--help"]
        super().__init__(*arguments, **settings)

    def main(
        self,
        args: Sequence[str] | None = None,
        prog_name: str | None = None,
        complete_var: str | None = None,
        standalone_mode: bool = True,
        **options: Any,
    ) -> Any:
        """Run the command, and end the program with the command's exit code; return the result
        instead if ``standalone_mode`` is False."""
        options |= {"prog_name": prog_name, "complete_var": complete_var}
        if not standalone_mode:
            return super().main(args, standalone_mode=False, **options)
        try:
            # The result is an exit code if the command ended the program itself, otherwise None.
            code = super().main(args, standalone_mode=False, **options)
        except click.Abort:
            tell_error("interrupted")
            code = EXIT_INTERRUPTED
        except click.ClickException as failure:
            _tell(failure)
            code = failure.exit_code
        except ModuleNotFoundError as error:
            if (missing := missing_extra(error)) is None:
                raise
            tell_error(str(missing))
            code = EXIT_BAD_INPUT
        except MissingExtraError as error:
            tell_error(str(error))
            code = EXIT_BAD_INPUT
        sys.exit(code if isinstance(code, int) else 0)


def _tell(failure: click.ClickException) -> None:
    """Print the error; if an option or argument is wrong, also print the usage of the command."""
    tell_error(failure.format_message())
    context = failure.ctx if isinstance(failure, click.UsageError) else None
    if context is not None:
        note(context.get_usage().replace("Usage: ", "usage: ", 1))
        note(f"help: {context.command_path} -h")
