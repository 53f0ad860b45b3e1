"""Finds all effects by name: built-in effects, effects of a folder, and effects of other
packages."""

from __future__ import annotations

import importlib
import importlib.metadata
import importlib.util
import inspect
import pkgutil
from collections.abc import Iterable, Mapping
from pathlib import Path

import arctrue.workbench.effects.catalogue
from arctrue.base.similar import did_you_mean
from arctrue.workbench.effects.base import Effect
from arctrue.workbench.effects.guarded import (
    LOAD_S,
    EffectFileError,
    file_error,
    guarded,
    too_long,
)
from arctrue.workbench.effects.product_of_parts import ProductOfParts
from arctrue.workbench.effects.time_limit import TookTooLongError, call_within
from arctrue.workbench.observations import Observations

ENTRY_POINTS = "arctrue.effects"

ORDER = (
    "graduation_harmonics",
    "high_order_graduation",
    "head_angle_error",
    "subdivision_error",
    "radial_error_motion",
    "bearing_ball_pass",
    "vibration",
    "hysteresis",
    "timing_skew",
    "latency",
    "thermal_head_drift",
    "thermal_eccentricity",
    "count_slip",
    "graduation_defect",
    "drive_gear_error",
    "polygon_face_error",
    "polygon_eccentricity",
    "autocollimator_gain",
    "reference_drift",
    "pointing_geometry",
    "periodic_error",
)
"""Modules of the catalogue, in the order in which commands list the effects."""


class EffectNotFoundError(ValueError):
    """The name belongs to no known effect."""


def effects_in(module: object) -> list[type[Effect]]:
    """Return the effects that a module defines itself, not those that it imports."""
    return [
        item
        for item in vars(module).values()
        if isinstance(item, type)
        and issubclass(item, Effect)
        and not inspect.isabstract(item)
        and item.__module__ == getattr(module, "__name__", "")
        and hasattr(item, "name")
    ]


def built_in() -> dict[str, type[Effect]]:
    """Return the effects of this package, in the catalogue's order."""
    found: dict[str, type[Effect]] = {}
    for info in pkgutil.iter_modules(arctrue.workbench.effects.catalogue.__path__):
        module = importlib.import_module(f"arctrue.workbench.effects.catalogue.{info.name}")
        found |= {item.name: item for item in effects_in(module)}
    return {name: found[name] for name in sorted(found, key=_place)}


def _place(name: str) -> tuple[int, str]:
    return (ORDER.index(name) if name in ORDER else len(ORDER), name)


def from_folder(folder: Path) -> dict[str, type[Effect]]:
    """Return the effects of the Python files of a folder.

    Files whose names begin with ``test_``, ``_`` or ``conftest`` are omitted.

    Raises EffectFileError, which names the file, for a missing folder or a file that fails.
    """
    if not folder.is_dir():
        raise EffectFileError(f"{folder}: no such folder of effects")
    found: dict[str, type[Effect]] = {}
    for path in sorted(folder.glob("*.py")):
        if not path.name.startswith(("test_", "_", "conftest")):
            found |= from_file(path)
    return found


def from_file(path: Path) -> dict[str, type[Effect]]:
    """Return the effects of one Python file.

    Raises EffectFileError, which names the file, if it fails.
    """
    if not path.is_file():
        raise EffectFileError(f"{path}: no such file of effects")
    if path.suffix != ".py":
        raise EffectFileError(f"{path}: expected a Python file, whose name ends in .py")
    spec = importlib.util.spec_from_file_location(f"arctrue_user_effects.{path.stem}", path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    try:
        call_within(LOAD_S, spec.loader.exec_module, module)
    except TookTooLongError as error:
        raise too_long(path, error, "", LOAD_S) from error
    except BaseException as error:  # a user's file may even call sys.exit
        mine = file_error(path, error)
        if mine is not None:
            raise mine from error
        if not isinstance(error, Exception):
            raise
        raise EffectFileError(
            f"{path}: cannot be loaded: {type(error).__name__}: {error}"
        ) from error
    own = effects_in(module)
    if not own:
        raise EffectFileError(
            f"{path}: defines no effect; expected a class derived from "
            "arctrue.workbench.effects.base.Effect with a name"
        )
    return {item.name: guarded(item, path) for item in own}


def from_entry_points() -> dict[str, type[Effect]]:
    """Return the effects that installed packages offer as entry points ``arctrue.effects``."""
    found: dict[str, type[Effect]] = {}
    for point in importlib.metadata.entry_points(group=ENTRY_POINTS):
        try:
            item = point.load()
        except Exception as error:
            raise EffectFileError(
                f"entry point {point.name}: {point.value} cannot be loaded: "
                f"{type(error).__name__}: {error}"
            ) from error
        if not (isinstance(item, type) and issubclass(item, Effect)):
            raise EffectFileError(f"entry point {point.name}: {point.value} is not an effect")
        path = Path(inspect.getsourcefile(item) or point.value)
        found[item.name] = guarded(item, path)
    return found


def absent_effects(
    effects: Mapping[str, type[Effect]], present: Iterable[str], observations: Observations
) -> dict[str, type[Effect]]:
    """Return the effects that concern the set, need no settings, and are not among the model's
    effects ``present``."""
    there = set(present)
    return {
        name: effect
        for name, effect in effects.items()
        if name not in there and not effect.needs_settings and effect().concerns(observations)
    }


def catalogue(folders: Iterable[Path] = ()) -> dict[str, type[Effect]]:
    """Return every effect by name: the built-in effects, the product of parts, and users' effects.

    Raises EffectFileError if a later source uses an existing name.
    """
    found = built_in()
    found[ProductOfParts.name] = ProductOfParts
    sources = [("an entry point", from_entry_points())]
    sources += [(str(folder), from_folder(folder)) for folder in folders]
    for source, effects in sources:
        for name, effect in effects.items():
            if name in found:
                raise EffectFileError(f"{source}: the effect name {name} is taken already")
            found[name] = effect
    return found


def effect_class(name: str, effects: dict[str, type[Effect]]) -> type[Effect]:
    """Return the effect of this name. Raises EffectNotFoundError, which lists all effects."""
    if name not in effects:
        raise EffectNotFoundError(
            f"no effect is named {name!r}.{did_you_mean(name, effects)} "
            f"There are: {', '.join(effects)}"
        )
    return effects[name]
