"""Tests the package as a user installs it: from a wheel, without the source tree.

The tests need no network. The build has only the build requirements of pyproject.toml, as in pip's
isolated build; the installed program has only its declared dependencies.
"""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
import tomllib
import zipfile
from dataclasses import dataclass
from pathlib import Path

import pytest
from packaging.requirements import Requirement
from sim.tests.project.distributions import link, required

from arctrue.base.extras import EXTRA_OF

ROOT = Path(__file__).resolve().parents[3]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
# Files that are generated, and that git ignores.
MADE = shutil.ignore_patterns(
    *(".git", ".venv", "build", "generated", "*.egg-info", "__pycache__", ".*_cache", ".hypothesis")
)
BAD_INPUT = 2


def build(hook: str, tree: Path, out: Path, packages: Path) -> Path:
    """Run a build hook (PEP 517) on a source tree, and return the file that it builds."""
    out.mkdir(parents=True, exist_ok=True)
    program = f"from setuptools import build_meta; print('made', build_meta.{hook}({str(out)!r}))"
    done = subprocess.run(
        [sys.executable, "-S", "-c", program],
        cwd=tree,
        env={"PATH": os.environ["PATH"], "PYTHONPATH": str(packages), "LANG": "C.UTF-8"},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return out / done.stdout.split()[-1]


@pytest.fixture(scope="module")
def build_packages(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("build") / "packages"
    link(required(PROJECT["build-system"]["requires"]).values(), folder)
    return folder


@pytest.fixture(scope="module")
def tree(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Copy the source tree as it is after ``git clone``, without generated files."""
    return Path(shutil.copytree(ROOT, tmp_path_factory.mktemp("clone") / "arctrue", ignore=MADE))


@pytest.fixture(scope="module")
def wheel(tree: Path, build_packages: Path) -> Path:
    return build("build_wheel", tree, tree.parent / "wheel", build_packages)


@pytest.fixture(scope="module")
def source_distribution(tree: Path, build_packages: Path) -> Path:
    return build("build_sdist", tree, tree.parent / "sdist", build_packages)


def contents(wheel: Path) -> dict[str, bytes]:
    with zipfile.ZipFile(wheel) as archive:
        return {name: archive.read(name) for name in archive.namelist()}


def test_the_wheel_holds_the_package_and_what_is_generated(wheel: Path) -> None:
    source = ROOT / "sim" / "arctrue"
    expected = {
        f"arctrue/{path.relative_to(source).as_posix()}"
        for path in source.rglob("*")
        if path.is_file() and "__pycache__" not in path.parts
    }
    held = contents(wheel)
    assert {"arctrue/generated/registers.py", "arctrue/py.typed"} <= expected
    assert {name for name in held if name.startswith("arctrue/")} == expected
    for name in ("__init__", "number_formats", "registers"):
        path = f"generated/{name}.py"
        assert held[f"arctrue/{path}"] == (source / path).read_bytes(), path


def test_a_module_of_an_earlier_build_is_not_in_the_next_wheel(
    tree: Path, wheel: Path, build_packages: Path, tmp_path: Path
) -> None:
    copy = Path(shutil.copytree(tree, tmp_path / "arctrue"))
    (copy / "build" / "lib" / "arctrue").mkdir(parents=True, exist_ok=True)
    (copy / "build" / "lib" / "arctrue" / "moved_away.py").touch()
    again = build("build_wheel", copy, tmp_path / "wheel", build_packages)
    assert contents(again).keys() == contents(wheel).keys()


def test_the_source_distribution_makes_the_same_wheel(
    tree: Path, wheel: Path, source_distribution: Path, build_packages: Path, tmp_path: Path
) -> None:
    (tmp_path / "unpacked").mkdir()
    command = ["tar", "-xf", source_distribution, "-C", tmp_path / "unpacked"]
    subprocess.run(command, check=True)
    (unpacked,) = (tmp_path / "unpacked").iterdir()
    for folder in ("rtl", "tb/demo", "firmware", "scripts", "sim/scenarios"):
        kept = {path.relative_to(tree) for path in (tree / folder).rglob("*.*")}
        kept = {path for path in kept if "__pycache__" not in path.parts}
        there = {path.relative_to(unpacked) for path in (unpacked / folder).rglob("*")}
        assert kept <= there, folder
    again = build("build_wheel", unpacked, tmp_path / "wheel", build_packages)
    first, second = contents(wheel), contents(again)
    assert first.keys() == second.keys()
    assert not [name for name in first if first[name] != second[name]]


def test_wheel_and_source_distribution_can_be_published(
    wheel: Path, source_distribution: Path, tmp_path: Path
) -> None:
    """``twine check --strict`` accepts the wheel and the source distribution: their metadata are
    valid, and the package index can show the description."""
    words = [sys.executable, "-m", "twine", "--no-color", "check", "--strict"]
    words += [str(wheel), str(source_distribution)]
    done = subprocess.run(words, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    assert done.stdout.count("PASSED") == 2
    broken = tmp_path / "broken" / wheel.name
    broken.parent.mkdir()
    with zipfile.ZipFile(wheel) as archive, zipfile.ZipFile(broken, "w") as copy:
        for name in archive.namelist():
            text = archive.read(name)
            if name.endswith(".dist-info/METADATA"):
                text = text.partition(b"\n\n")[0] + b"\n\n"
            copy.writestr(name, text)
    refused = subprocess.run([*words[:-2], broken], capture_output=True, text=True, check=False)
    assert refused.returncode != 0


def test_an_editable_install_generates_in_the_tree(
    tree: Path, build_packages: Path, tmp_path: Path
) -> None:
    copy = Path(shutil.copytree(tree, tmp_path / "arctrue", ignore=MADE))
    build("build_editable", copy, tmp_path / "wheel", build_packages)
    for name in ("__init__", "number_formats", "registers"):
        path = Path("sim", "arctrue", "generated", f"{name}.py")
        assert (copy / path).read_bytes() == (ROOT / path).read_bytes()


@dataclass
class Installed:
    """An environment with the installed wheel and its declared dependencies, and an empty working
    folder."""

    environment: Path
    folder: Path

    def run(self, program: str, *words: str, fails: int = 0) -> str:
        done = subprocess.run(
            [str(self.environment / "bin" / program), *words],
            cwd=self.folder,
            env={"PATH": os.environ["PATH"], "HOME": os.environ["HOME"], "LANG": "C.UTF-8"},
            stdin=subprocess.DEVNULL,
            capture_output=True,
            text=True,
            check=False,
        )
        said = done.stdout + done.stderr
        assert done.returncode == fails, said
        assert "Traceback" not in said
        return said

    def arctrue(self, *words: str, fails: int = 0) -> str:
        return self.run("arctrue", *words, fails=fails)


EXTRAS = PROJECT["project"]["optional-dependencies"]
CORE = PROJECT["project"]["dependencies"]
ALL = [line for name, lines in EXTRAS.items() if name not in ("all", "dev") for line in lines]
MOST_MB = 260
"""Largest size of the installed core in MB, of which numpy and scipy take 215 MB."""


def install(wheel: Path, folder: Path, requirements: list[str]) -> Installed:
    """Install the wheel in an empty environment that contains these packages and no others."""
    environment = folder / "environment"
    subprocess.run([sys.executable, "-m", "venv", "--without-pip", environment], check=True)
    python = environment / "bin" / "python"
    words = ["--python", str(python), "install", "--quiet", "--no-deps", "--no-index", str(wheel)]
    subprocess.run([sys.executable, "-m", "pip", *words], check=True)
    link(required(requirements).values(), folder / "packages")
    (site,) = environment.glob("lib/python3.*/site-packages")
    (site / "dependencies.pth").write_text(f"{folder / 'packages'}\n", encoding="utf-8")
    empty = folder / "empty"
    empty.mkdir()
    return Installed(environment, empty)


@pytest.fixture(scope="module")
def installed(wheel: Path, tmp_path_factory: pytest.TempPathFactory) -> Installed:
    """Install the wheel with every extra, ``arctrue[all]``."""
    return install(wheel, tmp_path_factory.mktemp("stranger"), CORE + ALL)


@pytest.fixture(scope="module")
def core(wheel: Path, tmp_path_factory: pytest.TempPathFactory) -> Installed:
    """Install the wheel without any extra."""
    return install(wheel, tmp_path_factory.mktemp("core"), CORE)


def test_all_has_every_extra() -> None:
    (line,) = EXTRAS["all"]
    named = line.partition("[")[2].rstrip("]").split(",")
    assert sorted(named) == sorted(EXTRAS.keys() - {"all", "dev"})
    packages = {Requirement(text).name for text in ALL}
    # The import names of packages whose distribution has another name.
    other = {"pyserial": "serial", "scikit-learn": "sklearn", "ophyd-async": "ophyd_async"}
    assert {other.get(name, name) for name in packages} == EXTRA_OF.keys()
    for package, extra in EXTRA_OF.items():
        names = {other.get(n, n) for n in (Requirement(text).name for text in EXTRAS[extra])}
        assert package in names


def test_the_core_is_small(wheel: Path) -> None:
    """All files of the wheel and of the core's dependencies together have at most MOST_MB (10⁶
    bytes)."""
    files = [
        Path(str(found.locate_file(file)))
        for found in required(CORE).values()
        for file in found.files or ()
    ]
    size = sum(path.stat().st_size for path in files if path.suffix != ".pyc" and path.is_file())
    with zipfile.ZipFile(wheel) as archive:
        size += sum(item.file_size for item in archive.infolist())
    assert size / 1e6 <= MOST_MB


IN_THE_CORE = """
import importlib

import numpy as np
import arctrue as at

angle = np.tile(np.arange(24) * 15.0, 10)
error = 2.0 * np.cos(np.deg2rad(angle)) + 0.05 * np.sin(np.arange(240.0) ** 2)
data = at.Dataset.from_arrays(reference={"target_deg": angle, "error_arcsec": error}, faces=24)
at.write_set("polygon", data)
found = at.fit("polygon", at.Model().having(graduation_harmonics={"orders": [1, 2]}))
amplitude = found.params["graduation_harmonics.order_1_amplitude"]
print(round(amplitude.value, 1), amplitude.interval()[0] < 2.0 < amplitude.interval()[1])
print(at.compare("polygon").data["channels"]["reference"]["rows"])
table = lambda: importlib.import_module("arctrue.device.bluesky_table")
for needs in (found.plot, lambda: at.Dataset.from_hdf5("none.h5"), table):
    try:
        needs()
    except ImportError as error:
        print(error)
"""


@pytest.mark.large
def test_the_library_works_in_the_core(core: Installed) -> None:
    """The core alone builds, writes and fits a set from arrays. For a missing extra, the message
    names the command that installs it."""
    said = core.run("python", "-c", IN_THE_CORE).splitlines()
    assert said == [
        "2.0 True",
        "240",
        "this needs matplotlib, which is not installed: pip install 'arctrue[page]'",
        "this needs h5py, which is not installed: pip install 'arctrue[files]'",
        "this needs bluesky, which is not installed: pip install 'arctrue[bluesky]'",
    ]


@pytest.mark.parametrize(
    ("words", "extra"),
    [
        pytest.param(("serve",), "page", marks=pytest.mark.large),
        pytest.param(("monitor", "/dev/nowhere"), "device", marks=pytest.mark.large),
        (("device", "run", "/dev/nowhere"), "device"),
        (("device", "epics", "/dev/nowhere"), "epics"),
        (("import", "log.csv", "out", "--counts-per-rev", "4096"), "files"),
        pytest.param(("compare", "polygon", "--out", "pictures"), "page", marks=pytest.mark.large),
    ],
)
def test_a_command_without_its_extra_says_which(
    core: Installed, words: tuple[str, ...], extra: str
) -> None:
    if not (core.folder / "polygon").exists():
        core.run("python", "-c", IN_THE_CORE)
    (core.folder / "log.csv").write_text("target_deg,error_arcsec\n0,1\n15,2\n", encoding="utf-8")
    said = core.arctrue(*words, fails=BAD_INPUT)
    assert f"pip install 'arctrue[{extra}]'" in said


@pytest.mark.large
def test_a_calibration_of_the_core_lacks_its_picture_alone(core: Installed) -> None:
    core.arctrue("simulate", "plain", "--seed", "2", "--experiment", "lean")
    said = core.arctrue("calibrate", "plain")
    assert "No plot: this needs matplotlib" in said
    assert (core.folder / "build" / "calibration" / "plain" / "coefficients.toml").exists()


def test_every_command_of_the_core_is_listed(core: Installed) -> None:
    assert len(core.run("python", "-c", EVERY_HELP).splitlines()) == 1 + len(
        list((ROOT / "sim" / "arctrue" / "cli").glob("[!_]*.py"))
    )
    assert "serve" in core.arctrue("--help")


# All commands run in one process, because each new process would import numpy and matplotlib again.
EVERY_HELP = """
import arctrue
from arctrue.cli import main
from click.testing import CliRunner

print(arctrue.__file__)
for command in main.list_commands(None):
    done = CliRunner().invoke(main, [command, "--help"], prog_name="arctrue")
    assert done.exit_code == 0, (done.output, done.exception)
    print(done.output.splitlines()[0])
"""


@pytest.mark.large
def test_every_command_explains_itself(installed: Installed) -> None:
    module, *usages = installed.run("python", "-c", EVERY_HELP).splitlines()
    assert Path(module).is_relative_to(installed.environment)
    files = (ROOT / "sim" / "arctrue" / "cli").glob("[!_]*.py")
    assert sorted(line.split()[2] for line in usages) == sorted(
        file.stem.rstrip("_").replace("_", "-") for file in files
    )


@pytest.mark.large
def test_workbench_and_calibration_work(installed: Installed) -> None:
    arctrue, folder = installed.arctrue, installed.folder
    cause = ("--effect", "hysteresis", "--size", "2")
    arctrue("simulate", "set", *cause, "--seed", "1", "--experiment", "short")
    assert "direction" in arctrue("compare", "set")
    arctrue("diagnose", "set", "--json", "diagnosis.json")
    diagnosis = json.loads((folder / "diagnosis.json").read_text(encoding="utf-8"))
    assert diagnosis["named"] == "hysteresis"
    arctrue("add", "hysteresis", "set", "--model", "model.toml")
    assert "hysteresis" in arctrue("history", "--model", "model.toml")
    arctrue("effects", "new", "my_effect")
    assert "my_effect" in arctrue("effects", "--effects", "effects")
    arctrue("simulate", "plain", "--seed", "2", "--experiment", "lean")
    arctrue("calibrate", "plain")
    assert (folder / "build" / "calibration" / "plain" / "coefficients.toml").exists()


@pytest.mark.parametrize(
    "command",
    [
        pytest.param("demo", marks=pytest.mark.large),
        "revolution",
        "paper",
        pytest.param("hidden hysteresis", marks=pytest.mark.large),
        pytest.param("run", marks=pytest.mark.large),
    ],
)
def test_what_needs_the_source_tree_says_so(installed: Installed, command: str) -> None:
    words = command.split()
    if words == ["run"]:
        words += [str(ROOT / "sim" / "scenarios" / "hysteresis.toml")]
    said = installed.arctrue(*words, fails=BAD_INPUT)
    assert said.count("start it from a source tree of ArcTrue") == 1
    assert not list(installed.environment.rglob("build"))
