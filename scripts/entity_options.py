"""Adds and reads the command-line options that name an entity of the gateware and the values of its
generics."""

from __future__ import annotations

import argparse
import re


def add_entity_options(parser: argparse.ArgumentParser, default: str) -> None:
    """Add the options ``--entity`` and ``--generic``; ``default`` is the entity without
    ``--entity``."""
    parser.add_argument("--entity", default=default, help=f"entity that is mapped ({default})")
    parser.add_argument(
        "-g",
        "--generic",
        action="append",
        default=[],
        metavar="NAME=VALUE",
        help="value of a generic: a number, a word, true or false; may be repeated",
    )


def generics_of(
    parser: argparse.ArgumentParser, chosen: argparse.Namespace
) -> dict[str, int | str]:
    """Return the values of the generics by name in upper case.

    Ends the program for a text that is not NAME=VALUE.
    """
    found: dict[str, int | str] = {}
    for entry in chosen.generic:
        name, _, value = entry.partition("=")
        if not re.fullmatch(r"\w+", name) or not re.fullmatch(r"-?\d+|[A-Za-z]\w*", value):
            parser.error(f"a generic is NAME=VALUE, found {entry}")
        if value in {"true", "false"}:
            found[name.upper()] = value == "true"
        else:
            found[name.upper()] = value if value[0].isalpha() else int(value)
    return found
