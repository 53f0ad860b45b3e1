"""Tests that one screen shows all open questions and the first rows, and that the import accepts a
column's number as an answer."""

from __future__ import annotations

import importlib
import shlex
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner, Result

from arctrue.cli import main
from arctrue.measurement import read_measurement_set


def arctrue(*words: str | Path, said: str = "") -> Result:
    return CliRunner().invoke(
        main, ["import", *map(str, words)], input=said, catch_exceptions=False
    )


@pytest.fixture
def odd_names(tmp_path: Path) -> Path:
    """Write a file whose name contains a space, and whose column names are unknown to the import
    and contain spaces and special characters of the shell."""
    path = tmp_path / "a file.csv"
    rows = "".join(f"{i * 0.1:.1f};{i};{i + 0.01};{i % 3}\n" for i in range(60))
    path.write_text("tick;axis $1;axis 'two';n\n" + rows)
    return path


@pytest.fixture
def terminal(monkeypatch: pytest.MonkeyPatch) -> None:
    """Make the command treat CliRunner's input as input from a terminal."""
    module = importlib.import_module("arctrue.cli.import_")

    class _Stdin:
        @staticmethod
        def isatty() -> bool:
            return True

    class _Sys:
        stdin = _Stdin

    monkeypatch.setattr(module, "sys", _Sys)


def test_a_script_is_reported_every_question_at_once(odd_names: Path, tmp_path: Path) -> None:
    done = arctrue(odd_names, tmp_path / "out")
    assert done.exit_code == 2
    for option in ("--column target=", "--column error=", "--column head1=", "--unit target=deg"):
        assert option in done.output.replace("'", ""), option
    # The output shows the first rows of every file, with the numbers of the columns.
    assert "first rows of a file.csv:" in done.output
    assert "1 tick  2 axis $1  3 axis 'two'  4 n" in " ".join(done.output.split("\n")).replace(
        "   ", "  "
    ).replace("   ", "  ")
    # If the command line answers all questions, the import asks none.
    words = ["--column", "target=2", "--column", "head1=3", "--unit", "target=deg"]
    done = arctrue(odd_names, *words, "--unit", "head1=deg", tmp_path / "out")
    assert done.exit_code == 0, done.output


def test_suggested_options_can_be_pasted_into_a_shell(odd_names: Path, tmp_path: Path) -> None:
    said = arctrue(odd_names, tmp_path / "out").output
    line = next(
        line for line in said.splitlines() if "--column target=" in line or "'target=" in line
    )
    suggested = line.partition("Answer with one of: ")[2].split(", --column ")
    words = [shlex.split(item.removeprefix("--column ")) for item in suggested]
    assert words == [["target=tick"], ["target=axis $1"], ["target=axis 'two'"], ["target=n"],
                     ["target=none"]]  # fmt: skip


@pytest.mark.usefixtures("terminal")
def test_a_number_answers_for_a_column(odd_names: Path, tmp_path: Path) -> None:
    done = arctrue(odd_names, tmp_path / "out", said="2\ndeg\nnone\n3\ndeg\n")
    assert done.exit_code == 0, done.output
    assert "first rows of a file.csv:" in done.output
    assert "open: --column target, --unit target, --column error, --column head1" in done.output
    found = read_measurement_set(tmp_path / "out")
    assert found.reference is not None
    assert found.reference.target_deg[7] == 7.0
    assert found.reference.error_arcsec[7] == pytest.approx(36.0, abs=1e-3)
    assert found.origin.command is not None
    # The import records the name of the column, because the name says more than the number.
    assert "target=axis $1" in shlex.split(found.origin.command)


@pytest.mark.usefixtures("terminal")
def test_a_number_with_the_file_answers_for_a_column(odd_names: Path, tmp_path: Path) -> None:
    second = tmp_path / "b.csv"
    second.write_text(odd_names.read_text())
    done = arctrue(odd_names, second, tmp_path / "out", said="9:9\n1:2\ndeg\nnone\n1:3\ndeg\n")
    assert "1:2" in done.output
    assert "'9:9' is not one of" in done.output


