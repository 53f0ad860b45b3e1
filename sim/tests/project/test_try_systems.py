"""Tests the commands, records and messages of scripts/try_systems.sh, with stand-ins for programs
that need root."""

from __future__ import annotations

import os
import shutil
import signal
import subprocess
import time
import tomllib
from dataclasses import dataclass
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[3]
BAD_INPUT = 2
SYSTEMS = {"debian12": "Debian 12", "debian13": "Debian 13", "ubuntu2404": "Ubuntu 24.04"}

# Stand-in for debootstrap, which makes the files that debootstrap makes, and writes its arguments
# to a file.
DEBOOTSTRAP = """
echo "$@" >> "$SAID"
for word; do case $word in */systems/*[0-9]) root=$word;; esac; done
mkdir -p "$root/etc/apt/apt.conf.d" "$root/usr/local/share/ca-certificates" "$root/root"
"""
# Stand-in for chroot. Its arguments are the root, then sh -c PROGRAM sh PLACE, and then the
# command.
CHROOT = """
root=$1
shift 6
case "$*" in
    "make setup") exit 0 ;;
    "make test"*)
        mkdir -p "$root/srv/arctrue/build/reports"
        echo '<testsuites><testsuite name="pytest" errors="1" failures="2" skipped="3"' \\
            'tests="60" time="9.1"><testcase/></testsuite></testsuites>' \\
            > "$root/srv/arctrue/build/reports/junit.xml"
        echo "FAILED tb/decoder - a reason"
        exit 1 ;;
    "ghdl --version") echo "GHDL 5.0.1 (Debian 5.0.1+dfsg-1+b1) [Dunoon edition]" ;;
esac
"""


@dataclass
class Machine:
    """A source tree with one commit, and a PATH of stand-ins that change nothing on this
    machine."""

    tree: Path
    commands: Path

    def command(self, name: str, script: str) -> None:
        file = self.commands / name
        file.write_text(f"#!/bin/sh\n{script}\n", encoding="utf-8")
        file.chmod(0o755)

    def git(self, *words: str) -> str:
        who = ["-c", "user.name=somebody", "-c", "user.email=somebody@example.org"]
        return subprocess.run(
            ["git", *who, *words], cwd=self.tree, check=True, capture_output=True, text=True
        ).stdout.strip()

    def environment(self) -> dict[str, str]:
        return {
            "PATH": f"{self.commands}:/usr/bin:/bin",
            "HOME": str(self.tree.parent),
            "SAID": str(self.tree.parent / "said"),
        }

    def __call__(self, *words: str, **variables: str) -> subprocess.CompletedProcess[str]:
        return subprocess.run(
            ["/bin/bash", "scripts/try_systems.sh", *words],
            cwd=self.tree,
            env={**self.environment(), **variables},
            stdin=subprocess.DEVNULL,
            capture_output=True,
            text=True,
            check=False,
        )

    def said(self) -> str:
        return (self.tree.parent / "said").read_text(encoding="utf-8")

    def result(self, system: str) -> dict[str, object]:
        file = self.tree / "build" / "systems" / "results" / f"{system}.toml"
        return tomllib.loads(file.read_text(encoding="utf-8"))


@pytest.fixture
def machine(tmp_path: Path) -> Machine:
    made = Machine(tmp_path / "tree", tmp_path / "commands")
    (made.tree / "scripts").mkdir(parents=True)
    made.commands.mkdir()
    for name in ("try_systems.sh", "debian_packages.sh"):
        shutil.copy(ROOT / "scripts" / name, made.tree / "scripts")
    (made.tree / ".gitignore").write_text("/build/\n")
    made.git("init", "--quiet")
    made.git("add", "--all")
    made.git("commit", "--quiet", "--message", "one")
    keys = made.tree / "build/systems/keys/usr/share/keyrings/ubuntu-archive-keyring.gpg"
    keys.parent.mkdir(parents=True)
    keys.touch()
    made.command("unshare", 'while [ "$1" != -- ]; do shift; done; shift; exec "$@"')
    made.command("debootstrap", DEBOOTSTRAP)
    made.command("chroot", CHROOT)
    made.command("id", "echo 0")
    for name in ("mount", "apt-config"):
        made.command(name, "exit 0")
    return made


def test_results_of_a_system_are_recorded(machine: Machine) -> None:
    done = machine("debian13", "test", "demo", "PYTEST_OPTIONS=-k register")
    assert done.returncode == 1
    assert "Debian 13: test FAILED" in done.stderr
    assert "FAILED tb/decoder - a reason" in done.stderr
    assert "Debian 13: demo passed" in done.stderr
    result = machine.result("debian13")
    assert result["commit"] == machine.git("rev-parse", "HEAD")
    assert (result["system"], result["ghdl"]) == ("Debian 13", "5.0.1")
    test, demo = result["test"], result["demo"]
    assert isinstance(test, dict)
    assert isinstance(demo, dict)
    assert (test["passed"], test["failed"], test["skipped"], test["exit"]) == (54, 3, 3, 1)
    assert test["variables"] == "PYTEST_OPTIONS=-k register"
    assert demo["exit"] == 0
    row = next(line for line in done.stdout.splitlines() if line.startswith("| Debian 13"))
    assert "**failed**: 54 passed, 3 failed, 3 skipped, 0 min" in row
    assert len(row.split("|")) == len(done.stdout.splitlines()[0].split("|"))


