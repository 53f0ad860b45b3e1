"""Settings of an effect on the command line: --set KEY=VALUE."""

from __future__ import annotations

import tomllib
from collections.abc import Iterable


def settings_from(pairs: Iterable[str]) -> dict[str, object]:
    """KEY=VALUE pairs as settings; a value is written as in TOML.

    Raises ValueError naming the pair that is not of this form.
    """
    found: dict[str, object] = {}
    for pair in pairs:
        key, separator, text = pair.partition("=")
        if not separator or not key.strip():
            raise ValueError(f"--set {pair}: expected KEY=VALUE")
        try:
            found[key.strip()] = tomllib.loads(f"value = {text}")["value"]
        except tomllib.TOMLDecodeError as error:
            raise ValueError(
                f"--set {pair}: the value must be a number, a list like [1, 2] or a quoted text"
            ) from error
    return found
