"""Tests of captures that the page takes in the background while the device waits for a turn of the
table."""

from __future__ import annotations

import threading
import time
from collections.abc import Iterator
from pathlib import Path

import pytest
from flask.testing import FlaskClient

from arctrue.device.console import ConsoleError
from arctrue.measurement import write_measurement_set
from arctrue.page.app import make_page
from arctrue.page.live_device import LiveDevice
from arctrue.page.settings import PageSettings
from tests.workbench.small_sets import measurement_set

END_S = 60.0
WAITS = '<button class="main" disabled>Taking a capture …</button>'


class NextTurn:
    """A stand-in for the next turn of the table: the turn comes when ``turned`` is set, and the
    capture returns or raises ``result``."""

    def __init__(self) -> None:
        self.turned = threading.Event()
        self.result: Path | Exception = ConsoleError("the table stands still")

    def capture(self, _: LiveDevice) -> Path:
        assert self.turned.wait(END_S)
        if isinstance(self.result, Exception):
            raise self.result
        return self.result


@pytest.fixture
def next_turn(monkeypatch: pytest.MonkeyPatch) -> NextTurn:
    made = NextTurn()
    monkeypatch.setattr(LiveDevice, "capture", lambda device: made.capture(device))
    return made


@pytest.fixture
def client(tmp_path: Path, next_turn: NextTurn) -> Iterator[FlaskClient]:
    settings = PageSettings(tmp_path, tmp_path / "state", device="/dev/table")
    with make_page(settings).app.test_client() as made:
        yield made
    next_turn.turned.set()


def ended(client: FlaskClient) -> None:
    """Wait until the page has finished its capture."""
    until = time.monotonic() + END_S
    while client.get("/device/state").get_json()["capture"]:
        assert time.monotonic() < until
        time.sleep(0.02)


def test_a_second_click_waits_for_the_same_capture(
    client: FlaskClient, next_turn: NextTurn, tmp_path: Path
) -> None:
    """The page answers each click at once, and a second click starts no second capture. When the
    table has turned, the page opens the capture as a session."""
    write_measurement_set(tmp_path / "capture", measurement_set(runs=1, cycles=1, turns=1))
    next_turn.result = tmp_path / "capture"
    address = client.post("/device/capture").location
    assert client.post("/device/capture").location == address
    waiting = client.get(address)
    assert waiting.status_code == 200
    assert WAITS in waiting.get_data(as_text=True)
    name = client.get("/device/state").get_json()["capture"]
    assert address.endswith(f"={name}")
    next_turn.turned.set()
    ended(client)
    opened = client.get(address)
    assert opened.status_code == 303
    assert opened.location == f"/s/{name}/1/"
    assert client.get(opened.location).status_code == 200
    assert client.post("/device/capture").location != address


@pytest.mark.parametrize(
    ("error", "said"),
    [
        (ConsoleError("the table stands still"), "the table stands still"),
        (ZeroDivisionError("a fault of the program"), "The program has a fault"),
    ],
)
def test_a_capture_that_fails_says_why_and_leaves_nothing(
    client: FlaskClient, next_turn: NextTurn, tmp_path: Path, error: Exception, said: str
) -> None:
    next_turn.result = error
    next_turn.turned.set()
    address = client.post("/device/capture").location
    ended(client)
    answer = client.get(address)
    assert answer.status_code == 422
    html = answer.get_data(as_text=True)
    assert said in html
    assert WAITS not in html
    assert list((tmp_path / "state").iterdir()) == []


def test_a_capture_of_an_earlier_server_is_no_capture(client: FlaskClient) -> None:
    answer = client.get("/device/?capture=0123456789abcdef")
    assert answer.status_code == 200
    assert WAITS not in answer.get_data(as_text=True)
