"""Defines the options, the loading, the error format and the JSON output of all commands of the
workbench."""

from __future__ import annotations

import functools
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import click

from arctrue.base.json_text import json_text
from arctrue.base.printable import one_line
from arctrue.base.progress import SHOW_ROWS
from arctrue.base.read_errors import sentence
from arctrue.base.whole_file import write_whole_text
from arctrue.calibration.head_separation import doubts_of
from arctrue.cli._numbers import SEED
from arctrue.cli._options import json_option
from arctrue.cli._outputs import OutputFolder, refuse_to_replace
from arctrue.cli._progress import Progress
from arctrue.cli._terminal import Console, note, tell_error, tell_warning
from arctrue.measurement import MeasurementError, MeasurementSet, read_measurement_set
from arctrue.measurement.digest import set_digest
from arctrue.workbench.diagnose.data_faults import cut_runs
from arctrue.workbench.effects.base import Effect
from arctrue.workbench.effects.guarded import EffectFileError
from arctrue.workbench.effects.registry import EffectNotFoundError, catalogue
from arctrue.workbench.model.growth import AlreadyThereError, NotTestableError, table_of
from arctrue.workbench.model.model import Model, default_model
from arctrue.workbench.model.model_file import (
    ModelFileError,
    folder_entry,
    model_lock,
    read_model,
    write_model,
)
from arctrue.workbench.model.provenance import with_provenance
from arctrue.workbench.model.stations import on_its_arc, warnings_of_the_arc
from arctrue.workbench.noise.doubtful_columns import doubtful_columns
from arctrue.workbench.observations import Observations
from arctrue.workbench.observations.build import observations_of

EXIT_BAD_INPUT = 2
KEEP_OUTLIERS = "arctrue.keep_outliers"
SHOWN_MASKED = 5
"""Number of masked rows that the terminal lists; --json lists all of them."""
console = Console()

PEOPLE_ERRORS = (
    MeasurementError,
    ModelFileError,
    EffectFileError,
    EffectNotFoundError,
    NotTestableError,
    AlreadyThereError,
    ValueError,
    OSError,
)


@dataclass(frozen=True)
class LoadedSet:
    """A measurement set, its model, and all known effects."""

    observations: Observations
    model: Model
    effects: dict[str, type[Effect]]
    measurement: str
    measurement_set: MeasurementSet


def set_argument(function: Callable[..., None]) -> Callable[..., None]:
    """Add the argument SET: the folder of a measurement set."""
    return click.argument(
        "measurement_set", metavar="SET", type=click.Path(path_type=Path, file_okay=False)
    )(function)


def _remember_outliers(context: click.Context, _: click.Parameter, value: bool) -> None:
    """Store the value of --keep-outliers for :func:`load`; the commands do not pass it on."""
    context.meta[KEEP_OUTLIERS] = value


model_option = click.option(
    "--model", "model_file", type=click.Path(path_type=Path), help="Model (TOML)."
)
effects_option = click.option(
    "--effects",
    "folders",
    type=click.Path(path_type=Path),
    multiple=True,
    help="Folder with your own effects.",
)


def common_options(function: Callable[..., None]) -> Callable[..., None]:
    """Add --model, --effects, --json, --out, --seed, --keep-outliers and --other-table."""
    for option in (
        click.option(
            "--keep-outliers",
            is_flag=True,
            expose_value=False,
            callback=_remember_outliers,
            help="Also use rows that look like outliers.",
        ),
        click.option(
            "--other-table",
            is_flag=True,
            expose_value=False,
            callback=_remember_other_table,
            help="Use the model even if it belongs to another table.",
        ),
        click.option(
            "--seed",
            type=SEED,
            default=1,
            show_default=True,
            help="Seed of the random draws of compare and report; other commands make no random "
            "draws.",
        ),
        click.option("--out", type=OutputFolder(), help="Folder for pictures."),
        json_option,
        effects_option,
        model_option,
    ):
        function = option(function)
    return function


_OTHER_TABLE = "arctrue.other_table"


def _remember_other_table(context: click.Context, _: click.Parameter, given: bool) -> None:
    """Store the value of --other-table for :func:`load`; the commands do not pass it on."""
    context.meta[_OTHER_TABLE] = given


def for_people(function: Callable[..., None]) -> Callable[..., None]:
    """Print an error of the input as one sentence on stderr, and end the command with exit code
    2."""

    @functools.wraps(function)
    def wrapped(*arguments: Any, **options: Any) -> None:
        try:
            function(*arguments, **options)
        except PEOPLE_ERRORS as error:
            tell_error(sentence(error))
            raise SystemExit(EXIT_BAD_INPUT) from error

    return wrapped


def load_model(model_file: Path | None, *, may_be_new: bool = False) -> Model:
    """Read the model from the file; without a file (or with a new one), return the default
    model."""
    if model_file is None:
        return default_model()
    refuse_to_replace(model_file)
    if may_be_new and not model_file.exists():
        return default_model()
    return read_model(model_file)


