"""Tests scripts/setup.sh on machines that lack tools: it installs them, or names them and stops."""

from __future__ import annotations

import shutil
import subprocess
from dataclasses import dataclass
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[3]


@dataclass
class Machine:
    """A source tree, and a PATH with a stand-in for every command that would change the machine."""

    tree: Path
    commands: Path

    def command(self, name: str, script: str) -> None:
        file = self.commands / name
        file.write_text(f"#!/bin/sh\n{script}\n", encoding="utf-8")
        file.chmod(0o755)

    def setup(self, os_release: str) -> subprocess.CompletedProcess[str]:
        release = self.tree / "os-release"
        release.write_text(os_release, encoding="utf-8")
        environment = {
            "PATH": str(self.commands),
            "OS_RELEASE": str(release),
            "PYTHON": str(self.commands / "python3"),
            "GHDL_LLVM": "ghdl1-llvm",
            "HOME": str(self.tree),
        }
        return subprocess.run(
            ["/bin/bash", "scripts/setup.sh"],
            cwd=self.tree,
            env=environment,
            stdin=subprocess.DEVNULL,
            capture_output=True,
            text=True,
            check=False,
        )


DEBIAN_12 = "ID=debian\nVERSION_ID=12\n"


@pytest.fixture
def machine(tmp_path: Path) -> Machine:
    tree = tmp_path / "tree"
    commands = tmp_path / "commands"
    (tree / "scripts").mkdir(parents=True)
    commands.mkdir()
    shutil.copy(ROOT / "scripts" / "setup.sh", tree / "scripts" / "setup.sh")
    for name in ("requirements.lock", "pyproject.toml"):
        (tree / name).write_text("", encoding="utf-8")
    for tool in (
        "dirname",
        "cat",
        "tail",
        "head",
        "cut",
        "seq",
        "sha256sum",
        "grep",
        "rm",
        "mkdir",
        "env",
        "ln",
    ):
        found = shutil.which(tool)
        assert found
        (commands / tool).symlink_to(found)
    made = Machine(tree, commands)
    made.command("dpkg-query", "printf installed")
    made.command("id", "echo 0")
    made.command("apt-get", f'echo "$@" >> {tree}/apt.log')
    made.command("python3", "exit 0")
    return made


def apt_log(machine: Machine) -> str:
    file = machine.tree / "apt.log"
    return file.read_text(encoding="utf-8") if file.exists() else ""


def test_unknown_system_lists_what_to_install(machine: Machine) -> None:
    done = machine.setup("ID=fedora\nVERSION_ID=41\n")
    assert done.returncode == 1
    for words in ("fedora 41", "Debian 12, Debian 13 and Ubuntu 24.04", "GHDL", "ghdl-llvm", "gcc"):
        assert words in done.stderr
    assert apt_log(machine) == ""


def test_unknown_system_with_all_tools_goes_on(machine: Machine) -> None:
    # The stand-in for GHDL has the code generators mcode and llvm, and prints each name as GHDL
    # does.
    machine.command(
        "ghdl",
        'case "$GHDL_BACKEND" in mcode) echo " static elaboration, mcode JIT code generator";; '
        'llvm) echo " llvm code generator";; esac; seq 10000',
    )
    for tool in ("gcc", "g++", "verilator"):
        machine.command(tool, "exit 0")
    done = machine.setup("ID=arch\n")
    assert "Debian 12, Debian 13" not in done.stderr
    assert "installing the Python packages" in done.stderr
    assert apt_log(machine) == ""


@pytest.mark.parametrize(
    ("system", "wanted"),
    [(DEBIAN_12, True), ("ID=debian\nVERSION_ID=13\n", True),
     ("ID=ubuntu\nVERSION_ID=24.04\n", False)],
)  # fmt: skip
def test_a_browser_comes_from_debian_only(machine: Machine, system: str, wanted: bool) -> None:
    # Ubuntu's package chromium installs a snap, which a container cannot run.
    machine.command("dpkg-query", '[ "$3" = chromium ] || printf installed')
    machine.setup(system)
    assert ("chromium" in apt_log(machine)) is wanted


def llvm_names(machine: Machine) -> dict[str, str]:
    folder = machine.tree / "build" / "llvm_names"
    return {file.name: str(file.readlink()) for file in folder.glob("*")}


NOT_FOUND = """cat <<'end'
	libLLVM-18.so.18.1 => not found
	libc.so.6 => /lib/x86_64-linux-gnu/libc.so.6 (0x00007f0000000000)
end"""


def test_llvm_gets_the_name_that_ghdl_asks_for(machine: Machine) -> None:
    # The stand-in prints the output of ghdl-llvm 4.1.0+dfsg-0ubuntu2.1 with libllvm18
    # 1:18.1.3-1ubuntu1 on Ubuntu 24.04.
    machine.command("ldd", NOT_FOUND)
    library = "/lib/x86_64-linux-gnu/libLLVM.so.18.1"
    machine.command("ldconfig", f"printf '\\tlibLLVM.so.18.1 (libc6,x86-64) => {library}\\n'")
    machine.setup("ID=ubuntu\nVERSION_ID=24.04\n")
    assert llvm_names(machine) == {"libLLVM-18.so.18.1": library}


