"""Tests that page and reports show markup in titles, names and contents of files as text.

If a browser interpreted the texts, it would make two elements of them. The first element can be
found on the page; the second one leads to another page.
"""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from matplotlib.figure import Figure
from playwright.sync_api import Page, expect
from sim.tests.page.page_server import page_server

from arctrue.cli import main
from arctrue.measurement import MeasurementSet, write_measurement_set
from arctrue.report.document import Document, Picture, Rows, Text, write_document
from arctrue.workbench.effects.new_effect import write_new_effect
from tests.page.in_browser import all_drawn, needs_browser, picture
from tests.workbench.small_sets import measurement_set, paper_error

pytestmark = needs_browser

MARK = "<i data-evil>x</i>"
LEADS_AWAY = '<meta http-equiv="refresh" content="0;url=data:,gone">'
EVIL = f"""'"><svg data-evil onload="document.title='evil'"></svg>{MARK}&lt;{LEADS_AWAY}"""
FOLDER = "<i data-evil>x<meta http-equiv=refresh content=0;url=data:,gone>\"'&amp;"
"""Markup in the name of a folder, which cannot contain a slash."""
COLUMN = "%{meta.words}<b data-evil>warm</b><a href='http://evil.example'>hub"
"""Markup in the name of a column. plotly.js interprets the elements b and a in its texts, and
replaces a name by the content of "meta"."""
LOOKS_MS = 700
"""Time in milliseconds after which the page is checked. The markup would lead to another page after
0 s."""


