"""Tests in a real browser of the page of a running device, and of its captures.

Drift, heat and a fault come from replayed telemetry; the captures come from the compiled firmware.
"""

from __future__ import annotations

import os
import re
from collections.abc import Iterator
from pathlib import Path

import pytest
from playwright.sync_api import Page, expect
from sim.tests.cli.test_monitor import COUNTS, Device
from sim.tests.device.daemon_process import Replay, announcement, daemon
from sim.tests.page.page_server import page_server

from arctrue.device.announcement import FOLDER_VARIABLE
from arctrue.device.connection import ask
from arctrue.measurement import read_measurement_set
from tests.page.in_browser import needs_browser, picture

pytestmark = needs_browser
U = 0.02


@pytest.fixture(autouse=True)
def run_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Give the daemon a separate folder for its announcement."""
    monkeypatch.setenv(FOLDER_VARIABLE, str(tmp_path / "run"))


@pytest.fixture
def replay() -> Replay:
    return Replay()


@pytest.fixture
def device(monkeypatch: pytest.MonkeyPatch) -> Iterator[Device]:
    made = Device()
    os.close(made.far)  # The daemon is a separate program, which opens the port itself.
    with made.running(monkeypatch):
        yield made


def send_turn(replay: Replay, number: int, *, swaps: int, heat_k: float, drift: float) -> None:
    harmonics = [[1, 150.0 + drift, 0.4, U, 1], [2, 6.0, -2.0, U, 1], [5, 1.5, 1.0, U, 0]]
    replay.turn(
        number,
        swaps=swaps,
        harmonics=harmonics,
        temperature_c=40.0 + heat_k,
        table_c=21.0 + 0.2 * heat_k,
        separation_deg=33.0 + heat_k / 3600.0,
        u_separation_arcsec=0.01,
        noise_arcsec=0.3,
        alarms=["head2_index_lost"] if number == 30 else [],
    )


@pytest.mark.large
def test_drift_heat_and_a_fault_are_shown(replay: Replay, page: Page, tmp_path: Path) -> None:
    store = tmp_path / "store"
    with (
        daemon(replay.port, store, "--no-alarm-capture") as running,
        page_server(tmp_path, tmp_path / "state", "--device", replay.port) as address,
    ):
        page.goto(f"{address}/")
        page.get_by_role("link", name="live").click()
        for number in range(10):
            send_turn(replay, number, swaps=0, heat_k=0.0, drift=9.0)
        for number in range(10, 31):
            step = number - 10
            send_turn(replay, number, swaps=1, heat_k=0.25 * step, drift=0.05 * step)
            page.wait_for_timeout(50)
        main = page.locator("main")
        expect(main).to_have_attribute("data-turn", "30")
        # The present coefficients have been active since turn 10, so that the change of 9
        # arcseconds before it does not count.
        expect(page.locator("#since")).to_contain_text("Since turn 10 ")
        changed = page.locator("#changed tbody tr", has_text="changed")
        expect(changed).to_have_count(2)
        expect(changed.nth(0)).to_contain_text("head separation5.000″")
        expect(changed.nth(1)).to_contain_text("order 11.000″0.028″")
        expect(page.locator("#changed tbody")).to_contain_text("temperature, die5.0 °C")
        expect(page.locator("#alarm-list")).to_have_text("head2_index_lost")
        expect(page.locator("#events")).to_contain_text("new alarm: head2_index_lost")
        for chart in ("orders", "separation", "temperatures"):
            expect(page.locator(f"#chart-{chart} .main-svg").first).to_be_visible()
        expect(page.locator("#chart-orders .legendtext")).to_have_text(
            ["order 1", "order 2", "order 5"]
        )
        picture(page, "device")
        # Order 1 was 9 arcseconds larger before turn 10. Since then it has grown by 1 arcsecond.
        page.get_by_label("since").select_option("first")
        expect(page.locator("#since")).to_contain_text("Since turn 0 ")
        expect(changed.nth(1)).to_contain_text("order 18.000″0.028″")
        page.get_by_label("since").select_option("calibration")
        expect(changed.nth(1)).to_contain_text("order 11.000″0.028″")
        # A refused turn has no orders; the page keeps the orders of the turn before.
        replay.turn(31, swaps=1, result="refused", reason="noise", harmonics=[])
        expect(main).to_have_attribute("data-turn", "31")
        expect(changed).to_have_count(2)
        # The alarm of the earlier turn is over.
        expect(page.locator("#alarm-list")).to_have_text("none")
        ask(announcement(replay.port), "life", alarms={"hysteresis.a": "ALARM: <b>it</b> passes."})
        expect(page.locator("#machine-alarms li")).to_have_text("ALARM: <b>it</b> passes.")
        expect(page.locator("#events")).to_contain_text("history of the machine: ALARM")
        page.get_by_role("button", name="Dark or light").click()
        page.set_viewport_size({"width": 390, "height": 844})
        wide = page.evaluate("document.documentElement.scrollWidth - innerWidth")
        assert wide <= 0
        page.wait_for_timeout(3_000)  # The charts are drawn once a second.
        picture(page, "device_phone_dark")
        running.process.kill()
        expect(page.locator("#lost")).to_contain_text("no daemon runs")


@pytest.mark.large
def test_the_heads_of_a_mean_are_shown(replay: Replay, page: Page, tmp_path: Path) -> None:
    """The page shows the figures of each head whose reading enters the mean of four heads. The keys
    of the replayed telemetry are those of the compiled firmware."""
    with (
        daemon(replay.port, tmp_path / "store", "--no-alarm-capture"),
        page_server(tmp_path, tmp_path / "state", "--device", replay.port) as address,
    ):
        page.goto(f"{address}/device/")
        replay.turn(1, harmonics=[])
        expect(page.locator("main")).to_have_attribute("data-turn", "1")
        expect(page.locator("#heads")).to_be_hidden()
        of_heads = {
            "places_deg": [0.0, 64.31, 176.99, 257.91],
            "u_places_arcsec": [0.0, 20.2, 20.1, 20.3],
            "radii": [1.0, 1.001, 0.999, 1.0005],
            "u_radii": [0.0, 0.001, 0.001, 0.001],
            "head_residual_arcsec": [0.5, 0.6, 0.7, 0.8],
            "axis_forward_arcsec": [0.0, 0.4, 0.1, 0.2],
            "axis_backward_arcsec": [0.2, 0.1, 0.3, 0.1],
            "axis_asynchronous_arcsec": 0.7284,
            "u_axis_asynchronous_arcsec": 0.0312,
            "late_ns": [0.0, 12.34, -3.21, 0.5],
            "u_late_ns": 0.44,
        }
        replay.turn(2, harmonics=[], parity_counts=-3.5, left_out=[3], active_set=3, **of_heads)
        expect(page.locator("main")).to_have_attribute("data-turn", "2")
        rows = page.locator("#heads section").first.locator("tbody tr")
        expect(rows).to_have_count(4)
        expect(rows.nth(1)).to_have_text("264.3100°20.2″1.0010000.00100012.3 ns0.600″in use")
        expect(rows.nth(2)).to_contain_text("left out")
        expect(page.locator("#heads-note")).to_have_text(
            "From turn 2. Parity: -3.5 counts. u of a delay: 0.4 ns."
        )
        expect(page.locator("#axis-note")).to_have_text(
            "Motion that does not repeat: 0.728″ RMS, u 0.031″."
        )
        expect(page.locator("#axis-circles tbody tr").nth(1)).to_have_text("20.400″0.100″")
        # Head 3 is dead: the turn has no places, and the page keeps the places of turn 2.
        replay.turn(3, result="refused", reason="stands_still", harmonics=[], left_out=[3])
        expect(page.locator("main")).to_have_attribute("data-turn", "3")
        expect(rows.nth(2)).to_contain_text("left out")


def test_the_delays_of_two_heads_are_shown(replay: Replay, page: Page, tmp_path: Path) -> None:
    """A device that corrects head 1 sends delays but no places."""
    with (
        daemon(replay.port, tmp_path / "store", "--no-alarm-capture"),
        page_server(tmp_path, tmp_path / "state", "--device", replay.port) as address,
    ):
        page.goto(f"{address}/device/")
        replay.turn(1, late_ns=[0.0, -12.34], u_late_ns=0.44)
        expect(page.locator("main")).to_have_attribute("data-turn", "1")
        rows = page.locator("#heads section").first.locator("tbody tr")
        expect(rows).to_have_text(["1––––0.0 ns–in use", "2––––-12.3 ns–in use"])
        expect(page.locator("#heads-note")).to_have_text("From turn 1. u of a delay: 0.4 ns.")


@pytest.mark.large
def test_a_click_captures_and_diagnoses(device: Device, page: Page, tmp_path: Path) -> None:
    store, state = tmp_path / "store", tmp_path / "state"
    with (
        daemon(device.port, store),
        page_server(tmp_path, state, "--device", device.port) as address,
    ):
        page.goto(f"{address}/device/")
        expect(page.locator("main")).to_have_attribute("data-turn", re.compile(r"^\d+$"))
        page.get_by_role("button", name="Take a capture").click()
        page.wait_for_url(re.compile(r"/s/[0-9a-f]{16}/1/$"))
        expect(page.locator("#set")).to_contain_text(f"{COUNTS.shape[1]:,}")
        expect(page.locator("#ranking")).to_be_attached()
        picture(page, "device_capture")
        (kept,) = state.glob("*/set")
        (taken,) = (store / "captures").iterdir()
        ours, theirs = (read_measurement_set(path).capture for path in (kept, taken))
        assert ours is not None
        assert theirs is not None
        assert ours.head1_counts.tolist() == theirs.head1_counts.tolist()


@pytest.mark.large
def test_without_a_daemon_a_capture_is_refused_in_a_sentence(page: Page, tmp_path: Path) -> None:
    with page_server(tmp_path, tmp_path / "state", "--device", "/dev/nothing") as address:
        page.goto(f"{address}/device/")
        page.get_by_role("button", name="Take a capture").click()
        expect(page.locator("#problem")).to_contain_text("/dev/nothing: no daemon runs")
        assert not list((tmp_path / "state").glob("*/set"))