def test_llvm_that_is_found_gets_no_other_name(machine: Machine) -> None:
    machine.command("ldd", "echo ' libLLVM-14.so.1 => /lib/x86_64-linux-gnu/libLLVM-14.so.1 (0x0)'")
    machine.setup(DEBIAN_12)
    assert llvm_names(machine) == {}


def test_llvm_that_is_nowhere_stops_the_set_up(machine: Machine) -> None:
    machine.command("ldd", NOT_FOUND)
    machine.command("ldconfig", "exit 0")
    done = machine.setup("ID=ubuntu\nVERSION_ID=24.04\n")
    assert done.returncode == 1
    assert "libLLVM-18.so.18.1" in done.stderr
    assert "installing the Python packages" not in done.stderr


def test_without_root_and_sudo_it_names_the_packages(machine: Machine) -> None:
    machine.command("id", "echo 1000")
    machine.command("dpkg-query", 'case "$*" in *ghdl-llvm*) exit 1;; *) printf installed;; esac')
    done = machine.setup(DEBIAN_12)
    assert done.returncode == 1
    assert "apt-get install --no-install-recommends ghdl-llvm\n" in done.stderr
    assert apt_log(machine) == ""


def test_only_what_is_missing_is_installed(machine: Machine) -> None:
    machine.command("dpkg-query", 'case "$*" in *ghdl-mcode*) exit 1;; *) printf installed;; esac')
    machine.setup(DEBIAN_12)
    install = [line for line in apt_log(machine).splitlines() if " install " in line]
    assert len(install) == 1
    assert install[0].endswith("install --no-install-recommends ghdl-mcode")


def test_packages_that_cannot_be_had_stop_the_set_up(machine: Machine) -> None:
    machine.command("dpkg-query", "exit 1")
    machine.command("apt-get", "echo 'E: Unable to fetch some archives'; exit 100")
    done = machine.setup(DEBIAN_12)
    assert done.returncode == 1
    assert "network" in done.stderr
    assert "Unable to fetch some archives" in done.stderr
    assert "ghdl-llvm ghdl-mcode" in done.stderr


def test_python_that_is_too_old_stops_the_set_up(machine: Machine) -> None:
    machine.command("python3", "exit 1")
    done = machine.setup(DEBIAN_12)
    assert done.returncode == 1
    assert "not Python 3.11 or newer" in done.stderr


def test_packages_of_the_lock_that_cannot_be_had_stop_the_set_up(machine: Machine) -> None:
    # The stand-in for venv makes an environment whose pip cannot reach the network.
    machine.command(
        "python3",
        'if [ "$2" = venv ]; then mkdir -p .venv/bin; '
        "printf '#!/bin/sh\\necho no route to host; exit 1\\n' > .venv/bin/python; "
        "chmod 755 .venv/bin/python; fi",
    )
    chmod = shutil.which("chmod")
    assert chmod
    (machine.commands / "chmod").symlink_to(chmod)
    done = machine.setup(DEBIAN_12)
    assert done.returncode == 1
    assert "network" in done.stderr
    assert "no route to host" in done.stderr
    assert not (machine.tree / ".venv" / ".setup-lock").exists()


def made_ready(machine: Machine, installer: str) -> None:
    """Prepare the tree so that the script only has to install GHDL for netlists. ``installer`` is
    the stand-in for the script that fetches this GHDL."""
    machine.command(
        "python3",
        'if [ "$2" = venv ]; then mkdir -p .venv/bin; printf "#!/bin/sh\\nexit 0\\n" '
        "> .venv/bin/python; chmod 755 .venv/bin/python; fi",
    )
    chmod = shutil.which("chmod")
    assert chmod
    (machine.commands / "chmod").symlink_to(chmod)
    file = machine.tree / "scripts" / "install_ghdl_netlist.sh"
    file.write_text(f"#!/bin/sh\n{installer}\n", encoding="utf-8")
    file.chmod(0o755)


def test_a_ghdl_too_old_for_netlists_gets_a_newer_one(machine: Machine) -> None:
    made_ready(machine, "echo unpacked")
    for version in ("2.0.0", "4.1.0 (Ubuntu 4.1.0+dfsg-0ubuntu2)"):
        machine.command("ghdl", f"echo 'GHDL {version}'")
        done = machine.setup(DEBIAN_12)
        assert done.returncode == 0, done.stderr
        assert "unpacked" in done.stdout
    machine.command("ghdl", "echo 'GHDL 5.0.1 (tarball)'")
    assert "unpacked" not in machine.setup(DEBIAN_12).stdout


def test_without_a_ghdl_for_netlists_the_set_up_goes_on(machine: Machine) -> None:
    made_ready(machine, "echo no mirror >&2; exit 1")
    done = machine.setup(DEBIAN_12)
    assert done.returncode == 0
    assert "no mirror" in done.stderr
    assert "the virtual instrument and its tests need it" in done.stderr