def evil_set() -> MeasurementSet:
    made = measurement_set(paper_error, runs=2, cycles=2, turns=1, reversal_arcsec=2.0)
    assert made.capture is not None
    rows = made.capture.head1_counts.size
    capture = dataclasses.replace(made.capture, conditions={COLUMN: np.linspace(0.0, 1.0, rows)})
    return dataclasses.replace(made, capture=capture, title=EVIL)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Write sets with markup in the title, the folder's name, a column's name and a faulty value;
    also write an effect with markup in its texts."""
    made = tmp_path_factory.mktemp("markup")
    write_measurement_set(made / "sets" / FOLDER, evil_set())
    broken = made / "sets" / f"broken {FOLDER}"
    broken.mkdir()
    (broken / "measurement.toml").write_text(f"schema = '''{EVIL}'''\n", encoding="utf-8")
    (made / "effects").mkdir()
    write_new_effect("evil_effect", made / "effects")
    file = made / "effects" / "evil_effect.py"
    text = file.read_text(encoding="utf-8")
    for name in ("physics", "next_measurement", "separated_by"):
        text = re.sub(rf'    {name} = ".*"', lambda _, n=name: f"    {n} = {EVIL!r}", text)
    text = text.replace('return ["cos", "sin"]', f'return ["cos {MARK}", "sin {MARK}"]')
    file.write_text(text, encoding="utf-8")
    return made


@pytest.fixture(scope="module")
def server(folder: Path) -> Iterator[str]:
    effects = ("--effects", str(folder / "effects"))
    with page_server(folder / "sets", folder / "state", *effects) as address:
        yield address


def harmless(page: Page) -> None:
    """Expect that the browser has made no element and no link from the texts, and that it still
    shows the same page."""
    address = page.url
    page.wait_for_timeout(LOOKS_MS)
    assert page.url == address
    expect(page.locator("[data-evil]")).to_have_count(0)
    expect(page.locator("meta[http-equiv=refresh]")).to_have_count(0)
    expect(page.locator('a[*|href^="http://evil"], a[href^="http://evil"]')).to_have_count(0)
    assert page.title() != "evil"


def open_evil(page: Page, server: str) -> None:
    page.goto(server)
    harmless(page)
    expect(page.locator("#choose")).to_contain_text(EVIL)
    expect(page.locator("#choose")).to_contain_text(f"broken {FOLDER}")
    page.locator("#choose button").first.click()
    page.wait_for_url(re.compile(r"/s/[0-9a-f]{16}/1/$"))


@pytest.mark.large
def test_the_page_shows_markup_as_text(server: str, page: Page, tmp_path: Path) -> None:
    open_evil(page, server)
    all_drawn(page)
    harmless(page)
    expect(page.locator("#set")).to_contain_text(EVIL)
    expect(page.locator("#set .command, #fit .command").first).to_contain_text("data-evil")
    assert EVIL in page.title()
    page.wait_for_selector("main[data-state=done]")
    page.locator("select[name=against]").select_option(COLUMN)
    page.wait_for_url(re.compile(r"against="))
    all_drawn(page)
    harmless(page)
    expect(page.locator("#plot-residual_against .xtitle").first).to_have_text(COLUMN)
    picture(page, "markup")

    # The model file has markup in its history and in its table, and it names an effect that no
    # catalogue has.
    model = page.request.get(f"{page.url.split('?')[0]}model.toml").text()
    harm = tmp_path / "model.toml"
    harm.write_text(
        re.sub(
            r'(?m)^(action|effect|program|date) = ".*"', lambda m: f"{m[1]} = '''{EVIL}'''", model
        ),
        encoding="utf-8",
    )
    page.get_by_label("Load a model").set_input_files(harm)
    page.get_by_role("button", name="Load", exact=True).click()
    page.wait_for_url(re.compile(r"/2/"))
    all_drawn(page)
    harmless(page)
    expect(page.locator("#ladder table")).to_contain_text(EVIL)
    expect(page.locator("#plot-ladder .xtick").first).to_contain_text("<svg data-evil")

    harm.write_text(f"schema = 1\n[[effect]]\nname = '''{EVIL}'''\n", encoding="utf-8")
    page.get_by_label("Load a model").set_input_files(harm)
    page.get_by_role("button", name="Load", exact=True).click()
    expect(page.locator("#ladder .problem").last).to_contain_text("data-evil")
    harmless(page)


def test_files_that_are_dropped_in_are_named_as_text(
    server: str, page: Page, tmp_path: Path
) -> None:
    page.goto(server)
    file = tmp_path / f"{FOLDER}.csv"
    file.write_text(f"{MARK},{LEADS_AWAY}\n1,2\n3,4\n5,6\n7,8\n", encoding="utf-8")
    page.get_by_label("Files").set_input_files(file)
    page.get_by_role("button", name="Read them").click()
    expect(page.locator("#dropin .problem").first).not_to_be_empty()
    harmless(page)
    expect(page.locator("#dropin")).to_contain_text("data-evil")


def test_addresses_that_are_not_there_are_shown_as_text(server: str, page: Page) -> None:
    # The browser prints a missing page on its console, which would fail the test; therefore the
    # test sends plain requests.
    for address in (f"/s/{MARK}/1/", f"/{MARK}", f"/s/0123456789abcdef/1/figure/{MARK}.json"):
        answer = page.request.get(server + address)
        assert answer.status == 404
        assert "<i data-evil" not in answer.text()


@pytest.mark.large
def test_the_report_shows_markup_as_text(folder: Path, page: Page, tmp_path: Path) -> None:
    words = ["report", str(folder / "sets" / FOLDER), "--out", str(tmp_path / "out")]
    words += ["--effects", str(folder / "effects"), "--against", COLUMN]
    answer = CliRunner().invoke(main, words)
    assert answer.exit_code == 0, answer.output
    page.goto((tmp_path / "out" / "report.html").as_uri())
    harmless(page)
    expect(page.locator("#set")).to_contain_text(EVIL)
    expect(page.locator("#where")).to_contain_text(COLUMN)
    for svg in sorted((tmp_path / "out").glob("*.svg")):
        page.goto(svg.as_uri())
        harmless(page)


@pytest.mark.large
def test_a_printed_report_shows_markup_as_text(page: Page, tmp_path: Path) -> None:
    figure = Figure()
    figure.subplots().set_title(EVIL)
    blocks = [Text(EVIL), Rows(EVIL, [EVIL, "value"], [[EVIL, EVIL]]), Picture(EVIL, figure)]
    paths = write_document(Document(EVIL, [(EVIL, EVIL)], blocks), tmp_path, "printed")
    markdown, html = paths[0].read_text(encoding="utf-8"), paths[1]
    page.goto(html.as_uri())
    harmless(page)
    expect(page.locator("h1")).to_have_text(EVIL)
    # A reader of Markdown would interpret HTML in the text.
    assert "<" not in markdown
    linked = Document("[x](http://evil.example)", [], [])
    assert "](" not in write_document(linked, tmp_path, "linked")[0].read_text(encoding="utf-8")


@pytest.mark.large
def test_no_chart_can_be_sent_to_another_server(server: str, page: Page) -> None:
    asked: list[str] = []
    page.on("request", lambda request: asked.append(request.url))
    open_evil(page, server)
    all_drawn(page)
    plots = page.locator(".plot")
    assert plots.count() >= 6
    for plot in plots.all():
        plot.hover()
        titles = [
            button.get_attribute("data-title") for button in plot.locator(".modebar-btn").all()
        ]
        assert "Download plot as a PNG" in titles
        for title in titles:
            assert title is not None
            assert not re.search("share|cloud|edit|plotly", title, re.IGNORECASE), title
    assert page.locator("[data-plotlyjs-cloud], .modebar-btn--logo").count() == 0
    assert {url.split("/")[2] for url in asked if url.startswith("http")} == {server.split("/")[2]}
