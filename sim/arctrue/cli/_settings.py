"""Parses the settings of an effect on the command line: --set KEY=VALUE."""

from __future__ import annotations

import math
from collections.abc import Iterable

from arctrue.base.toml_file import TomlContentError, parse_toml


def settings_from(pairs: Iterable[str]) -> dict[str, object]:
    """Parse KEY=VALUE pairs; values are written as in TOML.

    Raises ValueError, which names the pair that is not of this form.
    """
    found: dict[str, object] = {}
    for pair in pairs:
        key, separator, text = pair.partition("=")
        if not separator or not key.strip():
            raise ValueError(f"--set {pair}: expected KEY=VALUE")
        try:
            found[key.strip()] = _finite(pair, parse_toml(f"value = {text}")["value"])
        except TomlContentError as error:
            raise ValueError(
                f"--set {pair}: the value must be a number, a list like [1, 2] or a quoted text"
            ) from error
    return found


def _finite(pair: str, value: object) -> object:
    """Return the value. Raises ValueError if the value is, or contains, a number that is not
    finite."""
    values = value if isinstance(value, list) else [value]
    if any(isinstance(item, float) and not math.isfinite(item) for item in values):
        raise ValueError(f"--set {pair}: expected finite numbers")
    return value
