"""Tests of the commissioning page with the firmware's console and four heads."""

from __future__ import annotations

import os
import re
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from flask.testing import FlaskClient
from playwright.sync_api import Page, expect
from sim.tests.cli.test_commission import DEG_PER_S, PLAN, SKEW_NS, WORLD, TableDevice, connected
from sim.tests.firmware.emulator import PATIENCE_S
from sim.tests.firmware.test_heads import PLACES
from sim.tests.page.page_server import page_server

from arctrue.page.app import make_page
from arctrue.page.settings import PageSettings
from tests.page.in_browser import needs_browser, picture

PAGE = "/device/commissioning/"


@pytest.fixture
def device(monkeypatch: pytest.MonkeyPatch) -> Iterator[TableDevice]:
    with connected(monkeypatch) as made:
        yield made


@pytest.fixture
def client(device: TableDevice, tmp_path: Path) -> Iterator[FlaskClient]:
    settings = PageSettings(tmp_path, tmp_path / "state", device=device.port)
    with make_page(settings).app.test_client() as made:
        yield made


def taken(client: FlaskClient, step: str, places: str = "") -> str:
    """Run a step of the commissioning to its end and return the page."""
    assert client.post(f"{PAGE}{step}", data={"places": places}).status_code == 303
    until = time.monotonic() + PATIENCE_S
    while client.get(f"{PAGE}state").get_json()["running"]:
        assert time.monotonic() < until
        time.sleep(0.02)
    return client.get(PAGE).get_data(as_text=True)


def test_exchanged_cables_are_named_and_stop_the_walk(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """The page names the exchanged cables 3 and 4, and refuses the next step."""
    with connected(monkeypatch, cables=(0, 1, 3, 2)) as device:
        settings = PageSettings(tmp_path, tmp_path / "state", device=device.port)
        with make_page(settings).app.test_client() as client:
            html = taken(client, "connection", PLAN)
            assert "cable 3 is at head 4, cable 4 is at head 3" in html
            refused = client.post(f"{PAGE}forward")
            assert refused.status_code == 422
            assert "needs the steps before it" in refused.get_data(as_text=True)


def test_the_devices_table_of_the_heads_is_shown(client: FlaskClient, device: TableDevice) -> None:
    """Before any step the page shows order, sense and places as the firmware's console states
    them."""
    html = taken(client, "table")
    cells = [re.findall(r"<td>(.*?)</td>", row) for row in re.findall(r"<tr>(.*?)</tr>", html)]
    rows = [row for row in cells if len(row) == 11]
    device.stop()  # The thread would take a part of the answer.
    said = device.made.send("show heads").replace(" -", " –").splitlines()[1:-1]
    assert rows == [line.split() for line in said]
    assert [row[0] for row in rows] == ["1", "2", "3", "4"]
    assert [row[2] for row in rows] == ["seen"] * 4


@pytest.mark.large
def test_a_step_that_is_repeated_forgets_those_after_it(client: FlaskClient) -> None:
    assert "All heads are connected as planned" in taken(client, "connection", PLAN)
    html = taken(client, "forward")
    found = re.search(r"4000 samples at ([\d.]+)°/s", html)
    assert found is not None, html
    assert float(found[1]) == pytest.approx(DEG_PER_S, rel=1e-3)
    assert "°/s" not in taken(client, "connection", PLAN)


@pytest.mark.parametrize(
    ("places", "said"),
    [("0,64", "the device has 4 heads, the number of places is 2"), ("0,x", "expected degrees")],
)
def test_places_that_do_not_fit_are_refused(client: FlaskClient, places: str, said: str) -> None:
    answer = client.post(f"{PAGE}connection", data={"places": places})
    html = answer.get_data(as_text=True)
    if answer.status_code == 303:
        html = taken(client, "connection", places)
    assert said in html


def test_without_a_device_a_step_says_so(tmp_path: Path) -> None:
    settings = PageSettings(tmp_path, tmp_path / "state", device=str(tmp_path / "none"))
    with make_page(settings).app.test_client() as client:
        assert str(tmp_path / "none") in taken(client, "connection", PLAN)


@pytest.mark.large
@needs_browser
def test_places_and_skew_are_measured_and_written(
    device: TableDevice, page: Page, tmp_path: Path
) -> None:
    """The operator clicks through all steps; then the device has the true places and delays.

    The bound of a place is 100″, four times the largest stated u of 25″ (test of ``arctrue
    commission``); the bound of the skew is 20 ns.
    """
    os.close(device.far)  # The server is a separate program, which opens the port itself.
    with page_server(tmp_path, tmp_path / "state", "--device", device.port) as address:
        page.goto(f"{address}/device/")
        page.get_by_role("link", name="Commissioning").click()
        page.get_by_label("Places as planned").fill(PLAN)
        page.get_by_role("button", name="Read the heads").click()
        expect(page.locator("#connection")).to_contain_text("All heads are connected as planned")
        page.get_by_role("button", name="Capture a turn forward").click()
        expect(page.locator("#forward")).to_contain_text("4000 samples at")
        button = page.get_by_role("button", name="Capture a turn backward")
        rows = page.locator("#backward tbody tr")
        for _ in range(3):
            button.click()
            expect(rows.first.or_(page.locator("#problem:not(:empty)"))).to_be_visible()
            # On a busy machine the console may answer too late; then the test repeats the step.
            if rows.count():
                break
        expect(rows).to_have_count(4)
        expect(page.locator("#backward")).to_contain_text("Noise of the parity: 0.1")
        page.get_by_role("button", name="Write places and delays").click()
        expect(page.locator("#write")).to_contain_text("Written to the device;")
        picture(page, "commissioning")
    parameters = device.made.parameters()
    mounted = np.array(PLACES[4]) + np.array(WORLD.off_arcsec) / 3600.0
    names = ("separation_deg", "head3_deg", "head4_deg")
    written = [float(parameters[name]) for name in names]
    assert np.all(np.abs(np.array(written) - mounted[1:]) * 3600.0 <= 4.0 * 25.0)
    word = int(float(parameters["head_delays"]))
    delays_ns = [10.0 * (word >> 8 * head & 0xFF) for head in range(4)]
    assert np.all(np.abs(np.array(delays_ns) - (max(SKEW_NS) - np.array(SKEW_NS))) <= 20.0)
