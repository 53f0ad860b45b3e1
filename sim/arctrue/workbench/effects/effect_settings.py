"""Checks and stores the settings of an effect, and accepts declarations under former names."""

from __future__ import annotations

from abc import ABC
from collections.abc import Mapping, Sequence
from typing import Any, ClassVar

from arctrue.base.similar import did_you_mean

FORMER_NAMES = {
    "told_apart_by": "separated_by", "told": "describe_data", "seen": "describe_values",
}  # fmt: skip


class EffectWithSettings(ABC):
    """An effect's name and settings."""

    name: ClassVar[str]
    """Public name, as used on the command line, in model files and in JSON."""
    defaults: ClassVar[Mapping[str, object]] = {}
    """Settings and their default values."""

    def __init_subclass__(cls, **of_class: Any) -> None:
        """Accept declarations under their former names, for one release."""
        super().__init_subclass__(**of_class)
        for former, name in FORMER_NAMES.items():
            if former in cls.__dict__ and name not in cls.__dict__:
                setattr(cls, name, cls.__dict__[former])

    def __init__(self, **settings: object) -> None:
        """Check and store the settings.

        Raises ValueError for a setting that this effect does not have, or of a wrong type.
        """
        unknown = sorted(set(settings) - set(self.defaults))
        if unknown:
            known = ", ".join(sorted(self.defaults)) or "none"
            raise ValueError(
                f"effect {self.name}: unknown setting {', '.join(unknown)}."
                f"{did_you_mean(unknown[0], self.defaults)} It has: {known}"
            )
        for key, value in settings.items():
            expected = self.defaults[key]
            numbers = (int, float)
            same = isinstance(value, type(expected)) or (
                isinstance(expected, numbers) and isinstance(value, numbers)
            )
            if not same or (isinstance(value, bool) and not isinstance(expected, bool)):
                raise ValueError(
                    f"effect {self.name}: setting {key} must be like {expected!r}, found {value!r}"
                )
        self.settings: dict[str, object] = {**self.defaults, **settings}
        for key in settings:
            if _lists_integers(self.defaults[key]):
                self.integers(key)

    def integers(self, key: str) -> tuple[int, ...]:
        """Return a setting that lists whole numbers above 0, each once. Raises ValueError if the
        setting has other values."""
        values = self.settings[key]
        if (
            not isinstance(values, Sequence)
            or not all(
                isinstance(value, int) and not isinstance(value, bool) and value > 0
                for value in values
            )
            or len(set(values)) != len(values)
        ):
            raise ValueError(
                f"effect {self.name}: setting {key} must list whole numbers above 0, each once, "
                f"found {values!r}"
            )
        return tuple(values)


def _lists_integers(default: object) -> bool:
    """Tell whether a setting with this default lists whole numbers."""
    return (
        isinstance(default, list)
        and bool(default)
        and all(isinstance(value, int) and not isinstance(value, bool) for value in default)
    )
