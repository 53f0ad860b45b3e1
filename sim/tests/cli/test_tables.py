"""Tests that the tables of all commands fit into 80 columns, without a cut cell or a broken
number."""

from __future__ import annotations

import ast
import re
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner
from rich.cells import cell_len
from sim.tests.workbench.small_sets import measurement_set

import arctrue.cli
from arctrue.cli import _loaded_set, main
from arctrue.cli._tables import WIDTH, live_head, number, table, words
from arctrue.cli._terminal import Console
from arctrue.measurement import write_measurement_set
from arctrue.studies.simulate.experiment import short
from arctrue.studies.simulate.simulated_set import simulate_set
from arctrue.workbench.model.model import HistoryStep

FOLDER = Path(arctrue.cli.__path__[0])
OF_A_TABLE = re.compile(r"^[│┃├┏└┡┌]")
HUGE = -1234567.891
"""A number wider than any figure that a command has printed so far."""


def assert_whole(text: str) -> None:
    """Assert that no line is longer than 80 columns, no cell is cut and no number is broken."""
    lines = [line for line in text.splitlines() if OF_A_TABLE.match(line)]
    assert lines, text
    assert max(map(cell_len, lines)) <= WIDTH, max(lines, key=cell_len)
    for line in lines:
        assert "…" not in line, line
        # A hyphen at the beginning of a number stands for a minus sign; in a date or a range a
        # digit precedes the hyphen.
        assert not re.search(r"(?<![\w.])-\d", line), line


def test_tables_are_made_in_one_place() -> None:
    for path in sorted(FOLDER.glob("*.py")):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            place = f"{path.name}, line {getattr(node, 'lineno', 0)}"
            if isinstance(node, ast.ImportFrom) and node.module == "rich.table":
                names = {item.name for item in node.names}
                # _ladder.py imports only the type, for an annotation.
                assert path.name == "_tables.py" or (path.name, names) == ("_ladder.py", {"Table"})
            if isinstance(node, ast.FormattedValue) and node.format_spec is not None:
                spec = ast.unparse(node.format_spec).strip("f'\"")
                assert not re.match(r"[<>^]?[1-9]\d*", spec), f"{place}: use table() for columns"


def test_a_number_is_not_broken_where_words_are_folded() -> None:
    made = table("t", words("w"), *(number("n") for _ in range(5)))
    made.add_row("word" * 30, *["−1,234.567"] * 5)
    console = Console(width=WIDTH)
    with console.capture() as got:
        console.print(made)
    assert got.get().count("−1,234.567") == 5
    assert_whole(got.get())


