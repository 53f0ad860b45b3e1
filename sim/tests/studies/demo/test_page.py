"""Tests that the demo's page needs no other file, and that page and command report a failure."""

import re
from dataclasses import replace
from html import unescape
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
from click import Context
from click.testing import CliRunner

from arctrue.cli import demo as command
from arctrue.cli import main
from arctrue.instrument import InstrumentError
from arctrue.instrument.turn_score import TurnScore
from arctrue.report.demo_page import page_templates, write_demo_page
from arctrue.studies.demo.files import ConsoleLine
from arctrue.studies.demo.judgement import RecordingError
from arctrue.studies.demo.result import DemoResult, LoadedHarmonic, UnitLatency
from arctrue.studies.demo.settings import DemoSettings
from arctrue.studies.demo.source_tree import DemoError
from arctrue.studies.demo.telemetry import ReportedTurn


def turn(amplitude_counts: float) -> TurnScore:
    angle = np.linspace(0, 2 * np.pi, 5000, endpoint=False)
    count_arcsec = DemoSettings().arcsec_per_count
    return TurnScore.of_edges(angle, amplitude_counts * count_arcsec * np.cos(angle))


@pytest.fixture
def result() -> DemoResult:
    return DemoResult(
        settings=DemoSettings(),
        before=turn(61.25),
        after=turn(0.0875),
        faults=(),
        latencies=(
            UnitLatency("phase calculation", 5, 5),
            UnitLatency("harmonic calculation", 20, 20),
            UnitLatency("error compensation", 4, 4),
        ),
        pin_to_pin_clocks=41,
        index_offset_counts=0.4,
        harmonics=(LoadedHarmonic(1, 61.2, -12.5, 0.02, 61.25, 0.0875),),
        turns=(
            ReportedTurn(
                clock=120_000,
                number=1,
                samples=4151,
                result="applied",
                reason="none",
                separation_deg=33.0012,
                u_separation_arcsec=2.5,
                noise_arcsec=5.71,
                active_arcsec=816.4,
                candidate_arcsec=0.4,
                alarms=(),
                harmonics=(),
            ),
        ),
        console=(
            ConsoleLine(0, True, "set orders 32"),
            ConsoleLine(0, False, "ok"),
            ConsoleLine(120_000, False, '{"turn":1,"samples":4151,"note":"<none>"}'),
        ),
        words_moved=9_876,
        edges_played=300_000,
        clocks_simulated=310_000,
        simulation_s=90.0,
        total_s=100.0,
        simulator="GHDL 2.0.0 (LLVM)",
    )


def test_page_needs_no_other_file(result: DemoResult, tmp_path: Path) -> None:
    page = tmp_path / "deep" / "index.html"
    write_demo_page(result, page)
    text = page.read_text(encoding="utf-8")
    references = re.findall(r'(?:src|href)="([^"]*)"', text)
    assert all(reference.startswith(("#", "data:")) for reference in references)
    assert "@import" not in text
    assert not re.search(r"url\((?!#)", text)
    assert len(text) < 1_000_000


def test_page_leads_to_the_page_of_four_heads(result: DemoResult, tmp_path: Path) -> None:
    """Both acts include the section that names the page and a command that exists."""
    write_demo_page(result, tmp_path / "index.html")
    text = (tmp_path / "index.html").read_text(encoding="utf-8")
    assert "<code>docs/heads.md</code>" in text
    assert (Path(__file__).resolve().parents[4] / "docs" / "heads.md").is_file()
    (command_line,) = re.findall(r"<code>\.venv/bin/arctrue (hidden [^<]*)</code>", text)
    hidden = main.get_command(Context(main), "hidden")
    assert hidden is not None
    assert hidden.make_context("hidden", command_line.split()[1:]).params["heads"] == "4"
    environment = page_templates()
    assert environment.loader is not None
    for name in ("demo.html.j2", "second_act.html.j2"):
        source = environment.loader.get_source(environment, name)[0]
        assert '{% include "what_next.html.j2" %}' in source


