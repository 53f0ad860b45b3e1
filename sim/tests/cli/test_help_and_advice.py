"""Tests that every command has help, completion, advice for a wrong name, and the same error
format."""

from __future__ import annotations

import ast
import os
from pathlib import Path

import click
import pytest
from click.testing import CliRunner, Result
from hypothesis import given
from hypothesis import strategies as st
from sim.tests.workbench.small_sets import measurement_set

import arctrue.cli
from arctrue.base.similar import did_you_mean, similar
from arctrue.cli import main
from arctrue.measurement import write_measurement_set
from arctrue.studies.heads.cases import HEADS_CASES
from arctrue.workbench.effects.registry import ORDER

FOLDER = Path(arctrue.cli.__path__[0])


def arctrue_(*words: str | Path) -> Result:
    return CliRunner().invoke(main, [str(word) for word in words], prog_name="arctrue")


def every_command(
    command: click.Command = main, words: tuple[str, ...] = ()
) -> dict[tuple[str, ...], click.Command]:
    """Return each command and group, keyed by the words that call it."""
    found = {words: command}
    if isinstance(command, click.Group):
        context = click.Context(command)
        for name in command.list_commands(context):
            below = command.get_command(context, name)
            assert below is not None, name
            found |= every_command(below, (*words, name))
    return found


COMMANDS = every_command()


def test_the_commands_are_found() -> None:
    assert len(COMMANDS) > 30
    assert {("effects", "show"), ("benchmark", "run"), ("import",)} <= set(COMMANDS)


def test_the_help_lists_every_command_once_under_its_section() -> None:
    listed: dict[str, list[str]] = {}
    for line in arctrue_("--help").output.partition("\nOptions:\n")[2].splitlines():
        if line.endswith(":"):
            names = listed.setdefault(line.removesuffix(":"), [])
        elif line.startswith("  ") and line[2].isalpha():
            names.append(line.split()[0])
    assert list(listed) == ["Your own data", "Device", "Simulate and study"]
    of_files = {
        path.stem.rstrip("_").replace("_", "-")
        for path in FOLDER.glob("*.py")
        if not path.name.startswith("_")
    }
    assert sorted(name for names in listed.values() for name in names) == sorted(of_files)
    assert {"import", "calibrate", "diagnose", "export"} <= set(listed["Your own data"])
    assert {"capture", "flash"} <= set(listed["Device"])
    assert {"demo", "simulate", "benchmark"} <= set(listed["Simulate and study"])


@pytest.mark.parametrize("words", COMMANDS, ids=" ".join)
def test_help_is_there_in_short_and_fits_80_columns(words: tuple[str, ...]) -> None:
    short, long = arctrue_(*words, "-h"), arctrue_(*words, "--help")
    assert short.exit_code == 0, short.output
    assert short.output == long.output
    assert short.output.startswith(" ".join(("Usage: arctrue", *words)))
    assert max(map(len, short.output.splitlines())) <= 80
    assert "=None" not in short.output, "a number without limits has no range"


@pytest.mark.parametrize("words", COMMANDS, ids=" ".join)
def test_every_option_says_what_it_is(words: tuple[str, ...]) -> None:
    """The help of each option must state what the option sets; ``Of the draws.`` does not."""
    for option in COMMANDS[words].params:
        if isinstance(option, click.Option):
            said = option.help or ""
            assert said, option.opts
            assert not said.startswith(("Of ", "In ")), option.opts


WRONG = {
    ("diganose", "set"): "Did you mean diagnose?",
    ("iso",): "Did you mean iso230",
    ("effects", "shwo"): "Did you mean show?",
    ("compare", "set", "--modle", "m"): "Did you mean --model?",
    ("effects", "show", "hysterisis"): "Did you mean hysteresis?",
    ("effects", "show", "eccentricity"): "Did you mean thermal_eccentricity or polygon_ecc",
    ("simulate", "set", "--effect", "thermal_excentricity"): "Did you mean thermal_eccentricity",
    ("simulate", "set", "--noise", "pnik"): "Did you mean pink?",
}


