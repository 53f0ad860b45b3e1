"""TOML of other people, read within limits."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any

from arctrue.base.printable import one_line

DEEPEST = 32
"""Levels of tables and arrays; the files of this project have four."""


class TomlContentError(ValueError):
    """Text that is not TOML, or is nested too deeply; the message is one line without a file."""


def read_toml(path: Path) -> dict[str, Any]:
    """The content of a TOML file in UTF-8, with or without a byte order mark.

    Raises OSError where it cannot be read, TomlContentError for its content.
    """
    try:
        text = path.read_text(encoding="utf-8-sig")
    except UnicodeDecodeError as error:
        raise TomlContentError(f"is not text in UTF-8: {error}") from error
    return parse_toml(text)


def parse_toml(text: str) -> dict[str, Any]:
    """The content of TOML text. Raises TomlContentError."""
    try:
        content = tomllib.loads(text)
    except RecursionError as error:
        raise TomlContentError(f"is nested more than {DEEPEST} levels deep") from error
    except ValueError as error:  # TOMLDecodeError, and a number of thousands of digits
        raise TomlContentError(f"is not TOML: {one_line(str(error))}") from error
    _refuse_deep(content)
    return content


def _refuse_deep(content: dict[str, Any]) -> None:
    """Raise TomlContentError for more than DEEPEST levels: dotted keys nest without a limit."""
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