@contextmanager
def changing(model_file: Path | None) -> Iterator[None]:
    """Lock a model file while the ``with`` block changes it; print a note while another command
    holds the lock."""
    if model_file is None:
        yield
        return

    def waiting() -> None:
        note(f"waiting: another command is changing {model_file}")

    with model_lock(model_file, waiting):
        yield


def store(
    model_file: Path,
    model: Model,
    before: Model,
    measurement_set: Path,
    folders: tuple[Path, ...],
    comment: Sequence[str] = (),
) -> None:
    """Write the model; each new step records the time, the program's version and the digest of the
    data.

    Folders of the user's effects are stored relative to the model file, so that both can be moved
    together. ``comment``: lines for human readers, which are written at the beginning of the file.
    """
    known = [*(model_file.parent / folder for folder in model.folders), *folders]
    model.folders = list(dict.fromkeys(folder_entry(model_file, folder) for folder in known))
    made = with_provenance(model, len(before.history), set_digest(measurement_set))
    write_model(model_file, made, comment)


def effects_for(
    model: Model, model_file: Path | None, folders: tuple[Path, ...]
) -> dict[str, type[Effect]]:
    """Return all effects: the built-in ones, those in the model's folders (relative to the model
    file), and those in the folders of --effects."""
    base = model_file.parent if model_file is not None else Path()
    places = [*(base / folder for folder in model.folders), *folders]
    unique = list(dict.fromkeys(place.resolve() for place in places))
    return catalogue(unique)


def load(
    measurement_set: Path,
    model_file: Path | None,
    folders: tuple[Path, ...],
    *,
    may_be_new: bool = False,
) -> LoadedSet:
    """Read the set, the model and the effects that a command works with."""
    model = load_model(model_file, may_be_new=may_be_new)
    effects = effects_for(model, model_file, folders)
    context = click.get_current_context(silent=True)
    keep_outliers = context is not None and bool(context.meta.get(KEEP_OUTLIERS))
    for number, entry in enumerate(model.effects, start=1):
        try:
            entry.effect(effects)
        except ValueError as error:
            raise ModelFileError(f"{model_file}: effect[{number}]: {error}") from error
    with Progress("reading the measurement set") as progress:
        measurement = read_measurement_set(measurement_set, report_bytes=progress.read)
        SHOW_ROWS.set(progress.rows)
        observations = observations_of(
            measurement,
            reference_temperature_c=model.reference_temperature_c,
            mask_outliers=not keep_outliers,
        )
    warnings = [
        *doubts_of(measurement),
        *observations.left_out,
        *cut_runs(observations),
        *doubtful_columns(observations),
        *_duplicates(observations),
        *_table_warnings(model, model_file, observations),
        *warnings_of_the_arc(model, observations),
    ]
    model = on_its_arc(model, observations)
    for warning in (*measurement.warnings, *warnings):
        tell_warning(warning)
    _tell_masked(observations)
    title = measurement.title or one_line(measurement_set.resolve().name)
    return LoadedSet(observations, model, effects, title, measurement)


def _table_warnings(model: Model, model_file: Path | None, observations: Observations) -> list[str]:
    """Return warnings about the model's table. Raises ValueError for a set of another table."""
    if model_file is None or not model_file.exists():
        return []
    if model.table is None:
        return [
            f"{model_file}: names no table (an earlier version of arctrue wrote this file); the "
            "next add or drop adds the table"
        ]
    differences = model.table.differences(table_of(observations))
    if not differences:
        return []
    said = f"{model_file}: belongs to another table: {'; '.join(differences)}"
    if click.get_current_context().meta[_OTHER_TABLE]:
        return [said]
    raise ValueError(f"{said}; to use it anyway, give --other-table")


def _duplicates(observations: Observations) -> list[str]:
    """Return a warning if rows occur twice in the reference."""
    found = [row.row for row in observations.masked if row.reason == "duplicate"]
    if not found:
        return []
    return [
        f"the reference has {len(found)} rows that equal an earlier row in every column, "
        f"including the time (first: row {found[0]}); they are not used"
    ]


def _tell_masked(observations: Observations) -> None:
    masked = observations.masked
    if not masked:
        return
    note(f"{len(masked)} rows are not used:")
    for row in masked[:SHOWN_MASKED]:
        note(f"  {row}")
    if len(masked) > SHOWN_MASKED:
        note(f"  and {len(masked) - SHOWN_MASKED} more; compare --json lists all")


def write_json(path: Path | None, data: dict[str, Any]) -> None:
    """Write JSON to ``path`` if it is given; numbers that are not finite become null."""
    if path is not None:
        write_whole_text(path, json_text(data))


def write_page(
    found: Mapping[str, Any],
    page: Path | None,
    words: Callable[[Any], str],
    out: Path | None,
    plot: Callable[[Any, Path], Path],
) -> None:
    """Write the page and the picture of a study if their paths are given; print both paths."""
    if page is not None:
        write_whole_text(page, words(found))
        console.print(f"wrote {page}", soft_wrap=True)
    if out is not None:
        console.print(f"wrote {plot(found, out)}", soft_wrap=True)
