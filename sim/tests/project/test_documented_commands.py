"""Tests that every documented command is run here or in test_tutorial.py, or is listed here with a
reason and with the test that runs it."""

from __future__ import annotations

import re
import shlex
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import click
import numpy as np
import pytest
from click.testing import CliRunner

from arctrue.cli import _loaded_set, main
from arctrue.measurement import write_measurement_set
from arctrue.studies.simulate.experiment import short
from arctrue.studies.simulate.simulated_set import simulate_set

ROOT = Path(__file__).resolve().parents[3]
DOCS = ROOT / "docs"
PAGES = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted(DOCS.glob("*.md"))]
FOLLOWED = {"tutorial.md", "first-own-table.md", "own-effect.md", "real-data.md"}
"""Pages of which test_tutorial.py runs every command and checks the output. It runs the commands of
first-own-table.md only in ``make test-large``."""
BLOCK = re.compile(r"^```(?P<language>\w*)[^\n]*\n(?P<text>.*?)^```$", re.MULTILINE | re.DOTALL)

INSTRUMENT = "needs the compiled gateware, and takes minutes at the page's settings"
ELSEWHERE = {
    "arctrue capture": ("needs a device", "sim/tests/cli/test_monitor.py"),
    "arctrue commission": ("needs a device", "sim/tests/cli/test_commission.py"),
    "arctrue device": ("runs until it is stopped", "sim/tests/device/test_daemon.py"),
    "arctrue flash": ("needs a device", "scripts/tests/image/test_flash_command.py"),
    "arctrue revolution": (INSTRUMENT, "sim/tests/studies/revolution/test_revolution.py"),
    "arctrue alpha": ("takes half a minute", "sim/tests/studies/head_angle/test_alpha.py"),
    "arctrue heads": ("takes two minutes", "sim/tests/studies/heads/test_heads.py"),
    "arctrue methods": ("takes a minute", "sim/tests/studies/methods/test_methods_page.py"),
    "arctrue error-sources": (
        "takes two minutes",
        "sim/tests/studies/error_budget/test_error_budget.py",
    ),
    "arctrue certificate": ("needs details", "sim/tests/metrology/test_certificate.py"),
    "arctrue life": ("needs the sets of a machine", "sim/tests/metrology/test_life_sets.py"),
    "arctrue long-run": (INSTRUMENT, "sim/tests/studies/long_run/test_long_run.py"),
    "arctrue stop-and-go": ("takes a minute", "sim/tests/studies/stop_and_go/test_stop_and_go.py"),
    "arctrue paper": (INSTRUMENT, "sim/tests/studies/paper/test_experiment.py"),
    "arctrue hidden": (INSTRUMENT, "sim/tests/studies/hidden_effect/test_subdivision.py"),
    "arctrue report": ("its test also reads the page", "sim/tests/report/test_analysis_report.py"),
    "arctrue serve": ("runs until it is stopped", "sim/tests/page/test_browser.py"),
    "arctrue run": (INSTRUMENT, "sim/tests/studies/scenario/test_run.py"),
}
"""Commands that another test runs. Each entry states why this module does not run the command, and
which test runs it."""
TARGETS = {
    "bitstream": ("takes hours to route a chip", "scripts/tests/device_build"),
    "compare-lanes": (
        "takes minutes; the named test tests parts of its script",
        "scripts/tests/synth/test_compare_lanes.py",
    ),
    "coverage-firmware": (
        "takes minutes; the named test tests how it counts",
        "scripts/tests/project/test_firmware_coverage.py",
    ),
    "coverage-gateware": (
        "takes hours; the named test tests how it counts",
        "scripts/tests/synth/test_gateware_coverage.py",
    ),
    "demo": (
        "takes five minutes; the named tests run its acts at a small size",
        "sim/tests/studies/demo",
    ),
    "docs": (
        "writes files; the named test compares them",
        "scripts/tests/project/test_documents.py",
    ),
    "firmware": ("the named test cross-compiles it", "sim/tests/firmware/test_qemu.py"),
    "flash": ("needs a board; the named tests use a substitute", "scripts/tests/flash"),
    "flash-bitstream": ("needs a board; the named tests use a substitute", "scripts/tests/flash"),
    "format": ("changes files; the lint is a part of make test", "Makefile"),
    "image": ("the named tests run its script", "scripts/tests/image"),
    "instrument": ("the named tests build the instrument", "sim/tests/instrument"),
    "mutate": (
        "takes hours; the named test checks its list",
        "scripts/tests/project/test_documents.py",
    ),
    "nightly": (
        "takes hours; the named test checks its record and page",
        "scripts/tests/project/test_nightly.py",
    ),
    "site": ("the named test builds it", "sim/tests/project/test_site.py"),
    "synth": ("takes an hour; the named tests run its parts", "scripts/tests/synth"),
    "test": ("runs this module itself", "Makefile"),
    "test-large": ("runs larger configurations of these tests", "Makefile"),
    "warming": (
        "takes minutes, or half an hour with SCALE=full",
        "sim/tests/studies/hidden_effect/test_thermal.py",
    ),
    "verify-bitstream": (
        "needs a routed chip; the named tests run its parts",
        "scripts/tests/device_build",
    ),
}
"""Targets of make in the documents. Each entry states why this module does not run the target, and
which test covers it."""


