"""Tests that `make lint` uses the linters that requirements.lock pins, not the linters of the
system."""

from __future__ import annotations

import os
import re
import subprocess
import tomllib
from importlib.metadata import version
from pathlib import Path

import pytest

from arctrue.base.source_tree import ROOT


def check_firmware(path: str, *options: str) -> subprocess.CompletedProcess[str]:
    """Run ``make check`` of the firmware, with ``path`` in front of the PATH of this process.

    ``make lint`` checks all folders; ``make check`` of one folder is enough to show which cppcheck
    runs.
    """
    return subprocess.run(
        ["make", "-C", "firmware", "check", *options],
        cwd=ROOT,
        env=os.environ | {"PATH": f"{path}:{os.environ['PATH']}"},
        capture_output=True,
        text=True,
        check=False,
    )


@pytest.mark.large
def test_a_newer_cppcheck_of_the_system_changes_nothing(tmp_path: Path) -> None:
    system = tmp_path / "cppcheck"
    system.write_text("#!/bin/sh\necho 'main.c:1:1: style: a later rule' >&2\nexit 1\n", "utf-8")
    system.chmod(0o755)
    done = check_firmware(str(tmp_path), "FOLDERS=calibration")
    assert done.returncode == 0, done.stdout + done.stderr
    assert "a later rule" not in done.stderr


def test_cppcheck_still_finds_a_fault(tmp_path: Path) -> None:
    (tmp_path / "fault.c").write_text(
        "int third(void);\n\nint third(void) {\n    int two[2] = {0, 0};\n    return two[2];\n}\n",
        encoding="utf-8",
    )
    done = check_firmware("/usr/bin", f"FOLDERS={tmp_path}")
    assert done.returncode != 0
    assert re.search(r"fault\.c:5:\d+: error: .*\[arrayIndexOutOfBounds\]", done.stderr)


@pytest.mark.parametrize("tool", ["cppcheck", "clang-format"])
def test_a_linter_of_c_is_pinned_and_that_version_is_installed(tool: str) -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    pinned = f"{tool}=={version(tool)}"
    assert pinned in project["optional-dependencies"]["dev"]
    lock = (ROOT / "requirements.lock").read_text(encoding="utf-8")
    assert re.search(rf"^{re.escape(pinned)} ", lock, re.MULTILINE)
    packages = re.search(
        r"^PACKAGES=\(([^)]*)\)", (ROOT / "scripts/setup.sh").read_text("utf-8"), re.M
    )
    assert packages
    assert tool not in packages[1].split()
