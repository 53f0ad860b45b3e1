"""arctrue import: makes a measurement set from files of other programs."""

from __future__ import annotations

import shlex
import sys
from collections.abc import Sequence
from dataclasses import replace
from importlib.metadata import version
from pathlib import Path

import click

from arctrue.base.printable import one_line
from arctrue.cli._import_questions import Asker, all_open
from arctrue.cli._loaded_set import console, for_people
from arctrue.cli._numbers import Finite
from arctrue.cli._outputs import OutputFolder
from arctrue.cli._places import Places
from arctrue.cli._runs import print_runs
from arctrue.cli._tables import table, words
from arctrue.cli._terminal import note
from arctrue.importing import (
    Ambiguous,
    AmbiguousError,
    Choices,
    Imported,
    ReadSettings,
    Settings,
)
from arctrue.importing.choices import refuse
from arctrue.importing.quantities import QUANTITIES, UNITS
from arctrue.importing.questions import Import
from arctrue.measurement import Origin, Table, write_measurement_set
from arctrue.measurement.date import moment
from arctrue.measurement.writer import refuse_occupied

_UNITS = "; ".join(
    f"{kind}: {', '.join(units)}" for kind, units in UNITS.items() if kind != "whole"
)


def _pairs(option: str, given: Sequence[str]) -> dict[str, str]:
    """Parse the NAME=VALUE pairs of an option. Raises ValueError for a text of another form."""
    found: dict[str, str] = {}
    for pair in given:
        name, equals, value = pair.partition("=")
        if not equals or not name.strip() or not value.strip():
            raise ValueError(f"{option} {pair}: expected NAME=VALUE")
        if name in found:
            raise ValueError(f"{option} {name}: is given twice")
        found[name.strip()] = value.strip()
    return found


def _ask(asked: Ambiguous) -> str:
    """Ask the user at the terminal, and return the answer."""
    note(asked.question)
    if asked.free_text:
        return str(click.prompt(asked.option.strip("-"), err=True))
    answers = click.Choice([*asked.answers, *asked.numbered])
    # The question itself lists the columns with their numbers.
    label = asked.name.strip("-") + (", number or name" if asked.numbered else "")
    return str(click.prompt(label, type=answers, show_choices=not asked.numbered, err=True))


