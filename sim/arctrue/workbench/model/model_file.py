"""Model files: TOML that people read, edit and keep under version control."""

from __future__ import annotations

import math
import os
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import asdict
from pathlib import Path
from typing import Any

import tomli_w
from filelock import FileLock, Timeout

from arctrue.printable import is_printable
from arctrue.toml_file import TomlContentError, read_toml
from arctrue.whole_file import write_whole_text
from arctrue.workbench.effects.base import Parameter
from arctrue.workbench.model.model import HistoryStep, Model, ModelEffect, ModelTable

SCHEMA = 1

UNITS = {
    "1", "arcsec", "arcsec/K", "arcsec/h", "arcsec/cycle", "counts", "deg", "Hz", "s", "us", "um",
    "um/K", "%",
}  # fmt: skip
"""Units that a stored parameter may have; powers of hours, cycles and speeds besides."""


def known_unit(unit: str) -> bool:
    """True if a model file may hold a parameter of this unit."""
    return unit in UNITS or unit.startswith(("arcsec/", "um/", "1/"))


class ModelFileError(ValueError):
    """A model file that cannot be used: which file, which entry, what was expected."""


def read_model(path: Path) -> Model:
    """Read a model file. Raises ModelFileError."""
    try:
        data = read_toml(path)
    except FileNotFoundError as error:
        raise ModelFileError(f"{path}: no such model file") from error
    except OSError as error:
        raise ModelFileError(f"{path}: cannot be read: {error.strerror}") from error
    except TomlContentError as error:
        raise ModelFileError(f"{path}: {error}") from error
    _refuse_unfit(path, data, "")
    if data.get("schema") != SCHEMA:
        raise ModelFileError(f"{path}: schema: expected {SCHEMA}, found {data.get('schema')!r}")
    entries = data.get("effect", [])
    if not isinstance(entries, list) or not entries:
        raise ModelFileError(f"{path}: expected at least one [[effect]]")
    effects = [_effect(path, number, entry) for number, entry in enumerate(entries, start=1)]
    folders = _texts(path, "effect_folders", data.get("effect_folders", []))
    history = data.get("history", [])
    if not isinstance(history, list):
        raise ModelFileError(f"{path}: history: expected [[history]] entries")
    steps = [_step(path, number, entry) for number, entry in enumerate(history, start=1)]
    offset = data.get("reference_offset_arcsec", 0.0)
    warmth = data.get("reference_temperature_c")
    return Model(
        effects,
        folders,
        steps,
        _number(path, "reference_offset_arcsec", offset),
        None if warmth is None else _number(path, "reference_temperature_c", warmth),
        _table(path, data["table"]) if "table" in data else None,
    )


def write_model(path: Path, model: Model) -> None:
    """Write a model file; the old one stays until the new one is whole.

    Raises OSError, and ModelFileError for a model that could not be read again.
    """
    data: dict[str, Any] = {"schema": SCHEMA}
    if model.folders:
        data["effect_folders"] = model.folders
    data["reference_offset_arcsec"] = model.reference_offset_arcsec
    if model.reference_temperature_c is not None:
        data["reference_temperature_c"] = model.reference_temperature_c
    if model.table is not None:
        data["table"] = {
            key: value for key, value in asdict(model.table).items() if value is not None
        }
    data["effect"] = [_effect_entry(effect) for effect in model.effects]
    data["history"] = [
        {
            "action": step.action,
            "effect": step.effect,
            "measurement": step.measurement,
            **{
                key: text
                for key, text in (
                    ("date", step.date),
                    ("program", step.program),
                    ("measurement_sha256", step.measurement_sha256),
                )
                if text
            },
            "rms_arcsec": step.rms_arcsec,
            "peak_arcsec": step.peak_arcsec,
            "heldout_rms_arcsec": step.heldout_rms_arcsec,
            "noise_arcsec": step.noise_arcsec,
        }
        for step in model.history
    ]
    _refuse_unfit(path, data, "")
    write_whole_text(path, tomli_w.dumps(data, multiline_strings=False))