def test_results_stay_while_the_commit_does(machine: Machine) -> None:
    assert machine("debian12", "demo").returncode == 0
    assert machine("debian12", "install").returncode == 0
    assert {"demo", "install"} <= machine.result("debian12").keys()
    assert machine.said().count("bookworm") == 1, "the system was made anew"
    machine.git("commit", "--quiet", "--allow-empty", "--message", "two")
    assert machine("debian12", "install").returncode == 0
    assert "demo" not in machine.result("debian12")


def test_every_system_comes_from_its_own_archive(machine: Machine) -> None:
    mirrors = {"DEBIAN_MIRROR": "http://deb/debian", "UBUNTU_MIRROR": "http://ubu/ubuntu"}
    done = machine("install", "--page", "page.md", **mirrors)
    assert done.returncode == 0, done.stderr
    made = [line for line in machine.said().splitlines() if "--variant=minbase" in line]
    archives = [next(w for w in line.split() if w.startswith("http")) for line in made]
    assert archives == ["http://deb/debian", "http://deb/debian", "http://ubu/ubuntu"]
    page = (machine.tree / "page.md").read_text(encoding="utf-8")
    assert [title for title in SYSTEMS.values() if f"| {title} |" in page] == [*SYSTEMS.values()]


def test_an_archive_that_does_not_answer_is_reported_and_the_next_system_tried(
    machine: Machine,
) -> None:
    fails = 'case "$*" in *noble*) echo "E: Failed getting release file"; exit 1;; esac\n'
    machine.command("debootstrap", fails + DEBOOTSTRAP)
    done = machine("ubuntu2404", "debian13", "demo")
    assert done.returncode == 1
    for message in ("Failed getting release file", "UBUNTU_MIRROR=", "FAILED on: ubuntu2404"):
        assert message in done.stderr
    assert machine.result("debian13")["demo"] == {"exit": 0, "seconds": 0}
    assert not (machine.tree / "build" / "systems" / "ubuntu2404").exists()


def test_a_set_up_that_fails_is_reported(machine: Machine) -> None:
    machine.command("chroot", CHROOT.replace("exit 0", "exit 1"))
    done = machine("debian13", "demo")
    assert done.returncode == 1
    assert "Debian 13: the set-up FAILED" in done.stderr
    assert "demo" not in done.stderr.split("FAILED")[0]
    # After a failed set-up, packages may be partly installed; therefore the script makes the system
    # again.
    machine.command("chroot", CHROOT)
    assert machine("debian13", "demo").returncode == 0
    assert machine.said().count("trixie") == 2, "the system was not made anew"


def test_it_ends_at_once_when_it_is_reported_to(machine: Machine, tmp_path: Path) -> None:
    begun = tmp_path / "begun"
    machine.command("chroot", f'case "$*" in *"make demo") touch {begun}; exec sleep 600;; esac')
    script = subprocess.Popen(
        ["/bin/bash", "scripts/try_systems.sh", "debian13", "demo"],
        cwd=machine.tree,
        env=machine.environment(),
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        start_new_session=True,
    )
    try:
        while not begun.exists():
            assert script.poll() is None
            time.sleep(0.02)
        script.terminate()
        # The script ends without waiting for the command, which would take ten minutes.
        assert script.wait(timeout=300) == 128 + signal.SIGTERM
    finally:
        # Without a process namespace, the stand-in's processes do not end with the script; the test
        # ends them.
        os.killpg(script.pid, signal.SIGKILL)
    assert not (machine.tree / "build" / "systems" / "results" / "debian13.toml").exists()


@pytest.mark.parametrize("word", ["debian11", "tests", "--commit"])
def test_a_wrong_word_is_refused_before_anything_is_made(machine: Machine, word: str) -> None:
    done = machine("debian13", word)
    assert done.returncode == 1
    assert word in done.stderr
    assert not (machine.tree.parent / "said").exists()


def test_without_root_it_says_how(machine: Machine) -> None:
    machine.command("id", "echo 1000")
    done = machine("debian13")
    assert done.returncode == BAD_INPUT
    assert "sudo scripts/try_systems.sh debian13" in done.stderr


def test_workflow_readme_and_scripts_name_the_same_systems_and_commands() -> None:
    text = {
        name: (ROOT / name).read_text(encoding="utf-8")
        for name in (".github/workflows/ci.yml", "README.md", "scripts/setup.sh")
    }
    script = (ROOT / "scripts" / "try_systems.sh").read_text(encoding="utf-8")
    assert f"SYSTEMS=({' '.join(SYSTEMS)})" in script
    workflow = text[".github/workflows/ci.yml"]
    for title in SYSTEMS.values():
        name, number = title.lower().split()
        assert f'title="{title}"' in script
        assert f'"{name}:{number}"' in workflow
        assert f'"{name} {number}"' in text["scripts/setup.sh"]
        assert title in text["README.md"]
    assert "TARGETS=(test demo install)" in script
    for command in ("make setup", "make test", "make demo", "scripts/try_install.sh"):
        assert f"run: {command}\n" in workflow