@click.command("import", short_help="Make a measurement set from files of other programs.")
@click.argument(
    "files",
    metavar="FILE...",
    nargs=-1,
    required=True,
    type=click.Path(path_type=Path),
)
@click.argument("out", metavar="OUT", type=OutputFolder())
@click.option(
    "--column",
    "columns",
    multiple=True,
    metavar="NAME=COLUMN",
    help=f"Assign a column of the file (its name, or its number from 1; 2:NAME in the second "
    f"file) to a quantity: {', '.join(QUANTITIES)}; another NAME is a condition.",
)
@click.option(
    "--unit", "units", multiple=True, metavar="NAME=UNIT", help=f"Unit of a column. {_UNITS}."
)
@click.option(
    "--format",
    "reader",
    default="",
    metavar="NAME",
    help="Name of the reader.  [default: the reader that recognises the file]",
)
@click.option(
    "--delimiter",
    type=click.Choice(["comma", "semicolon", "tab", "space"]),
    help="Separator of the columns in a text file.",
)
@click.option(
    "--decimal",
    type=click.Choice(["point", "comma"]),
    help="Decimal separator in a text file.",
)
@click.option(
    "--group",
    default="",
    metavar="PATH",
    help="Group of an HDF5 file, or variable of an EPICS log.",
)
@click.option(
    "--period", type=Finite(min=0.0, min_open=True), help="Time between two rows in seconds."
)
@click.option("--counts-per-rev", type=click.IntRange(min=4), help="Counts per turn.")
@click.option(
    "--separation", type=Finite(-360.0, 360.0), help="Angle from head 1 to head 2, degrees."
)
@click.option(
    "--places",
    "places_deg",
    type=Places(),
    metavar="0,P2,P3[,P4]",
    help="Angles of three or four heads relative to head 1, degrees.",
)
@click.option(
    "--sign",
    type=click.Choice(["reading-true", "true-reading"]),
    help="Sign of the error column; true-reading is the sign of ISO 230-2.",
)
@click.option(
    "--zero",
    type=click.Choice(["shift", "keep"]),
    help="If reading and reference have different zeros: shift the reference, or keep it.",
)
@click.option(
    "--clock-offset", type=Finite(), help="Seconds that are added to the times of the reference."
)
@click.option(
    "--rate", type=Finite(), help="Constant speed of the axis, deg/s, for files without angles."
)
@click.option(
    "--order",
    type=click.Choice(["sort", "runs"]),
    help="If the time steps back: sort the rows, or begin a new run at each such row.",
)
@click.option(
    "--missing", type=click.Choice(["drop"]), help="Leave out rows in which a value is missing."
)
@click.option("--lines", type=click.IntRange(min=1), help="Grating lines of the disc.")
@click.option(
    "--gear-teeth",
    type=Finite(min=0, min_open=True),
    help="Number of teeth of the drive; need not be whole.",
)
@click.option("--faces", type=click.IntRange(min=1), help="Number of faces of the polygon.")
@click.option("--instrument", metavar="TEXT", help="Name of the reference instrument.")
@click.option(
    "--u", "u_arcsec", type=Finite(min=0.0), help="Standard uncertainty of the reference, arcsec."
)
@click.option("--title", default="", metavar="TEXT", help="Title of the set.")
@click.option("--date", metavar="DATE", help="Date of the measurement, such as 2026-03-12T09:30.")
@click.option("--dry-run", is_flag=True, help="Print what would be written; write nothing.")
@for_people
def import_(
    files: tuple[Path, ...],
    out: Path,
    columns: tuple[str, ...],
    units: tuple[str, ...],
    reader: str,
    delimiter: str | None,
    decimal: str | None,
    group: str,
    period: float | None,
    counts_per_rev: int | None,
    separation: float | None,
    places_deg: tuple[float, ...] | None,
    sign: str | None,
    zero: str | None,
    clock_offset: float | None,
    rate: float | None,
    order: str | None,
    missing: str | None,
    lines: int | None,
    gear_teeth: float | None,
    faces: int | None,
    instrument: str | None,
    u_arcsec: float | None,
    title: str,
    date: str | None,
    dry_run: bool,
) -> None:
    """Make the measurement set OUT from FILEs that other programs recorded.

    Formats: text in columns, JSON lines, NumPy, Parquet, HDF5, guide logs of PHD2, samples of
    LinuxCNC, camonitor logs of EPICS, MAT files; each also compressed with gzip. At a terminal the
    command asks for information that the files lack. In a script it prints all open questions with
    their options and the first rows, and ends with exit code 2. The set stores the command that
    repeats the import.
    """
    if not dry_run:
        refuse_occupied(out)
    settings = Settings(
        columns=_pairs("--column", columns),
        units=_pairs("--unit", units),
        sign=sign or "",
        zero=zero or "",
        clock_offset_s=clock_offset,
        rate_deg_s=rate,
        missing=missing or "",
        order=order or "",
        table=Table(
            counts_per_rev=counts_per_rev,
            head_separation_deg=separation,
            head_places_deg=places_deg,
            grating_lines=lines,
            drive_gear_teeth=gear_teeth,
            faces=faces,
        ),
        instrument=instrument,
        standard_uncertainty_arcsec=u_arcsec,
        title=title,
        date=None if date is None else moment(date, "--date"),
    )
    reading = ReadSettings(delimiter or "", decimal or "", group, period)
    import_ = Import(files, reader, reading, settings)
    at_terminal = sys.stdin.isatty()
    choices = Choices(Asker(import_, _ask) if at_terminal else refuse)
    try:
        imported = import_.run(choices)
    except AmbiguousError as error:
        raise ValueError(all_open(import_, error.asked)) from error
    command = _command(choices.answers)
    _print(files, imported)
    if dry_run:
        console.print(f"{out} is not written (--dry-run); the complete command is: {command}")
        return
    decided = tuple(one_line(text) for text in imported.notes)
    origin = Origin(one_line(command), f"arctrue {version('arctrue')}", decided)
    write_measurement_set(out, replace(imported.measurement, origin=origin))
    from arctrue.report.charts.imported_rows import imported_rows_chart
    from arctrue.report.charts.matplotlib_chart import save_chart

    picture = save_chart(imported_rows_chart(imported.measurement), out / "first_plot.png")
    console.print(f"wrote {out}; first look: {picture}", soft_wrap=True)


def _command(answers: Sequence[tuple[str, str]]) -> str:
    """Return the command that repeats this import: the typed command with the answers as
    options."""
    context = click.get_current_context()
    words = ["arctrue", "import"]
    assert isinstance(context.command, click.Command)
    given = context.params
    for option in context.command.params:
        value = given.get(option.name or "")
        if isinstance(option, click.Argument) or option.name == "dry_run" or value in (None, ""):
            continue
        for item in value if option.multiple else [value]:
            words += [option.opts[0], _typed(item)]
    for name, answer in answers:
        words += [name, answer]
    return shlex.join([*words, *map(str, given["files"]), str(given["out"])])


def _typed(value: object) -> str:
    """Return the value of an option as it is typed."""
    return ",".join(map(str, value)) if isinstance(value, tuple) else str(value)


def _print(files: Sequence[Path], imported: Imported) -> None:
    grid = table("Columns", *map(words, ("file", "column", "quantity", "unit", "assigned by")))
    for path, sources in zip(files, imported.mapped, strict=True):
        for name, source in sources.items():
            grid.add_row(path.name, source.column, name, source.unit or "–", source.said_by)
    console.print(grid)
    for decided in imported.notes:
        console.print(f"• {decided}", soft_wrap=True)
    print_runs(imported.measurement)