def lines_of(page: Path) -> Iterator[str]:
    """Yield the lines in a page's command blocks; a line that ends in \\ is joined with the next
    line."""
    for block in BLOCK.finditer(page.read_text(encoding="utf-8")):
        if block["language"] in ("sh", "console", ""):
            text = re.sub(r"\\\n\s*", "", block["text"])
            yield from (line.removeprefix("$ ") for line in text.splitlines())


def documented(program: str) -> list[tuple[str, str]]:
    """Return (page, command line without comment) for every call of ``program``."""
    found = []
    for page in PAGES:
        for line in lines_of(page):
            words = re.sub(r"\s+#.*$", "", line).removeprefix(".venv/bin/")
            if words.startswith(f"{program} "):
                found.append((page.name, words))
    return found


COMMANDS = documented("arctrue")
HERE = [
    (page, line)
    for page, line in COMMANDS
    if page not in FOLLOWED and " ".join(line.split()[:2]) not in ELSEWHERE
]


def test_the_commands_are_found() -> None:
    assert len(COMMANDS) > 40
    assert len(HERE) > 8
    assert len(documented("make")) > 15


@pytest.mark.parametrize(("page", "line"), COMMANDS, ids=lambda item: item)
def test_a_documented_command_has_these_words_and_options(page: str, line: str) -> None:
    """The command's own parser accepts each documented line, even if this module does not run
    it."""
    if "diganose" in line:
        pytest.skip("the example of a wrong name: it is run below")
    words = shlex.split(line)[1:]
    command: click.Command = main
    context = click.Context(main, info_name="arctrue", **main.context_settings)
    while isinstance(command, click.Group) and words and not words[0].startswith("-"):
        below = command.get_command(context, words[0])
        assert below is not None, f"{page}: {line}"
        command, context, words = below, click.Context(below, parent=context), words[1:]
    parser = command.make_parser(context)
    parser.parse_args(list(words))


@pytest.mark.parametrize("name", ELSEWHERE)
def test_what_is_run_elsewhere_is_run_there(name: str) -> None:
    _, place = ELSEWHERE[name]
    there = (ROOT / place).read_text(encoding="utf-8")
    assert name.split()[1].replace("-", "_") in there.replace("-", "_")


def test_targets_of_the_documents_are_tested_or_listed() -> None:
    used = {word for _, line in documented("make") for word in line.split()[1:2]}
    assert used <= set(TARGETS), used - set(TARGETS)
    for _, place in TARGETS.values():
        assert (ROOT / place).exists(), place


