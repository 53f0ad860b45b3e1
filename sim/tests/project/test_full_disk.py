"""Tests that a write to a full disk names the file, keeps the old file, and leaves no partial
file."""

from __future__ import annotations

import ast
import errno
import json
import os
import resource
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from sim.tests.workbench.small_sets import measurement_set

import arctrue
from arctrue.base.whole_file import whole_file, write_whole_text
from arctrue.cli import main
from arctrue.cli._loaded_set import write_json
from arctrue.gateware.coefficient_file import write_coefficient_file
from arctrue.gateware.coefficients import Coefficients
from arctrue.measurement import write_measurement_set
from arctrue.report.charts.chart import Axis, Chart, Panel
from arctrue.report.charts.matplotlib_chart import save_chart
from arctrue.studies.simulate.truth import write_truth
from arctrue.table.pins import PinEvents
from arctrue.workbench.effects.new_effect import write_new_effect
from arctrue.workbench.model.model import Model, ModelEffect
from arctrue.workbench.model.model_file import write_model

ROOM_BYTES = 64
"""Largest size of a file on the full disk, in bytes; every file of these writers is longer."""


@contextmanager
def full_disk() -> Iterator[None]:
    """Let no file grow beyond ROOM_BYTES. The operating system enforces the limit, so that it
    applies to all libraries."""
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (ROOM_BYTES, hard))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))


def _chart() -> Chart:
    return Chart("axes", "Empty axes.", [Panel(Axis("x"), Axis("y"), [])])


def _pins() -> PinEvents:
    return PinEvents(0, np.arange(1, 100, dtype=np.int64), np.zeros(99, dtype=np.uint8))


WRITERS: dict[str, Callable[[Path], object]] = {
    "model.toml": lambda path: write_model(path, Model([ModelEffect("x" * 80)])),
    "coefficients.toml": lambda path: write_coefficient_file(
        path, Coefficients.from_harmonics([1], [100.0], [0.5], 1 << 24, lanes=4)
    ),
    "figures.json": lambda path: write_json(path, {"values": list(range(100))}),
    "text": lambda path: write_whole_text(path, "x" * 100),
    "picture.png": lambda path: save_chart(_chart(), path),
    "own.py": lambda path: write_new_effect(path.stem, path.parent),
    "pins.txt": lambda path: _pins().write(path),
}


@pytest.mark.parametrize("name", WRITERS)
def test_a_full_disk_names_the_file_and_leaves_nothing(tmp_path: Path, name: str) -> None:
    path = tmp_path / name
    with full_disk(), pytest.raises(OSError, match="File too large") as caught:
        WRITERS[name](path)
    assert caught.value.filename == str(path)
    assert caught.value.errno == errno.EFBIG
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("name", [name for name in WRITERS if name != "own.py"])
def test_a_full_disk_keeps_the_file_that_is_there(tmp_path: Path, name: str) -> None:
    path = tmp_path / name
    path.write_text("before")
    with full_disk(), pytest.raises(OSError, match="File too large"):
        WRITERS[name](path)
    assert path.read_text() == "before"
    assert list(tmp_path.iterdir()) == [path]
    WRITERS[name](path)
    assert path.stat().st_size > ROOM_BYTES
    assert list(tmp_path.iterdir()) == [path]


def test_a_set_is_written_whole_or_not_at_all(tmp_path: Path) -> None:
    with full_disk(), pytest.raises(OSError, match="File too large") as caught:
        write_measurement_set(tmp_path, measurement_set(turns=1, cycles=1))
    assert Path(caught.value.filename).parent == tmp_path
    assert list(tmp_path.iterdir()) == []


def test_an_effect_and_its_test_are_written_together(tmp_path: Path) -> None:
    def no_room_for_the_second(path: Path, text: str) -> int:
        if path.name.startswith(".test_"):
            raise OSError(errno.ENOSPC, "No space left on device")
        return len(text)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(
            Path, "write_text", lambda path, text, **_: no_room_for_the_second(path, text)
        )
        with pytest.raises(OSError, match="No space left") as caught:
            write_new_effect("own", tmp_path)
    assert caught.value.filename == str(tmp_path / "test_own.py")
    assert list(tmp_path.iterdir()) == []


