"""Reads TOML files of unknown origin, and refuses files that are nested too deeply."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any

from arctrue.base.printable import one_line

DEEPEST = 32
"""Greatest depth of tables and arrays; this project's own files have four levels."""


class TomlContentError(ValueError):
    """Text that is not TOML, or is nested too deeply; the message is one line."""


def read_toml(path: Path) -> dict[str, Any]:
    """Read a TOML file in UTF-8, with or without byte order mark.

    Raises OSError if the file cannot be read, TomlContentError for wrong content.
    """
    try:
        text = path.read_text(encoding="utf-8-sig")
    except UnicodeDecodeError as error:
        raise TomlContentError(f"is not text in UTF-8: {error}") from error
    return parse_toml(text)


def parse_toml(text: str) -> dict[str, Any]:
    """Parse TOML text. Raises TomlContentError."""
    try:
        content = tomllib.loads(text)
    except RecursionError as error:
        raise TomlContentError(f"is nested more than {DEEPEST} levels deep") from error
    except ValueError as error:  # TOMLDecodeError, or a number with thousands of digits
        raise TomlContentError(f"is not TOML: {one_line(str(error))}") from error
    _refuse_deep(content)
    return content


def _refuse_deep(content: dict[str, Any]) -> None:
    """Raise TomlContentError for more than DEEPEST levels; tomllib does not limit dotted keys."""
    level: list[Any] = [content]
    for _ in range(DEEPEST):
        level = [
            item
            for holder in level
            for item in (holder.values() if isinstance(holder, dict) else holder)
            if isinstance(item, dict | list)
        ]
        if not level:
            return
    raise TomlContentError(f"is nested more than {DEEPEST} levels deep")
