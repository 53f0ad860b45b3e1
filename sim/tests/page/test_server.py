"""Tests which machines can reach the server, and which coefficients the server loads into a
device."""

from __future__ import annotations

import socket
from pathlib import Path
from typing import Any

import pytest
from click.testing import CliRunner
from flask import Flask

from arctrue.cli import main
from arctrue.gateware.coefficient_file_text import coefficient_file_text
from arctrue.gateware.coefficients import Coefficients
from arctrue.page import device, server
from arctrue.page.settings import PageSettings

COUNTS_PER_REV = 1 << 24


class Stub:
    """A stand-in for waitress that accepts the application and serves no request."""

    def __init__(self, app: Flask, sockets: list[Any], **_: Any) -> None:
        self.app, self.socket = app, sockets[0]
        Stub.latest = self

    latest: Stub

    def run(self) -> None:
        self.address = self.socket.getsockname()

    def close(self) -> None:
        self.socket.close()


def served(monkeypatch: pytest.MonkeyPatch, tmp_path: Path, host: str) -> tuple[list[str], Stub]:
    monkeypatch.setattr(server, "create_server", Stub)
    said: list[str] = []
    server.serve(PageSettings(tmp_path, tmp_path / "state"), host, 0, said.append)
    return said, Stub.latest


def test_it_serves_this_machine_alone(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    said, stub = served(monkeypatch, tmp_path, "127.0.0.1")
    host, port = stub.address
    assert host == "127.0.0.1"
    assert said == [f"serving http://127.0.0.1:{port}/  (Ctrl-C ends it)"]
    client = stub.app.test_client()
    assert client.get("/", base_url=f"http://localhost:{port}").status_code == 200
    assert client.get("/", base_url=f"http://table.example:{port}").status_code == 403


def test_others_are_warned_of_and_need_the_token(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    said, stub = served(monkeypatch, tmp_path, "0.0.0.0")
    assert said[0].startswith("warning: 0.0.0.0 can be reached by other machines")
    address = said[1].split()[1]
    token = address.partition("?token=")[2]
    assert len(token) >= 24  # The token has 18 random bytes.
    client = stub.app.test_client()
    assert client.get("/").status_code == 403
    assert client.get(f"/?token={token}", follow_redirects=True).status_code == 200
    other, _ = served(monkeypatch, tmp_path, "0.0.0.0")
    assert token not in other[1]


class FakeConsole:
    """A device that accepts every command."""

    lines: list[str]

    def __init__(self, port: str) -> None:
        self.port = port
        FakeConsole.lines = []

    def command(self, line: str) -> list[str]:
        self.lines.append(line)
        return ["load active", "loaded_order 1", "loaded_order 3"] if line == "load status" else []

    def close(self) -> None:
        self.lines.append("closed")


def lanes(objections: list[str]) -> dict[str, Any]:
    coefficients = Coefficients.from_harmonics([1, 3], [900.0, 4.0], [0.1, 0.2], COUNTS_PER_REV, 32)
    return {
        "orders": [1, 3],
        "objections": objections,
        "file": coefficient_file_text(coefficients),
    }


def test_lanes_are_loaded(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(device, "open_console", lambda port, _: FakeConsole(port))
    said = device.load_into_device("/dev/fake", lanes([]), force=False)
    assert said == "2 orders are loaded and active."
    frames = [line for line in FakeConsole.lines if line.startswith("load lane")]
    assert [frame.split()[3] for frame in frames] == ["1", "3"]
    assert FakeConsole.lines[-1] == "closed"


@pytest.mark.parametrize(
    ("port", "coefficients", "said"),
    [
        ("", lanes([]), "start the page with --port"),
        ("/dev/fake", lanes(["it gets worse"]), "not loaded: it gets worse"),
        ("/dev/fake", {"refused": "no counts"}, "no coefficients"),
        ("/dev/is/not/there", lanes([]), "cannot be opened"),
    ],
)
def test_what_cannot_be_loaded_says_why(port: str, coefficients: dict[str, Any], said: str) -> None:
    with pytest.raises(ValueError, match=said):
        device.load_into_device(port, coefficients, force=False)


def test_an_address_that_cannot_be_taken_says_what_to_do(tmp_path: Path) -> None:
    def message_for(*options: str) -> str:
        words = ["serve", str(tmp_path), "--state", str(tmp_path / "state"), *options]
        answer = CliRunner().invoke(main, words)
        assert answer.exit_code == 2
        assert "Errno" not in answer.stderr
        return " ".join(answer.stderr.split())

    with socket.create_server(("127.0.0.1", 0)) as other:
        port = other.getsockname()[1]
        said = message_for("--http-port", str(port))
        assert f"port {port} of 127.0.0.1 is in use" in said
        assert "--http-port" in said
    # No machine has the address TEST-NET-1 (RFC 5737), and a name with .invalid (RFC 2606) never
    # exists.
    for host in ("192.0.2.1", "no.such.name.invalid"):
        assert f"--host {host}: this machine has no such address" in message_for("--host", host)
