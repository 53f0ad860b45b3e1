"""Tests that control sequences from files are printed as text, so that the terminal does not obey
them."""

from __future__ import annotations

import ast
import io
import os
import subprocess
import sys
from pathlib import Path

import pytest
from click.testing import CliRunner, Result
from hypothesis import given
from hypothesis import strategies as st
from rich.table import Table
from sim.tests.workbench.small_sets import measurement_set

import arctrue.cli
from arctrue.base.printable import harmless, is_printable, one_line
from arctrue.cli import main
from arctrue.cli._terminal import Console
from arctrue.measurement import write_measurement_set
from arctrue.report.charts.chart import Axis, Chart, Panel
from arctrue.report.charts.matplotlib_chart import save_chart

CLEAR = "\x1b[2J"
"""Sequence that clears the terminal."""
NASTY = (CLEAR, "\x9b2J", "\x07", "\b\b", "\r", "\u202e", "\x1b]0;title\x07", "\u2028", "\x00")
FOLDER = Path(arctrue.cli.__path__[0])


def arctrue_(*words: str | Path) -> Result:
    return CliRunner().invoke(main, [str(word) for word in words], color=True)


def assert_harmless(done: Result, *, shown: str = "\\x1b") -> None:
    assert not isinstance(done.exception, Exception), done.exception
    text = done.output
    assert all(is_printable(line.replace("\t", "")) for line in text.split("\n")), repr(text)
    assert shown in text


@pytest.mark.parametrize(
    "words",
    [pytest.param(("effects",), marks=pytest.mark.large), ("effects", "show", "hysteresis")],
)
def test_a_reader_that_closes_the_pipe_ends_the_command_quietly(words: tuple[str, ...]) -> None:
    """The exit code is the one that a shell reports for SIGPIPE, 128 + 13."""
    read, write = os.pipe()
    os.close(read)
    command = [sys.executable, "-c", "from arctrue.cli import main; main()", *words]
    with os.fdopen(write, "w") as closed:
        done = subprocess.run(command, stdout=closed, stderr=subprocess.PIPE, text=True)
    assert (done.returncode, done.stderr) == (141, "")


@given(text=st.text())
def test_no_character_is_left_that_a_terminal_obeys(text: str) -> None:
    assert is_printable(one_line(text))
    assert harmless("".join(c for c in text if is_printable(c))) == "".join(
        c for c in text if is_printable(c)
    )


@pytest.mark.parametrize("nasty", NASTY)
def test_tables_and_lines_of_the_console_are_harmless(nasty: str) -> None:
    console = Console(width=100)
    console.file = io.StringIO()
    table = Table(title=f"title {nasty}")
    table.add_column(f"name {nasty}")
    table.add_row(f"cell {nasty} [bold]x[/nothing]")
    console.print(table)
    console.print(f"line {nasty}", style="bold")
    shown = console.file.getvalue()
    # rich itself removes some control characters, and turns a separator into a line break.
    assert all(map(is_printable, shown.split("\n"))), repr(shown)
    assert "[/nothing]" in shown, "brackets in the content are not markup"


def test_every_command_prints_through_the_one_module() -> None:
    for path in sorted(FOLDER.glob("*.py")):
        if path.name == "_terminal.py":
            continue
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.ImportFrom):
                assert node.module != "rich.console", path.name
            if isinstance(node, ast.Call):
                called = ast.unparse(node.func)
                assert called not in ("print", "click.echo", "click.secho", "sys.stdout.write"), (
                    f"{path.name}, line {node.lineno}: use say or console.print"
                )


@pytest.fixture
def small(tmp_path: Path) -> Path:
    write_measurement_set(tmp_path / "set", measurement_set(cycles=1, turns=1))
    return tmp_path / "set"


def _replaced(path: Path, old: str, new: str) -> None:
    text = path.read_text(encoding="utf-8")
    assert old in text
    path.write_text(text.replace(old, new, 1), encoding="utf-8")


@pytest.mark.parametrize("command", ["calibrate", "diagnose", "compare", "export"])
def test_a_title_with_an_escape_is_refused_and_shown(small: Path, command: str) -> None:
    _replaced(small / "measurement.toml", '"small set"', '"x\\u001b[2Jy"')
    done = arctrue_(command, small)
    assert done.exit_code == 2
    assert_harmless(done)