def test_page_leads_to_that_of_the_second_act(result: DemoResult, tmp_path: Path) -> None:
    write_demo_page(result, tmp_path / "index.html", "second_act.html")
    text = (tmp_path / "index.html").read_text(encoding="utf-8")
    assert re.findall(r'href="([^#"]*)"', text) == ["second_act.html"]


def test_page_holds_three_pictures_of_sound_xml(result: DemoResult, tmp_path: Path) -> None:
    write_demo_page(result, tmp_path / "index.html")
    pictures = re.findall(r"<svg.*?</svg>", (tmp_path / "index.html").read_text(), re.DOTALL)
    assert len(pictures) == 3
    for picture in pictures:
        ElementTree.fromstring(picture)
    assert "decoder 1" in pictures[0]
    assert "Output against the true angle" in pictures[1]
    assert "Orders of the error" in pictures[2]
    alone = ElementTree.parse(tmp_path / "error_before_after.svg").getroot()
    assert alone.tag == "{http://www.w3.org/2000/svg}svg"


def test_page_shows_the_console_line_by_line(result: DemoResult, tmp_path: Path) -> None:
    write_demo_page(result, tmp_path / "index.html")
    text = (tmp_path / "index.html").read_text()
    (console,) = re.findall(r'<pre class="console"[^>]*>(.*?)</pre>', text, re.DOTALL)
    lines = [unescape(re.sub(r"<[^>]*>", "", line)) for line in console.strip().split("\n")]
    assert [line.split(maxsplit=1) for line in lines] == [
        ["0", "> set orders 32"],
        ["0", "ok"],
        ["120,000", '{"turn":1,"samples":4151,"note":"<none>"}'],
    ]
    assert "33.0012° ± 2.5″" in text
    assert "9,876 words" in text


def test_page_states_figures_scale_and_verdict(result: DemoResult, tmp_path: Path) -> None:
    write_demo_page(result, tmp_path / "good.html")
    good = (tmp_path / "good.html").read_text()
    for words in ("Within the limits", "65,536", "16,777,216", "19.78″", "−61.2 … 61.2"):
        assert words in good
    write_demo_page(replace(result, faults=("order 3 is <left>",)), tmp_path / "bad.html")
    bad = (tmp_path / "bad.html").read_text()
    assert "Outside the limits" in bad
    assert "order 3 is &lt;left&gt;" in bad


def run_command(
    monkeypatch: pytest.MonkeyPatch, folder: Path, outcome: DemoResult | Exception
) -> tuple[int, str]:
    def instead(*_: object) -> DemoResult:
        if isinstance(outcome, Exception):
            raise outcome
        return outcome

    monkeypatch.setattr(command, "run_demo", instead)
    answer = CliRunner().invoke(main, ["demo", "--out", str(folder), "--act", "1"])
    return answer.exit_code, answer.output


def test_exit_code_follows_the_judgement(
    monkeypatch: pytest.MonkeyPatch, result: DemoResult, tmp_path: Path
) -> None:
    code, output = run_command(monkeypatch, tmp_path, result)
    assert code == 0
    assert "Within the limits" in output
    assert re.search(r"harmonic calculation +│ +20 │ +20", output)
    code, output = run_command(monkeypatch, tmp_path, replace(result, faults=("too large",)))
    assert code == 1
    assert "error: too large" in output
    for error in (DemoError("no rtl/ here"), RecordingError("no Z")):
        code, output = run_command(monkeypatch, tmp_path, error)
        assert code == 2
        assert f"error: {error}" in output


def test_one_act_that_cannot_run_leaves_the_other_its_page(
    monkeypatch: pytest.MonkeyPatch, result: DemoResult, tmp_path: Path
) -> None:
    def no_instrument(*_: object) -> None:
        raise InstrumentError("no netlist here")

    monkeypatch.setattr(command, "run_demo", lambda *_: result)
    monkeypatch.setattr(command, "run_second_act", no_instrument)
    answer = CliRunner().invoke(main, ["demo", "--out", str(tmp_path)])
    assert answer.exit_code == 2
    assert "error: second act: no netlist here" in answer.output
    assert (tmp_path / "index.html").exists()
    assert not (tmp_path / "second_act.html").exists()