@pytest.fixture(scope="module")
def place(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Write small versions of the sets and files that the documents name."""
    folder = tmp_path_factory.mktemp("documented")
    made = simulate_set([], short(), seed=1).measurement
    assert made.capture is not None
    for name in ("FOLDER", "SET"):
        write_measurement_set(folder / name, made)
    write_measurement_set(folder / "my_table", replace(made, reference=None))
    write_measurement_set(folder / "polygon", replace(made, capture=None))
    az = np.arange(0.0, 360.0, 15.0)
    rows = [f"{x:.1f},{5.0 * np.cos(np.radians(x)):.3f}" for x in az]
    (folder / "scan.csv").write_text("\n".join(["Az,dAz", *rows]), encoding="utf-8")
    assert CliRunner().invoke(
        main, ["add", "hysteresis", str(folder / "SET"), "--model", str(folder / "model.toml")]
    )
    return folder


CODES = {"arctrue diganose my_table": 2}
"""Exit codes other than 0; only the example of a misspelt name has one."""
INSTEAD = {"EFFECT": "hysteresis"}
FEWER = {"--trials": "8", "--samples": "1500"}
"""Smaller sizes that replace the sizes on the page, for commands that simulate their own sets."""


def test_commands_of_the_documents_run(place: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Each command runs as printed, with these exceptions: FOLDER, SET, my_table and polygon are
    small sets, EFFECT is hysteresis, monte-carlo has the sizes of FEWER, import writes to the
    folder ``imported``, and join gets ``--times keep``."""
    monkeypatch.chdir(place)
    monkeypatch.setattr(_loaded_set.console, "width", 100)
    for page, line in HERE:
        words = [INSTEAD.get(word, word) for word in shlex.split(line)[1:]]
        if words[0] == "monte-carlo":
            words = [
                FEWER.get(before, word) for before, word in zip(["", *words], words, strict=False)
            ]
        if words[0] == "add":
            # The command in README creates the model.
            (place / "model.toml").unlink(missing_ok=True)
        if words[0] == "import":
            words[words.index("my_table")] = "imported"
        if words[0] == "join":
            words += ["--times", "keep"]
        done = CliRunner().invoke(main, words)
        assert done.exit_code == CODES.get(line, 0), f"{page}: {line}\n{done.output}"


def test_the_example_of_a_wrong_name_says_what_the_page_says() -> None:
    page = (DOCS / "installation.md").read_text(encoding="utf-8")
    (block,) = re.findall(r"\$ arctrue diganose my_table\n(.*?)```", page, re.DOTALL)
    done = CliRunner().invoke(main, ["diganose", "my_table"], prog_name="arctrue")
    assert done.stderr == block


PICTURES = {
    "alpha_maps.png": "docs/head-angle.md",
    "benchmark.svg": "docs/benchmark.md",
    "calibration_budget.svg": "docs/calibration-budget.md",
    "data_way.svg": "scripts/make_docs.py",
    "error_before_after.svg": "Makefile",
    "hidden_effect.svg": "Makefile",
    "long_run.svg": "docs/long-run.md",
    "methods.svg": "docs/methods.md",
    "page.png": "scripts/page_screenshot.py",
    "paper_fig_11.png": "docs/paper.md",
    **{
        f"paper_fig_{number}.svg": "docs/paper.md"
        for number in ("1", "3", "4", "5", "6", "7", "8", "9", "a1", "a2")
    },
    "real_motor.png": "scripts/make_workbench_pictures.py",
    "real_worm.png": "scripts/make_workbench_pictures.py",
    "revolution.svg": "docs/instrument.md",
    "stop_and_go.svg": "docs/stop-and-go.md",
    "tutorial_branches.png": "scripts/make_workbench_pictures.py",
    "tutorial_candidates.png": "scripts/make_workbench_pictures.py",
    "tutorial_history.png": "scripts/make_workbench_pictures.py",
    "tutorial_stranger.png": "scripts/make_workbench_pictures.py",
    "warming_recalibrated.svg": "docs/scenarios.md",
}
"""Pictures in the documents. Each entry names the script that makes the picture, or the page that
shows the command for it."""


DRAWINGS = "sim/arctrue/report/charts/paper_drawings.py"
PICTURES |= {f"paper_fig_{n}.svg": DRAWINGS for n in ("1", *"3456789", "a1", "a2")}


def test_every_picture_is_made_by_a_script_or_a_command() -> None:
    there = {path.name for path in (DOCS / "images").iterdir()}
    assert there == set(PICTURES)
    shown = "".join(page.read_text(encoding="utf-8") for page in PAGES)
    for name, place in PICTURES.items():
        assert f"images/{name}" in shown, f"{name} is on no page"
        text = (ROOT / place).read_text(encoding="utf-8")
        if place.endswith(".md"):
            assert re.search(r"arctrue [\w-]+ [^`\n]*docs/images", text), f"{place}: {name}"
        else:
            stem = re.sub(r"(?<=paper_fig_)(?!11)\w+$", "", Path(name).stem)
            assert stem in text, f"{place}: {name}"
