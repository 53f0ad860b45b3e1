"""Tests that the install scripts keep tools that are already installed; the tests download
nothing."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

import pytest

from arctrue.base.source_tree import ROOT

# The output is longer than a pipe's buffer. A script that reads only the first line must not treat
# the broken pipe as a failure.
TALKATIVE = """#!/bin/sh
case "$*" in
    *--synth*) echo "module probe" ;;
    *--help*) echo part_file; exit 1 ;;
    *) echo "GHDL 5.0.1 stand-in"; yes more | head -n 100000 || exit 1 ;;
esac
"""
TOOLS = {
    "install_ghdl_netlist.sh": ["build/ghdl5/bin/ghdl"],
    "install_place_and_route.sh": [
        "build/place_and_route/bin/nextpnr-himbaechel-xilinx",
        "build/place_and_route/bin/xc7frames2bit",
    ],
}


def tree(folder: Path, script: str) -> Path:
    """Copy the script into a new source tree, with stand-ins for the tools that the script unpacks;
    return the copy."""
    (folder / "scripts").mkdir()
    for name in (script, "debian_packages.sh"):
        shutil.copy(ROOT / "scripts" / name, folder / "scripts")
    for tool in TOOLS[script]:
        path = folder / tool
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(TALKATIVE, encoding="utf-8")
        path.chmod(0o755)
    unpacked = folder / "build" / "place_and_route"
    (unpacked / "database" / "zynq7" / "xc7z020").mkdir(parents=True)
    (unpacked / "chipdb-xc7z020.bin").touch()
    return folder / "scripts" / script


def started(script: Path, folder: Path) -> subprocess.CompletedProcess[str]:
    """Run the script with a mirror that does not exist."""
    environment = {"PATH": "/usr/bin:/bin", "DEBIAN_MIRROR": f"file://{folder}/no-such-mirror"}
    return subprocess.run(
        [script], env=environment, capture_output=True, text=True, check=False, cwd=folder
    )


@pytest.mark.parametrize("name", TOOLS)
def test_what_is_there_is_left_alone(tmp_path: Path, name: str) -> None:
    done = started(tree(tmp_path, name), tmp_path)
    assert done.returncode == 0, done.stderr
    assert "there already: GHDL 5.0.1 stand-in in" in done.stderr


@pytest.mark.parametrize("name", TOOLS)
def test_without_a_mirror_it_says_what_to_do(tmp_path: Path, name: str) -> None:
    script = tree(tmp_path, name)
    (tmp_path / TOOLS[name][0]).unlink()
    done = started(script, tmp_path)
    assert done.returncode == 1
    for message in ("could not be fetched", "Another mirror: DEBIAN_MIRROR=", "By other means"):
        assert message in done.stderr