@pytest.mark.parametrize(("words", "advice"), WRONG.items(), ids=lambda item: str(item)[:40])
def test_a_wrong_name_is_answered_with_the_right_one(
    words: tuple[str, ...], advice: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    done = arctrue_(*words)
    assert done.exit_code == 2
    assert done.stdout == ""
    assert done.stderr.startswith("error: ")
    assert advice in " ".join(done.stderr.replace("'", "").split())


def test_a_wrong_effect_of_a_model_is_answered_too(tmp_path: Path) -> None:
    write_measurement_set(tmp_path / "set", measurement_set(cycles=1, turns=1))
    for command in ("add", "drop"):
        done = arctrue_(command, "hysterisis", tmp_path / "set")
        assert done.exit_code == 2
        assert done.stderr.startswith("error: "), done.stderr


def test_a_name_like_no_other_gets_no_advice() -> None:
    done = arctrue_("qqqqq")
    assert done.exit_code == 2
    assert done.stderr.splitlines()[0] == "error: No such command 'qqqqq'."
    assert done.stderr.splitlines()[-1] == "help: arctrue -h"


@given(st.sampled_from(ORDER), st.integers(0, 4), st.sampled_from("xq_"))
def test_a_name_with_one_letter_wrong_is_meant(name: str, place: int, letter: str) -> None:
    wrong = f"{name[:place]}{letter}{name[place + 1 :]}"
    assert name in similar(wrong, ORDER)
    assert name in did_you_mean(wrong.upper(), ORDER)


def test_errors_are_reported_through_one_function() -> None:
    """Every command reports errors through one function; none writes to stderr directly."""
    for path in sorted(FOLDER.glob("*.py")):
        if path.name == "_terminal.py":
            continue
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if not isinstance(node, ast.Call):
                continue
            place = f"{path.name}, line {node.lineno}"
            called = ast.unparse(node.func)
            given_ = {word.arg for word in node.keywords}
            if called not in ("click.prompt", "click.confirm"):
                assert "err" not in given_, f"{place}: use note, tell_warning or tell_error"
            texts = (ast.Constant, ast.JoinedStr)
            if called in ("note", "say", "console.print") and isinstance(
                node.args[0] if node.args else None, texts
            ):
                first = ast.unparse(node.args[0]).lstrip("f'\"")
                assert not first.startswith(("error", "warning")), f"{place}: use tell_…"


def test_ctrl_c_is_reported_with_the_exit_code_of_a_shell(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def stop(*_: object, **__: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("arctrue.cli.history.read_model", stop)
    done = arctrue_("history", "--model", "m.toml")
    assert done.exit_code == 130
    assert done.stderr.strip() == "error: interrupted"


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish"])
def test_completion_of_the_documented_shells(shell: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("_ARCTRUE_COMPLETE", f"{shell}_source")
    if shell == "bash":
        monkeypatch.setattr(
            "click.shell_completion.BashComplete._check_version", staticmethod(lambda: None)
        )
    script = arctrue_()
    assert script.exit_code == 0, script.output
    assert "_ARCTRUE_COMPLETE" in script.output


@pytest.mark.parametrize(
    ("typed", "expected"),
    [
        ("arctrue dia", {"diagnose"}),
        ("arctrue effects show thermal_", {"thermal_head_drift", "thermal_eccentricity"}),
        ("arctrue add hyst", {"hysteresis"}),
        ("arctrue compare --no-", {"--no-fit"}),
        ("arctrue calibrate --method f", {"fourier"}),
    ],
)
def test_what_completion_offers(
    typed: str, expected: set[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    words = typed.split()
    monkeypatch.setenv("_ARCTRUE_COMPLETE", "bash_complete")
    monkeypatch.setenv("COMP_WORDS", typed)
    monkeypatch.setenv("COMP_CWORD", str(len(words) - 1))
    done = arctrue_()
    offered = {line.partition(",")[2] for line in done.output.splitlines()}
    assert offered == expected
    assert os.environ["_ARCTRUE_COMPLETE"]


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ("alpha --heads 3 --alpha 40", "--alpha is for two heads"),
        ("hidden belt --heads 4 --picture a.svg", "--picture is for --heads 2"),
        ("hidden belt --heads 4 --follow", "--follow is for --heads 2"),
        ("hidden belt --heads 4 --out folder", "--out is for --heads 2"),
    ],
)
def test_an_option_that_would_change_nothing_is_refused(words: str, said: str) -> None:
    named = words.replace("belt", next(iter(HEADS_CASES)))
    done = arctrue_(*named.split())
    assert done.exit_code == 2, done.output
    assert said in done.output
