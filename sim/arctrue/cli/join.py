"""arctrue join: makes one set from several sets of one table."""

from __future__ import annotations

import shlex
from dataclasses import replace
from importlib.metadata import version
from pathlib import Path

import click

from arctrue.base.printable import one_line
from arctrue.cli._guide import next_option, refuse_what_was_not_asked
from arctrue.cli._loaded_set import console, for_people
from arctrue.cli._outputs import OutputFolder
from arctrue.cli._runs import print_runs
from arctrue.cli._terminal import tell_warning
from arctrue.measurement import Origin, joined, read_measurement_set, write_measurement_set
from arctrue.measurement.writer import refuse_occupied


@click.command("join", short_help="Make one set from several of the same table.")
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
    help="For a later set whose clock restarted: shift its times past the end of the previous set "
    "(after), or keep them.",
)
@click.option("--common-columns", is_flag=True, help="Leave out columns that some sets lack.")
@next_option
@for_people
def join(
    sets: tuple[Path, ...],
    out: Path,
    times: str | None,
    common_columns: bool,
    kind: str | None,
    force: bool,
) -> None:
    """Write the runs of all SETs to OUT, one after another.

    The run and cycle numbers of later sets are increased if necessary, so that no number occurs
    twice. Sets of different tables are refused. With --next the last SET must be the measurement
    that a diagnosis of the first SET requested (otherwise exit code 1).
    """
    refuse_occupied(out)
    read = [read_measurement_set(folder) for folder in sets]
    for item in read:
        for warning in item.warnings:
            tell_warning(warning)
    if kind is not None:
        if len(read) < 2:
            raise ValueError(f"--next {kind} needs two sets: the first, and the requested one")
        refuse_what_was_not_asked(kind, read[0], read[-1], force=force)
    result, notes = joined(
        read,
        times="" if times is None else "after" if times == "after" else "keep",
        common_columns=common_columns,
    )
    words = ["arctrue", "join"]
    words += ["--times", times] if times else []
    words += ["--common-columns"] if common_columns else []
    words += ["--next", kind] if kind else []
    words += ["--force"] if force else []
    command = shlex.join([*words, *map(str, sets), str(out)])
    origin = Origin(one_line(command), f"arctrue {version('arctrue')}")
    write_measurement_set(out, replace(result, origin=origin))
    for note in notes:
        console.print(f"• {note}", soft_wrap=True)
    print_runs(result)
    console.print(f"wrote {out}", soft_wrap=True)
