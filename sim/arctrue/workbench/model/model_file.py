"""Reads and writes model files: TOML that people read, edit and keep under version control."""

from __future__ import annotations

import errno
import math
import os
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Annotated, Literal

import msgspec
import tomli_w
from filelock import FileLock, Timeout
from msgspec import Meta, Struct

from arctrue.base.printable import is_printable, one_line
from arctrue.base.read_errors import unreadable
from arctrue.base.toml_file import TomlContentError, read_toml
from arctrue.base.typed_content import ContentError, Number, shown, typed
from arctrue.base.whole_file import write_whole_text
from arctrue.workbench.effects.base import Parameter
from arctrue.workbench.model.model import HistoryStep, Model, ModelEffect, ModelTable

SCHEMA: Literal[1] = 1

UNITS = {
    "1", "arcsec", "arcsec/K", "arcsec/h", "arcsec/cycle", "counts", "deg", "Hz", "s", "us", "um",
    "um/K", "%",
}  # fmt: skip
"""Units that a stored parameter may have; :func:`known_unit` also accepts other quotients arcsec/…,
um/… and 1/…."""


def known_unit(unit: str) -> bool:
    """Tell whether a model file may hold a parameter of this unit."""
    return unit in UNITS or unit.startswith(("arcsec/", "um/", "1/"))


class _Declared(Struct, forbid_unknown_fields=True, omit_defaults=True):
    """A structure that the file stores without the keys that have their default value."""


class _Parameter(_Declared):
    value: Number
    unit: Annotated[str, Meta(description='a unit in quotes, like "arcsec"')]
    sigma: Number | None = None

    def __post_init__(self) -> None:
        if not known_unit(self.unit):
            known = ", ".join(sorted(UNITS))
            raise ValueError(f"unit: expected one of {known}, found {shown(self.unit)}")


class _Effect(_Declared):
    name: str
    settings: dict[str, object] = {}
    search: dict[str, Number] = {}
    columns: list[str] = []
    coefficients: list[Number] = []
    parameters: dict[str, _Parameter] = {}


class _OnlySchema(Struct):
    schema: Literal[1]


class _File(_Declared, kw_only=True):
    schema: Literal[1]
    effect: Annotated[list[_Effect], Meta(min_length=1, description="one [[effect]] or more")]
    effect_folders: list[str] = []
    history: list[HistoryStep] = []
    reference_offset_arcsec: Number = 0.0
    reference_temperature_c: Number | None = None
    table: ModelTable | None = None


class ModelFileError(ValueError):
    """The model file cannot be used; the message names the file and the reason."""


def read_model(path: Path) -> Model:
    """Read a model file. Raises ModelFileError if it cannot be used."""
    try:
        data = read_toml(path)
        # Check the schema first: if the file has another schema, errors about its entries would be
        # misleading.
        typed(data, _OnlySchema)
        file = typed(data, _File)
        effects = [
            _effect(f"effect[{number}]", entry) for number, entry in enumerate(file.effect, start=1)
        ]
        _refuse_unfit(data, "")
    except OSError as error:
        raise ModelFileError(f"{path}: {unreadable(error)}") from error
    except (TomlContentError, ContentError) as error:
        raise ModelFileError(f"{path}: {error}") from error
    return Model(
        effects,
        file.effect_folders,
        file.history,
        file.reference_offset_arcsec,
        file.reference_temperature_c,
        file.table,
    )


def write_model(path: Path, model: Model, comment: Sequence[str] = ()) -> None:
    """Write a model file; the old file stays until the new file is complete.

    ``comment``: lines at the beginning of the file, which no reader of the model evaluates. Raises
    OSError, and ModelFileError for a model that could not be read again.
    """
    file = _File(
        schema=SCHEMA,
        effect=[_effect_entry(effect) for effect in model.effects],
        effect_folders=model.folders,
        history=model.history,
        reference_offset_arcsec=model.reference_offset_arcsec,
        reference_temperature_c=model.reference_temperature_c,
        table=model.table,
    )
    data = msgspec.to_builtins(file)
    try:
        _refuse_unfit(data, "")
    except ContentError as error:
        raise ModelFileError(f"{path}: {error}") from error
    head = "".join(f"# {one_line(line)}\n" for line in comment)
    write_whole_text(path, head + tomli_w.dumps(data, multiline_strings=False))


@contextmanager
def model_lock(path: Path, waiting: Callable[[], None] = lambda: None) -> Iterator[None]:
    """Lock the model file between reading and writing, so that no other command changes it.

    ``waiting`` is called once if another process holds the lock; this process then waits until the
    other process releases the lock or ends. Raises OSError if the folder cannot be written.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    target = path.resolve()
    place = target.with_name(f".{target.name}.lock")
    lock = FileLock(place)
    try:
        lock.acquire(blocking=False)
    except Timeout:
        if not place.exists():
            # Some file systems (/proc) report a file that cannot be made as a file in use.
            raise OSError(errno.EACCES, os.strerror(errno.EACCES), str(place)) from None
        waiting()
        lock.acquire()
    try:
        yield
    finally:
        # The lock file is deleted before the lock is released: a waiting process notices this and
        # makes a new lock file.
        with suppress(OSError):
            place.unlink(missing_ok=True)
        lock.release()


def folder_entry(model_file: Path, folder: Path) -> str:
    """Return the folder as written in the model file: relative to the file's own folder, with
    forward slashes.

    A model and its effects can therefore be moved together. The path is absolute if the file and
    the folder are on different drives.
    """
    try:
        relative = os.path.relpath(folder.resolve(), model_file.resolve().parent)
    except ValueError:
        return folder.resolve().as_posix()
    return Path(relative).as_posix()


def _refuse_unfit(value: object, place: str) -> None:
    """Raise ContentError for text that is not one printable line or a number that is not finite.

    Settings and columns can have any structure, so the function searches all content.
    """
    if isinstance(value, dict):
        for key, item in value.items():
            dotted = f"{place}.{key}" if place else key
            _refuse_unfit(key, f"the key {dotted!r}")
            _refuse_unfit(item, dotted)
    elif isinstance(value, list):
        for number, item in enumerate(value, start=1):
            _refuse_unfit(item, f"{place}[{number}]")
    elif isinstance(value, str) and not is_printable(value):
        raise ContentError(f"{place}: expected one line of printable text, found {shown(value)}")
    elif isinstance(value, float) and not math.isfinite(value):
        raise ContentError(f"{place}: expected a finite number, found {value!r}")


def _effect_entry(effect: ModelEffect) -> _Effect:
    return _Effect(
        effect.name,
        effect.settings,
        effect.search,
        effect.columns,
        effect.coefficients,
        {
            name: _Parameter(
                found.value, found.unit, None if math.isnan(found.sigma) else found.sigma
            )
            for name, found in effect.parameters.items()
        },
    )


def _effect(place: str, entry: _Effect) -> ModelEffect:
    if len(entry.coefficients) != len(entry.columns):
        raise ContentError(
            f"{place} ({one_line(entry.name)}).coefficients: expected as many as columns, "
            f"{len(entry.columns)}, found {len(entry.coefficients)}"
        )
    return ModelEffect(
        entry.name,
        entry.settings,
        entry.search,
        entry.columns,
        entry.coefficients,
        {
            name: Parameter(
                found.value, math.nan if found.sigma is None else found.sigma, found.unit
            )
            for name, found in entry.parameters.items()
        },
    )