@pytest.fixture(scope="module")
def place(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("tables")
    write_measurement_set(folder / "both", measurement_set(cycles=6, turns=1))
    alone = simulate_set([], short(), seed=1).measurement
    write_measurement_set(
        folder / "alone", type(alone)(table=alone.table, reference=alone.reference)
    )
    (folder / "stations.csv").write_text(
        "a very long name of a column and even longer [deg],its error against the truth [arcsec]\n"
        + "".join(f"{15 * i},{-i / 7}\n" for i in range(24))
    )
    return folder


WORDS = {
    "compare": ["compare", "both"],
    "diagnose": ["diagnose", "both"],
    "add": ["add", "hysteresis", "both", "--model", "m.toml"],
    "history": ["history", "--model", "m.toml"],
    "drop": ["drop", "hysteresis", "both", "--model", "m.toml"],
    "effects": ["effects"],
    "simulate": ["simulate", "--list"],
    "effects check": ["effects", "check", "effects/oval.py", "--set", "both"],
    "export": ["export", "both", "--coefficients", "c.toml", "--force"],
    "calibrate": ["calibrate", "both", "--out", "cal", "--orders", "120"],
    "calibrate from a reference run": ["calibrate", "alone", "--out", "cal", "--force"],
    "iso230": ["iso230", "alone", "--drift", "0.1"],
    "budget": ["budget", "both"],
    "join": ["join", "both", "alone", "joined", "--times", "after", "--common-columns"],
    "import": [
        *("import", "stations.csv", "imported", "--column", "target=1", "--column", "error=2"),
        *("--sign", "reading-true"),
    ],
}
"""Commands that print tables; earlier commands write the inputs of later ones."""


def test_tables_of_the_workbench(place: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(place)
    monkeypatch.setenv("COLUMNS", str(WIDTH))
    monkeypatch.setattr(_loaded_set.console, "width", WIDTH)
    assert CliRunner().invoke(main, ["effects", "new", "oval"]).exit_code == 0
    for name, typed in WORDS.items():
        done = CliRunner().invoke(main, typed)
        assert done.exit_code in (0, 1), f"{name}: {done.output}"
        assert_whole(done.stdout)


def printed(monkeypatch: pytest.MonkeyPatch, what: Any, *arguments: Any) -> str:
    """Return the text that a command prints for the given result."""
    monkeypatch.setattr(_loaded_set.console, "width", WIDTH)
    with _loaded_set.console.capture() as got:
        what(*arguments)
    return got.get()


def curve() -> SimpleNamespace:
    return SimpleNamespace(
        lowest_arcsec=HUGE / 1e3,
        highest_arcsec=-HUGE / 1e3,
        rms_arcsec=-HUGE / 1e3,
        every_edge_arcsec=(HUGE / 1e3, -HUGE / 1e3),
        largest_order=120,
        edges_rms_arcsec=1234.5678,
        mean_arcsec=HUGE / 1e3,
        amplitude_arcsec=np.full(40, 1234.5678),
    )


def test_tables_of_the_instrument(monkeypatch: pytest.MonkeyPatch) -> None:
    """The tables of the instrument's commands fit even with figures larger than any real result."""
    from arctrue.cli import demo, hidden, paper, revolution, run

    scale = SimpleNamespace(
        heads=2,
        counts_per_rev=1 << 24,
        arcsec_per_count=0.0772,
        lanes=32,
        alpha_error_arcsec=50.0,
        noise_arcsec=0.2,
    )
    turned = SimpleNamespace(
        settings=scale,
        telemetry={"samples": 12000},
        applied_orders=20,
        before=curve(),
        after=curve(),
        clocks=40_463_743,
        wall_s=148.0,
        faults=(),
        limit_arcsec=0.3,
    )
    assert_whole(printed(monkeypatch, revolution._print, turned))

    orders = tuple(range(1, 4))
    turn = SimpleNamespace(
        number=100,
        temperature_c=-12.25,
        uncorrected=curve(),
        corrected=curve(),
        reference=curve(),
        events=["the index is lost"],
        telemetry=[],
        flags=[],
    )
    story = SimpleNamespace(title="A story", orders=orders, scale=scale, arcsec_per_count=0.0772)
    ran = SimpleNamespace(scenario=story, turns=[turn], applied=1, refused=0, clocks=1, wall_s=1.0)
    assert_whole(printed(monkeypatch, run._print, ran))

    warm = SimpleNamespace(temperature_c=22.25, order1_arcsec=HUGE / 1e3)
    assert_whole(
        printed(monkeypatch, hidden._print_followed, {"the way of the firmware": [warm] * 4})
    )

    step = HistoryStep(
        action="add",
        effect="thermal_eccentricity_and_more",
        rms_arcsec={"reference": 1234.5678},
        heldout_rms_arcsec={"reference": 1234.5678},
        peak_arcsec={"reference": 1234.567},
        noise_arcsec={"reference": 1234.5678},
    )
    found = SimpleNamespace(
        case=SimpleNamespace(
            title="something", judged_order=1, local_table=False, real_orders=False, lines=()
        ),
        diagnosed=SimpleNamespace(ladder=[step], effect_file=None),
        settings=SimpleNamespace(revolution=scale),
        raw=curve(),
        paper=curve(),
        corrected=curve(),
        raw_period=curve(),
        paper_period=curve(),
        corrected_period=curve(),
        fresh_capture_arcsec={"without": 1.0, "with": 0.5},
        reversal_arcsec=None,
        judged_arcsec=lambda: {"paper": HUGE, "unit_left_out": HUGE, "corrected": HUGE},
        export=SimpleNamespace(
            left_out=[], followed=["order 12: the temperature"], local=[], real=[]
        ),
        clocks=1,
        simulating_s=1.0,
        workbench_s=1.0,
        folder="f",
    )
    assert_whole(printed(monkeypatch, hidden.print_result, found))

    reported = SimpleNamespace(
        number=12,
        result="refused",
        reason="coefficients_do_not_fit_this_turn",
        active_arcsec=-HUGE,
        candidate_arcsec=-HUGE,
    )
    shown = SimpleNamespace(
        settings=SimpleNamespace(
            arcsec_per_count=20.0, peak_limit_counts=2.0, order_limit_counts=1.0
        ),
        before=curve(),
        after=curve(),
        pin_to_pin_clocks=40,
        turns=[reported],
        passed=True,
        latencies=[
            SimpleNamespace(unit="harmonic calculation", measured_clocks=20, paper_clocks=20)
        ],
        clocks_simulated=1,
        simulation_s=1.0,
        total_s=1.0,
    )
    assert_whole(printed(monkeypatch, demo._print_result, shown))

    budget = {
        "polygon_arcsec": 0.1,
        "autocollimator_arcsec": 0.05,
        "repeatability_arcsec": 0.2,
        "combined_arcsec": 0.2,
        "mounting_eccentricity_arcsec": 0.003,
        "tower_difference_arcsec": 0.003,
        "expanded_arcsec": 0.46,
    }
    span = {"span_arcsec": [HUGE, -HUGE], "deviation_arcsec": [0.2]}
    made = {
        "published": {
            "faces": 24,
            "before_arcsec": [HUGE, 1.0],
            "after_arcsec": [-1.3, 1.6],
            "combined_arcsec": 0.23,
            "largest_deviation_arcsec": 0.2,
            "expanded_arcsec": 0.46,
            "budget": budget,
        },
        "budget": budget,
        "before": span,
        "after": span,
        "residual_orders_arcsec": [0.1],
        "clocks": 1,
        "settings": {"cycles": 10, "revolution": {"lines": 16384, "interpolation": 1024}},
        "applied_orders": 20,
        "refused_turns": 0,
        "wall_s": 1.0,
    }
    assert_whole(printed(monkeypatch, paper._print, made))


def test_lines_of_the_monitor_are_short() -> None:
    from arctrue.cli.monitor import _HEAD, _row
    from arctrue.device.console import TelemetryLine

    turn = TelemetryLine(
        {
            "turn": 99999,
            "result": "refused",
            "reason": "speed_out_of_range",
            "separation_deg": 33.012345678,
            "noise_arcsec": 12.345,
            "active_arcsec": 123.456,
            "temperature_c": 85.25,
            "harmonics": [[1, 150.123]],
            "alarms": ["head1", "head2"],
        }
    )
    assert len(_HEAD) <= WIDTH
    first, alarm = _row(turn).splitlines()
    assert len(first) <= WIDTH
    assert "150.123" in first
    assert alarm.strip() == "alarm: head1, head2"


def test_lines_of_the_probe_are_short() -> None:
    from arctrue.cli.probe import COLUMNS, _row
    from arctrue.device.probe import Latch

    row = _row(Latch(65535, 1e6, -(2**31), 359.9999999, 65535))
    assert len(live_head(COLUMNS)) <= WIDTH
    assert len(row) <= WIDTH
    assert row.split()[2] == "−2,147,483,648"
