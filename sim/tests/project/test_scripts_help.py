"""Tests that ``python -m MODULE --help`` describes every option of a module and does nothing
else."""

from __future__ import annotations

import argparse
import importlib
import os
import sys
from pathlib import Path
from typing import Any

import click
import pytest

SCRIPTS = Path(__file__).resolve().parents[3] / "scripts"
CALLABLE = [
    *sorted(
        f"scripts.{path.stem}"
        for path in SCRIPTS.glob("*.py")
        if "__main__" in path.read_text(encoding="utf-8")
    ),
    "arctrue.instrument.__main__",
    "arctrue.report.cordic_error",
    "arctrue.studies.scenario.__main__",
]
WRITING = os.O_WRONLY | os.O_RDWR | os.O_CREAT
CHANGES = {"os.mkdir", "os.remove", "os.rename", "os.rmdir", "subprocess.Popen"}


class Watch:
    """An audit hook that records which files are changed and which programs are started."""

    def __init__(self) -> None:
        self.on = False
        self.seen: list[str] = []
        sys.addaudithook(self._note)

    def _note(self, event: str, details: tuple[Any, ...]) -> None:
        if self.on and (event in CHANGES or (event == "open" and details[2] & WRITING)):
            self.seen.append(f"{event}: {details[0]}")


@pytest.fixture(scope="module")
def watch() -> Watch:
    """Return the one Watch that all tests share, because an audit hook cannot be removed."""
    return Watch()


def test_the_watch_sees_a_file_that_is_written(watch: Watch, tmp_path: Path) -> None:
    watch.seen.clear()
    watch.on = True
    (tmp_path / "file").write_text("x")
    watch.on = False
    assert watch.seen == [f"open: {tmp_path / 'file'}"]


@pytest.mark.parametrize("name", CALLABLE)
def test_help_is_printed_and_nothing_is_done(
    name: str,
    watch: Watch,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    parsers: list[argparse.ArgumentParser] = []
    print_help = argparse.ArgumentParser.print_help

    def noted(parser: argparse.ArgumentParser, file: Any = None) -> None:
        parsers.append(parser)
        print_help(parser, file)

    main = importlib.import_module(name).main
    monkeypatch.setattr(argparse.ArgumentParser, "print_help", noted)
    watch.seen.clear()
    watch.on = True
    try:
        with pytest.raises(SystemExit) as ended:
            main(["--help"])
    finally:
        watch.on = False
    assert ended.value.code == 0
    said = capsys.readouterr().out
    assert said.lower().startswith("usage: ")
    assert "--help" in said
    assert watch.seen == []
    if isinstance(main, click.Command):
        options = {item.name: item.help for item in main.params if isinstance(item, click.Option)}
    else:
        options = {action.dest: action.help for action in parsers[0]._actions}
    assert [option for option, described in options.items() if not described] == []
