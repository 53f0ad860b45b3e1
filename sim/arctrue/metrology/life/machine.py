"""Fits one model to every measurement set of one machine."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from arctrue.measurement import MeasurementError, read_measurement_set
from arctrue.measurement.description import FILE_NAME
from arctrue.measurement.digest import set_digest
from arctrue.workbench.effects.base import Effect, Parameter
from arctrue.workbench.model.growth import NotTestableError, fitted, table_of
from arctrue.workbench.model.model import Model
from arctrue.workbench.observations.build import observations_of

Float = NDArray[np.float64]

DAY_S = 86_400.0


@dataclass(frozen=True, eq=False)
class FittedSet:
    """A measurement set of the machine with the fitted parameters."""

    name: str
    """Folder of the set, relative to the machine's folder."""
    date: datetime
    sha256: str
    parameters: Mapping[str, Parameter]

    @property
    def day(self) -> float:
        """Time of the measurement set in days since 1970."""
        return self.date.timestamp() / DAY_S


@dataclass(frozen=True)
class RefusedSet:
    """A measurement set that the history does not use, and the reason."""

    name: str
    reason: str


@dataclass(frozen=True, eq=False)
class Machine:
    """All measurement sets of a machine: the fitted ones by date, and the refused ones."""

    model: Model
    sets: tuple[FittedSet, ...]
    refused: tuple[RefusedSet, ...]

    @property
    def days(self) -> Float:
        """Times of the fitted sets in days since 1970, (sets,)."""
        return np.array([one.day for one in self.sets])


def set_folders(folder: Path) -> list[Path]:
    """Return the folders of measurement sets below ``folder``, sorted by name. Raises ValueError if
    there is none."""
    if not folder.is_dir():
        raise ValueError(f"{folder}: no such folder; expected a folder of measurement sets")
    found = sorted(path.parent for path in folder.rglob(FILE_NAME) if path.parent != folder)
    if not found:
        raise ValueError(
            f"{folder}: holds no measurement sets; expected folders with a {FILE_NAME} in each"
        )
    return found


def fit_machine(
    folder: Path,
    model: Model,
    effects: Mapping[str, type[Effect]],
    report_step: Callable[[str], None] = lambda _: None,
) -> Machine:
    """Fit ``model`` to each set below ``folder``; list each set that cannot be used, with the
    reason.

    Raises ValueError if no set can be used.
    """
    found: list[FittedSet] = []
    refused: list[RefusedSet] = []
    folders = set_folders(folder)
    first = None
    for number, place in enumerate(folders, start=1):
        name = place.relative_to(folder).as_posix()
        report_step(f"set {number} of {len(folders)}: {name}")
        try:
            measurement = read_measurement_set(place)
            if measurement.date is None:
                raise ValueError(
                    f"{FILE_NAME} states no date; add a line such as date = 2026-03-12 at the top"
                )
            digest = set_digest(place)
            _refuse_again(digest, found)
            observations = observations_of(
                measurement, reference_temperature_c=model.reference_temperature_c
            )
            table = table_of(observations)
            if first is not None and (differs := first.differences(table)):
                raise ValueError(f"is of another table than {found[0].name}: {'; '.join(differs)}")
            _, solution = fitted(model, observations, effects)
        except (MeasurementError, NotTestableError, ValueError, OSError) as error:
            refused.append(RefusedSet(name, str(error)))
            continue
        first = table if first is None else first
        found.append(FittedSet(name, measurement.date, digest, solution.named_parameters()))
    if not found:
        listed = "".join(f"\n  {item.name}: {item.reason}" for item in refused)
        raise ValueError(f"{folder}: no set can be used:{listed}")
    return Machine(model, tuple(sorted(found, key=lambda one: one.date)), tuple(refused))


def _refuse_again(digest: str, found: Sequence[FittedSet]) -> None:
    for one in found:
        if one.sha256 == digest:
            raise ValueError(f"is the same set as {one.name}; one of them is used")