def test_a_title_of_two_lines_cannot_pretend_a_verdict(small: Path) -> None:
    _replaced(small / "measurement.toml", '"small set"', '"x\\nVerdict: adequate"')
    done = arctrue_("diagnose", small)
    assert done.exit_code == 2
    assert "\nVerdict" not in done.output


@pytest.mark.parametrize("command", ["calibrate", pytest.param("compare", marks=pytest.mark.large)])
def test_unknown_keys_and_columns_are_warned_of_harmlessly(
    small: Path, command: str, tmp_path: Path
) -> None:
    _replaced(small / "measurement.toml", "[table]", '[table]\n"a\\u001b[2J\\nVerdict: b" = 1')
    lines = (small / "capture.csv").read_text().splitlines()
    (small / "capture.csv").write_text(
        "\n".join([lines[0] + f",x{CLEAR}", *(line + ",text" for line in lines[1:])]) + "\n"
    )
    done = arctrue_(command, small, "--out", tmp_path / "out")
    assert done.exit_code == 0, done.output
    assert_harmless(done)
    assert "\nVerdict" not in done.output
    assert "x\\x1b[2J" in done.output


def test_a_field_with_an_escape_is_named_harmlessly(small: Path) -> None:
    text = (small / "capture.csv").read_text().splitlines()
    (small / "capture.csv").write_text("\n".join([*text[:3], f"0,{CLEAR},1,1,20", *text[3:]]))
    for command in ("calibrate", "diagnose"):
        done = arctrue_(command, small)
        assert done.exit_code in (2, 3)
        assert_harmless(done)


@pytest.mark.parametrize(
    "text",
    [
        'schema = 1\n[[effect]]\nname = "a\\u001b[2J"\n',
        'schema = 1\n"\\u001b[2J" = 1\n[[effect]]\nname = "hysteresis"\n',
        'schema = 1\n[[effect]]\nname = "hysteresis"\n[effect.settings]\n"\\u001b[2J" = 1\n',
        f'schema = 1\n[[effect]]\nname = "{CLEAR}"\n',
        'schema = "\\u001b[2J"\n',
    ],
)
def test_a_model_with_an_escape_is_refused_harmlessly(tmp_path: Path, text: str) -> None:
    model = tmp_path / "m.toml"
    model.write_text(text)
    done = arctrue_("history", "--model", model)
    assert done.exit_code == 2
    assert_harmless(done)


def test_file_names_and_what_own_effects_say_are_shown_harmlessly(tmp_path: Path) -> None:
    done = arctrue_("diagnose", tmp_path / f"set{CLEAR}")
    assert done.exit_code == 2
    assert_harmless(done)
    done = arctrue_("calibrate", tmp_path, "--json", tmp_path)
    assert done.exit_code == 2
    done = arctrue_("diagnose", tmp_path, "--matters", f"1{CLEAR}")
    assert done.exit_code == 2
    assert_harmless(done)
    effects = tmp_path / "effects"
    effects.mkdir()
    (effects / "bad.py").write_text(f"raise ValueError('oh {CLEAR}')\n")
    done = arctrue_("effects", "--effects", effects)
    assert done.exit_code == 2
    assert_harmless(done)


def test_a_scenario_with_an_escape_is_refused_harmlessly(tmp_path: Path) -> None:
    path = tmp_path / "s.toml"
    path.write_text('format = "\\u001b[2J"\n')
    done = arctrue_("run", path)
    assert done.exit_code == 2
    assert_harmless(done)


def test_a_title_with_mathematics_is_drawn_as_it_is(small: Path, tmp_path: Path) -> None:
    _replaced(small / "measurement.toml", '"small set"', r"'table $\nosuch{$ 7'")
    done = arctrue_("calibrate", small, "--out", tmp_path / "out")
    assert done.exit_code == 0, done.output
    assert (tmp_path / "out" / "calibration.png").exists()


def test_no_figure_reads_mathematics(tmp_path: Path) -> None:
    panel = Panel(Axis("x"), Axis("y"), [], r"table $\nosuch{$ 7")
    path = save_chart(Chart("title", "", [panel]), tmp_path / "x.png")
    assert path.stat().st_size > 0
