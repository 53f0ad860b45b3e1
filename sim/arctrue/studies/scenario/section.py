"""A table of a TOML file, read strictly: every key is asked for, or refused."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from difflib import get_close_matches
from typing import Any, NoReturn

from arctrue.studies.scenario.errors import ScenarioError


class Section:
    """One table with the place it stands in; ask for its keys, then call :meth:`finish`."""

    def __init__(self, file: str, place: str, values: Mapping[str, Any]) -> None:
        """``place`` is empty for the top of the file."""
        self.file, self.place = file, place
        self._values = values
        self._known: list[str] = []

    def refuse(self, key: str, expected: str, found: object) -> NoReturn:
        """Raise ScenarioError for a key."""
        raise ScenarioError(
            f"{self.file}: {self._at(key)}: expected {expected}, found {_shown(found)}"
        )

    def _at(self, key: str) -> str:
        return f"{self.place}.{key}" if self.place else key

    def has(self, key: str) -> bool:
        """The key is there."""
        self._know(key)
        return key in self._values

    def _know(self, key: str) -> None:
        if key not in self._known:
            self._known.append(key)

    def _get(self, key: str, expected: str, default: object) -> Any:
        self._know(key)
        if key in self._values:
            return self._values[key]
        if default is None:
            raise ScenarioError(f"{self.file}: {self._at(key)} is missing: expected {expected}")
        return default

    def number(
        self,
        key: str,
        default: float | None = None,
        *,
        low: float = -math.inf,
        high: float = math.inf,
        above: float | None = None,
    ) -> float:
        """A finite number from ``low`` to ``high``, and more than ``above``."""
        expected = _range("a number", low, high, above)
        value = self._get(key, expected, default)
        if isinstance(value, bool) or not isinstance(value, int | float):
            self.refuse(key, expected, value)
        if not math.isfinite(value) or not low <= value <= high:
            self.refuse(key, expected, value)
        if above is not None and not value > above:
            self.refuse(key, expected, value)
        return float(value)

    def whole(
        self,
        key: str,
        default: int | None = None,
        *,
        low: float = -math.inf,
        high: float = math.inf,
    ) -> int:
        """A whole number from ``low`` to ``high``."""
        expected = _range("a whole number", low, high, None)
        value = self._get(key, expected, default)
        if isinstance(value, bool) or not isinstance(value, int) or not low <= value <= high:
            self.refuse(key, expected, value)
        return value

    def text(self, key: str, default: str | None = None) -> str:
        """A text."""
        value = self._get(key, "a text", default)
        if not isinstance(value, str):
            self.refuse(key, "a text", value)
        return value

    def choice(self, key: str, words: Sequence[str], default: str | None = None) -> str:
        """One of some words."""
        expected = "one of " + ", ".join(f'"{word}"' for word in words)
        value = self._get(key, expected, default)
        if value not in words:
            self.refuse(key, expected, value)
        return str(value)

    def words(self, key: str, allowed: Sequence[str], default: Sequence[str] | None = None) -> Any:
        """A list of such words, as a tuple."""
        expected = "a list of " + ", ".join(f'"{word}"' for word in allowed)
        value = self._get(key, expected, default)
        if not isinstance(value, list | tuple) or not all(item in allowed for item in value):
            self.refuse(key, expected, value)
        return tuple(str(item) for item in value)

    def numbers(self, key: str) -> tuple[float, ...]:
        """A list of numbers, not empty."""
        value = self._get(key, "a list of numbers", None)
        if (
            not isinstance(value, list)
            or not value
            or any(isinstance(item, bool) or not isinstance(item, int | float) for item in value)
            or not all(math.isfinite(item) for item in value)
        ):
            self.refuse(key, "a list of numbers", value)
        return tuple(float(item) for item in value)

    def section(self, key: str) -> Section:
        """A table; empty where it is not given."""
        value = self._get(key, "a table", {})
        if not isinstance(value, dict):
            self.refuse(key, "a table", value)
        return Section(self.file, self._at(key), value)

    def sections(self, key: str) -> list[Section]:
        """A list of tables; empty where it is not given."""
        value = self._get(key, "a list of tables", [])
        if not isinstance(value, list) or not all(isinstance(item, dict) for item in value):
            self.refuse(key, "a list of tables", value)
        return [
            Section(self.file, f"{self._at(key)}[{number}]", item)
            for number, item in enumerate(value, start=1)
        ]

    def keys(self) -> Iterable[str]:
        """Every key that is given."""
        return self._values.keys()

    def finish(self) -> None:
        """Refuse what nobody asked for."""
        for key in self._values:
            if key not in self._known:
                near = get_close_matches(key, self._known, 1)
                meant = f" (did you mean {near[0]}?)" if near else ""
                raise ScenarioError(
                    f"{self.file}: {self._at(key)}: not a key here{meant}; "
                    f"there are: {', '.join(self._known)}"
                )


def _range(what: str, low: float, high: float, above: float | None) -> str:
    parts = [what]
    if above is not None:
        parts.append(f"above {above:g}")
    if math.isfinite(low) and math.isfinite(high):
        parts.append(f"from {low:g} to {high:g}")
    elif math.isfinite(low):
        parts.append(f"of {low:g} or more")
    elif math.isfinite(high):
        parts.append(f"of {high:g} or less")
    return " ".join(parts)


def _shown(value: object) -> str:
    text = f'"{value}"' if isinstance(value, str) else repr(value)
    return text if len(text) <= 60 else text[:57] + "…"