def test_a_question_of_the_reader_shows_the_first_lines(tmp_path: Path) -> None:
    path = tmp_path / "a.txt"
    path.write_text("1,250 2,250\n1,500 2,500\n")
    done = arctrue(path, tmp_path / "out")
    assert done.exit_code == 2
    assert "--decimal point, --decimal comma" in done.output
    assert "1,250 2,250" in done.output
    assert "--column target=1" in done.output, "the import asks the next questions at once"


def test_a_file_with_too_few_columns_is_a_sentence(tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_text("target_deg\n" + "".join(f"{i}\n" for i in range(60)))
    done = arctrue(tmp_path / "a.csv", "--column", "error=none", tmp_path / "out")
    assert done.exit_code == 2
    assert "no remaining column could be the reading of the encoder" in done.output
    done = arctrue(tmp_path / "a.csv", tmp_path / "out")
    assert done.exit_code == 2
    assert "first rows of a.csv" in done.output


def halsampler(folder: Path) -> tuple[str | Path, ...]:
    path = folder / "samples.txt"
    path.write_text("".join(f"{n} {0.36 * n:.4f} {0.36 * n:.4f}\n" for n in range(60)))
    return (path, "--format", "linuxcnc")


def two_logs(folder: Path) -> tuple[str | Path, ...]:
    time_s = np.arange(0.0, 20.0, 0.01)
    np.savez(folder / "enc.npz", time_s=time_s, head1_turns=0.1 * time_s)
    np.savez(folder / "ref.npz", time_s=time_s, target_turns=0.1 * time_s)
    return (folder / "enc.npz", folder / "ref.npz")


def heads(number: int) -> Callable[[Path], tuple[str | Path, ...]]:
    def written(folder: Path) -> tuple[str | Path, ...]:
        names = ",".join(f"head{head}_counts" for head in range(1, number + 1))
        rows = "".join(",".join([f"{n / 10}", *[str(n)] * number]) + "\n" for n in range(60))
        (folder / "heads.csv").write_text(f"time_s,{names}\n{rows}")
        return (folder / "heads.csv",)

    return written


def timed_errors(folder: Path) -> tuple[str | Path, ...]:
    (folder / "guide.csv").write_text(
        "time_s,error_arcsec\n" + "".join(f"{n},{n % 7}\n" for n in range(60))
    )
    return (folder / "guide.csv",)


@pytest.mark.usefixtures("terminal")
@pytest.mark.parametrize(
    ("files", "option", "expected", "answers"),
    [
        (halsampler, "--period", "seconds above 0", ["abc", "0", "-1", "nan", "inf"]),
        (two_logs, "--clock-offset", "seconds", ["abc", "nan", "inf"]),
        (heads(2), "--counts-per-rev", "a whole number from 4", ["abc", "1.5", "0", "-4"]),
        (heads(2), "--separation", "degrees between -360 and 360", ["abc", "nan", "360"]),
        (heads(3), "--places", "", ["abc", "0,nan,90", "0,33", "10,20,30"]),
        (timed_errors, "--rate", "degrees per second", ["abc", "nan", "0"]),
    ],
)
def test_a_typed_number_is_checked_like_its_option(
    files: Callable[[Path], tuple[str | Path, ...]],
    option: str,
    expected: str,
    answers: list[str],
    tmp_path: Path,
) -> None:
    """The message names the option, and nothing is written."""
    words = files(tmp_path)
    before = [] if option == "--counts-per-rev" else ["--counts-per-rev", "4096"]
    for answer in answers:
        done = arctrue(*words, *before, tmp_path / "out", said=f"{answer}\n")
        said = " ".join(done.output.split())
        assert done.exit_code == 2, (answer, said)
        assert f"{option}: expected {expected}" in said.partition("open: ")[2], answer
        assert not (tmp_path / "out").exists()