def test_a_truth_is_sealed_whole_or_not_at_all(tmp_path: Path) -> None:
    (tmp_path / "set").mkdir()
    with full_disk(), pytest.raises(OSError, match="File too large"):
        write_truth(tmp_path / "set", {"effects": ["x"] * 50})
    assert list(tmp_path.iterdir()) == [tmp_path / "set"]
    sealed = write_truth(tmp_path / "set", {"effects": ["y"]})
    before = sealed.read_bytes()
    with full_disk(), pytest.raises(OSError, match="File too large"):
        write_truth(tmp_path / "set", {"effects": ["x"] * 50})
    assert sealed.read_bytes() == before


@pytest.mark.parametrize("command", ["add", "export", "calibrate", "compare"])
def test_the_commands_say_which_file(tmp_path: Path, command: str) -> None:
    write_measurement_set(tmp_path / "set", measurement_set(turns=1, cycles=2))
    out, model = tmp_path / "out", tmp_path / "model.toml"
    words = {
        "add": ["add", "hysteresis", tmp_path / "set", "--model", model],
        "export": ["export", tmp_path / "set", "--coefficients", out / "c.toml"],
        "calibrate": ["calibrate", tmp_path / "set", "--out", out],
        "compare": ["compare", tmp_path / "set", "--json", out / "c.json"],
    }[command]
    with full_disk():
        done = CliRunner().invoke(main, list(map(str, words)))
    assert done.exit_code == 2, done.output
    named = {"add": model, "calibrate": out / "coefficients.toml"}.get(command, out / "c.")
    assert str(named) in done.output.replace("\n", "")
    assert "File too large" in done.output
    assert not model.exists()
    assert not out.exists() or list(out.iterdir()) == []


def test_modes_and_links_are_kept(tmp_path: Path) -> None:
    target, link = tmp_path / "target.json", tmp_path / "link.json"
    target.write_text("before")
    target.chmod(0o640)
    link.symlink_to(target)
    write_whole_text(link, "after")
    assert (target.read_text(), link.is_symlink()) == ("after", True)
    assert target.stat().st_mode & 0o777 == 0o640
    mask = os.umask(0o027)
    try:
        write_whole_text(tmp_path / "new", "x")
    finally:
        os.umask(mask)
    assert (tmp_path / "new").stat().st_mode & 0o777 == 0o640


def test_an_interruption_leaves_nothing(tmp_path: Path) -> None:
    def interrupted() -> None:
        with whole_file(tmp_path / "x") as unfinished:
            unfinished.write_text("half")
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        interrupted()
    assert list(tmp_path.iterdir()) == []


APPENDED = {
    "instrument/build.py",
    "base/netlist.py",
    "studies/demo/run.py",
    "studies/campaign/store.py",
}
"""Files that grow while a program runs: logs of other programs, the lock of a build, and results
that are written line by line."""


def test_every_writer_of_the_package_writes_whole_files() -> None:
    package = Path(arctrue.__path__[0])
    for path in sorted(package.rglob("*.py")):
        name = path.relative_to(package).as_posix()
        if name.startswith("generated/") or name in APPENDED or name == "base/whole_file.py":
            continue
        text = path.read_text(encoding="utf-8")
        for node in ast.walk(ast.parse(text)):
            if not isinstance(node, ast.Call) or not isinstance(node.func, ast.Attribute):
                continue
            modes = [item.value for item in node.args if isinstance(item, ast.Constant)]
            writes = node.func.attr in ("write_text", "write_bytes", "savefig") or (
                node.func.attr == "open" and any(str(mode)[:1] in "wax" for mode in modes if mode)
            )
            if writes and ast.unparse(node.func) == "pdf.savefig":
                continue  # this is a page of a PDF; the PDF itself is written to `unfinished`
            if writes:
                target = ast.unparse(
                    node.args[0] if node.func.attr == "savefig" else node.func.value
                )
                assert target in ("unfinished", "text", "description") or (
                    name == "measurement/writer.py" and target == "path"
                ), f"{name}, line {node.lineno}: write through whole_file"


def test_json_of_commands_is_whole(tmp_path: Path) -> None:
    write_json(tmp_path / "deep" / "x.json", {"x": np.arange(3)})
    assert json.loads((tmp_path / "deep" / "x.json").read_text()) == {"x": [0, 1, 2]}