@contextmanager
def model_lock(path: Path, waiting: Callable[[], None] = lambda: None) -> Iterator[None]:
    """Hold the model file from reading it to writing it, so that no other command changes it.

    ``waiting`` is called once if another process holds the file; then this one waits until that
    has ended, however it ended. Raises OSError where the folder cannot be written.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    target = path.resolve()
    place = target.with_name(f".{target.name}.lock")
    lock = FileLock(place)
    try:
        lock.acquire(blocking=False)
    except Timeout:
        waiting()
        lock.acquire()
    try:
        yield
    finally:
        # Deleted while it is held: a process that waits for it sees that, and makes a new one.
        with suppress(OSError):
            place.unlink(missing_ok=True)
        lock.release()


def folder_entry(model_file: Path, folder: Path) -> str:
    """The folder as the model file names it: relative to the model file, with forward slashes.

    A model and its effects that are moved together are found again. The path is absolute where
    the two are on different drives.
    """
    try:
        relative = os.path.relpath(folder.resolve(), model_file.resolve().parent)
    except ValueError:
        return folder.resolve().as_posix()
    return Path(relative).as_posix()


def _refuse_unfit(path: Path, value: object, place: str) -> None:
    """Raise ModelFileError for text that is not one printable line or a number that is not finite.

    Settings and columns are of any shape, so that the whole content is looked through.
    """
    if isinstance(value, dict):
        for key, item in value.items():
            dotted = f"{place}.{key}" if place else key
            _refuse_unfit(path, key, f"the key {dotted!r}")
            _refuse_unfit(path, item, dotted)
    elif isinstance(value, list):
        for number, item in enumerate(value, start=1):
            _refuse_unfit(path, item, f"{place} {number}")
    elif isinstance(value, str) and not is_printable(value):
        raise ModelFileError(f"{path}: {place}: expected one line of printable text: {value!r}")
    elif isinstance(value, float) and not math.isfinite(value):
        raise ModelFileError(f"{path}: {place}: expected a number, found {value!r}")


def _table(path: Path, entry: object) -> ModelTable:
    if not isinstance(entry, dict):
        raise ModelFileError(f"{path}: table: expected a section [table], found {entry!r}")
    counts, separation = entry.get("counts_per_rev"), entry.get("head_separation_deg")
    whole = isinstance(counts, int) and not isinstance(counts, bool) and counts > 0
    if counts is not None and not whole:
        raise ModelFileError(
            f"{path}: table.counts_per_rev: expected a whole number above 0, found {counts!r}"
        )
    return ModelTable(
        counts,
        None if separation is None else _number(path, "table.head_separation_deg", separation),
    )


def _effect_entry(effect: ModelEffect) -> dict[str, Any]:
    entry: dict[str, Any] = {"name": effect.name}
    if effect.settings:
        entry["settings"] = effect.settings
    if effect.search:
        entry["search"] = effect.search
    if effect.coefficients:
        entry["columns"] = effect.columns
        entry["coefficients"] = effect.coefficients
    if effect.parameters:
        entry["parameters"] = {
            name: {
                key: value
                for key, value in (
                    ("value", parameter.value),
                    ("sigma", parameter.sigma),
                    ("unit", parameter.unit),
                )
                if not (isinstance(value, float) and math.isnan(value))
            }
            for name, parameter in effect.parameters.items()
        }
    return entry


def _effect(path: Path, number: int, entry: object) -> ModelEffect:
    place = f"effect {number}"
    if not isinstance(entry, dict) or not isinstance(entry.get("name"), str):
        raise ModelFileError(f"{path}: {place}: expected a name")
    place = f"effect {number} ({entry['name']})"
    settings, search = entry.get("settings", {}), entry.get("search", {})
    if not isinstance(settings, dict) or not isinstance(search, dict):
        raise ModelFileError(f"{path}: {place}: settings and search must be tables")
    columns = _texts(path, f"{place}: columns", entry.get("columns", []))
    coefficients = entry.get("coefficients", [])
    if not isinstance(coefficients, list) or len(coefficients) != len(columns):
        raise ModelFileError(
            f"{path}: {place}: expected as many coefficients as columns ({len(columns)})"
        )
    parameters = entry.get("parameters", {})
    if not isinstance(parameters, dict):
        raise ModelFileError(f"{path}: {place}: parameters must be a table")
    return ModelEffect(
        name=entry["name"],
        settings=settings,
        search={
            key: _number(path, f"{place}: search.{key}", value) for key, value in search.items()
        },
        columns=columns,
        coefficients=[
            _number(path, f"{place}: coefficient {index + 1}", value)
            for index, value in enumerate(coefficients)
        ],
        parameters={
            key: _parameter(path, f"{place}: parameter {key}", value)
            for key, value in parameters.items()
        },
    )


def _parameter(path: Path, place: str, entry: object) -> Parameter:
    if not isinstance(entry, dict):
        raise ModelFileError(f"{path}: {place}: expected value, sigma and unit")
    unit = entry.get("unit")
    if not isinstance(unit, str):
        raise ModelFileError(f"{path}: {place}: expected a unit in quotes, found {unit!r}")
    if not known_unit(unit):
        raise ModelFileError(
            f"{path}: {place}: unknown unit {unit!r}; known are {', '.join(sorted(UNITS))}"
        )
    sigma = entry.get("sigma")
    return Parameter(
        _number(path, f"{place}: value", entry.get("value")),
        math.nan if sigma is None else _number(path, f"{place}: sigma", sigma),
        unit,
    )


def _step(path: Path, number: int, entry: object) -> HistoryStep:
    place = f"history {number}"
    if not isinstance(entry, dict):
        raise ModelFileError(f"{path}: {place}: expected a table")

    def channels(key: str) -> dict[str, float]:
        values = entry.get(key, {})
        if not isinstance(values, dict):
            raise ModelFileError(f"{path}: {place}: {key}: expected a table")
        return {
            name: _number(path, f"{place}: {key}.{name}", item) for name, item in values.items()
        }

    def text(key: str) -> str:
        value = entry.get(key, "")
        if not isinstance(value, str):
            raise ModelFileError(f"{path}: {place}: {key} must be a text, found {value!r}")
        return value

    return HistoryStep(
        action=text("action"),
        effect=text("effect"),
        measurement=text("measurement"),
        date=text("date"),
        program=text("program"),
        measurement_sha256=text("measurement_sha256"),
        rms_arcsec=channels("rms_arcsec"),
        peak_arcsec=channels("peak_arcsec"),
        heldout_rms_arcsec=channels("heldout_rms_arcsec"),
        noise_arcsec=channels("noise_arcsec"),
    )


def _number(path: Path, place: str, value: object) -> float:
    if (
        isinstance(value, bool)
        or not isinstance(value, int | float)
        or not abs(value) <= sys.float_info.max
    ):
        raise ModelFileError(f"{path}: {place}: expected a number, found {value!r}")
    return float(value)


def _texts(path: Path, place: str, value: object) -> list[str]:
    if not isinstance(value, list) or not all(isinstance(item, str) for item in value):
        raise ModelFileError(f"{path}: {place}: expected a list of texts")
    return list(value)
