"""Tests that the build names missing tools, and that it builds no part twice."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest
from sim.tests.instrument.sizes import DEPTH, LANES

from arctrue.base.source_tree import ROOT
from arctrue.instrument import InstrumentError, build
from arctrue.instrument.build import building, compile_all, digest


def test_missing_tools_are_named_at_once(tmp_path: Path) -> None:
    """With an empty PATH, one message without a traceback names all missing tools."""
    done = subprocess.run(
        [sys.executable, "-m", "arctrue.instrument", "--lanes", "3"],
        cwd=ROOT,
        env={"PATH": str(tmp_path), "GHDL_NETLIST": str(tmp_path / "ghdl"), "PYTHONPATH": "sim"},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 1
    for words in ("netlist needs GHDL", "Verilator 5.0 or newer is missing", "g++ is missing"):
        assert words in done.stderr
    assert "Traceback" not in done.stderr


def test_the_second_time_nothing_is_built() -> None:
    library = build(LANES, DEPTH)
    made = library.stat().st_mtime_ns
    said: list[str] = []
    assert build(LANES, DEPTH, report_step=said.append) == library
    assert library.stat().st_mtime_ns == made
    assert said == []


def test_the_digest_changes_with_text_name_and_content(tmp_path: Path) -> None:
    one, two = tmp_path / "one.vhd", tmp_path / "two.vhd"
    one.write_text("a", encoding="utf-8")
    two.write_text("a", encoding="utf-8")
    found = {digest(["x"], [one]), digest(["y"], [one]), digest(["x"], [two])}
    one.write_text("b", encoding="utf-8")
    found.add(digest(["x"], [one]))
    assert len(found) == 4


def test_a_failed_build_leaves_nothing_and_shows_the_end_of_the_log(tmp_path: Path) -> None:
    source = tmp_path / "wrong.c"
    source.write_text("int wrong(void) { return nothing; }\n", encoding="utf-8")
    target, log = tmp_path / "made", tmp_path / "made.log"

    def fail() -> None:
        with building(target, log) as folder:
            assert folder is not None
            compile_all([source], folder, [], log)

    with pytest.raises(InstrumentError, match=r"wrong\.c failed \(gcc\)(.|\n)*nothing"):
        fail()
    assert not target.exists()
    assert not list(tmp_path.glob("made.*/"))


def test_two_processes_build_once(tmp_path: Path) -> None:
    program = (
        "import sys, time; from pathlib import Path\n"
        "from arctrue.instrument.build import building\n"
        f"t = Path({str(tmp_path / 'made')!r})\n"
        "with building(t, t.with_suffix('.log')) as f:\n"
        "    if f is not None: time.sleep(1); (f / 'who').write_text(sys.argv[1])\n"
        "    print(f is not None)\n"
    )
    started = [
        subprocess.Popen(
            [sys.executable, "-c", program, str(number)],
            stdout=subprocess.PIPE,
            text=True,
            cwd=ROOT / "sim",
        )
        for number in range(2)
    ]

    answers = sorted(process.communicate(timeout=60)[0].strip() for process in started)
    assert answers == ["False", "True"]
    assert (tmp_path / "made" / "who").exists()
