"""Reads the options that name an entity of the gateware and the values of its generics."""

from __future__ import annotations

import argparse


def add_entity_options(parser: argparse.ArgumentParser, default: str) -> None:
    """Add ``--entity`` and ``--generic``; ``default``: the entity that is meant without."""
    parser.add_argument("--entity", default=default, help=f"entity that is mapped ({default})")
    parser.add_argument(
        "-g",
        "--generic",
        action="append",
        default=[],
        metavar="NAME=VALUE",
        help="value of a generic, a whole number, true or false; may be repeated",
    )


def generics_of(parser: argparse.ArgumentParser, chosen: argparse.Namespace) -> dict[str, int]:
    """Value by name, the name in upper case. Ends the program for a text of another form."""
    try:
        return {
            name.upper(): value == "true" if value in {"true", "false"} else int(value)
            for name, _, value in (entry.partition("=") for entry in chosen.generic)
        }
    except ValueError:
        found = " ".join(chosen.generic)
        parser.error(f"a generic is NAME=INTEGER, NAME=true or NAME=false, found {found}")
