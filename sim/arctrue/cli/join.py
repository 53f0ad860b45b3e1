"""arctrue join: several sets of one table become one."""

from __future__ import annotations

import shlex
from dataclasses import replace
from importlib.metadata import version
from pathlib import Path

import click

from arctrue.cli._outputs import OutputFolder
from arctrue.cli._runs import print_runs
from arctrue.cli._terminal import say
from arctrue.cli._workbench import console, for_people
from arctrue.measurement import Origin, joined, read_measurement_set, write_measurement_set
from arctrue.measurement.description import FILE_NAME
from arctrue.printable import one_line


@click.command("join", short_help="Make one set of several of the same table.")
@click.argument(
    "sets",
    metavar="SET...",
    nargs=-1,
    required=True,
    type=click.Path(path_type=Path, file_okay=False),
)
@click.argument("out", metavar="OUT", type=OutputFolder())
@click.option(
    "--times",
    type=click.Choice(["after", "keep"]),
    help="Of a set whose clock began anew: after the set before it, or as they are.",
)
@click.option("--common-columns", is_flag=True, help="Leave out what not all sets have.")
@for_people
def join(sets: tuple[Path, ...], out: Path, times: str | None, common_columns: bool) -> None:
    """Write the runs of all SETs to OUT, one after another.

    Runs and cycles are numbered on. Sets of different tables are refused.
    """
    if (out / FILE_NAME).exists():
        raise ValueError(f"{out}: holds a measurement set already; name a new folder")
    read = [read_measurement_set(folder) for folder in sets]
    for item in read:
        for warning in item.warnings:
            say(f"warning: {warning}", err=True)
    result, notes = joined(
        read,
        times="" if times is None else "after" if times == "after" else "keep",
        common_columns=common_columns,
    )
    words = ["arctrue", "join"]
    words += ["--times", times] if times else []
    words += ["--common-columns"] if common_columns else []
    command = shlex.join([*words, *map(str, sets), str(out)])
    origin = Origin(one_line(command), f"arctrue {version('arctrue')}")
    write_measurement_set(out, replace(result, origin=origin))
    for note in notes:
        console.print(f"• {note}", soft_wrap=True)
    print_runs(result)
    console.print(f"wrote {out}", soft_wrap=True)
