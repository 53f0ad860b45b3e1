"""Runs the commands that a page of the documents shows, and compares their output with the page.

A ``console`` block contains commands after ``$`` and lines of their output; ``…`` replaces omitted
lines. A block with ``title="FILE"`` contains a file to write.
"""

from __future__ import annotations

import re
import shlex
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

from click.testing import CliRunner

from arctrue.cli import _loaded_set, main

BLOCK = re.compile(
    r"^```(?P<language>\w+)(?: title=\"(?P<title>[^\"]+)\")?\n(?P<text>.*?)^```$",
    re.MULTILINE | re.DOTALL,
)
NUMBER = re.compile(r"[-+]?\d[\d,]*(?:\.\d+)?(?:e[-+]?\d+)?")
RELATIVE = 0.05
"""Relative difference between two numbers that another processor or library may cause."""
WIDTH = 100


@dataclass
class Command:
    """A command of a page, with the lines of output that the page shows for this command."""

    words: list[str]
    shown: list[str] = field(default_factory=list)


@dataclass(frozen=True)
class FileToWrite:
    """A file that a page shows."""

    name: str
    text: str


def steps(page: Path) -> Iterator[Command | FileToWrite]:
    """Yield the commands and the files of a page in their order."""
    for block in BLOCK.finditer(page.read_text(encoding="utf-8")):
        if block["title"]:
            yield FileToWrite(block["title"], block["text"])
        elif block["language"] == "console":
            yield from _commands(block["text"])


def _commands(text: str) -> list[Command]:
    found: list[Command] = []
    for line in text.splitlines():
        if line.startswith("$ "):
            found.append(Command(shlex.split(line[2:])))
        elif line.strip() and line.strip() != "…":
            found[-1].shown.append(line)
    return found


def run(command: Command) -> str:
    """Run an ``arctrue`` command in this process, check that it succeeds, and return the command's
    output."""
    assert command.words[0] == "arctrue"
    _loaded_set.console.width = WIDTH
    result = CliRunner().invoke(main, command.words[1:], catch_exceptions=False)
    assert result.exit_code == 0, f"{command.words}\n{result.output}"
    # The page shows paths relative to the folder in which its reader works.
    return result.output.replace(f"{Path.cwd()}/", "")


def assert_shown(command: Command, output: str) -> None:
    """Assert that the output contains every line of the page, in the order of the page and with
    equal figures."""
    lines = iter(output.splitlines())
    for wanted in command.shown:
        passed: list[str] = []
        for line in lines:
            if same(wanted, line):
                break
            passed.append(line)
        else:
            raise AssertionError(
                f"{shlex.join(command.words)}\nnot in the output: {wanted}\namong:\n"
                + "\n".join(passed)
            )


def same(wanted: str, line: str) -> bool:
    """Tell whether two lines have equal words and nearly equal numbers.

    Numbers may differ by RELATIVE, or by 1.5 units of the last decimal if that is more; two values
    of p below 1e-6 are equal.
    """
    words = [" ".join(NUMBER.sub("#", text).split()) for text in (wanted, line)]
    if words[0] != words[1]:
        return False
    pairs = zip(NUMBER.findall(wanted), NUMBER.findall(line), strict=True)
    return all(_near(_value(a), _value(b), a) for a, b in pairs)


def _value(text: str) -> float:
    return float(text.replace(",", ""))


def _near(wanted: float, found: float, text: str) -> bool:
    if "e-" in text or wanted == 0.0:
        return abs(found) < 1e-6 if wanted < 1e-6 else abs(found - wanted) <= RELATIVE * wanted
    decimals = len(text.partition(".")[2])
    return abs(found - wanted) <= max(
        RELATIVE * abs(wanted), 1.5 * 10.0**-decimals * (decimals > 0)
    )
