"""Tests that the daemon's server answers each malformed request with an error, by the protocol in
its docstring and by HTTP."""

from __future__ import annotations

import asyncio
import json
from pathlib import Path
from typing import Any

import pytest

from arctrue.device.daemon.server import Server
from arctrue.device.daemon.settings import DaemonSettings
from arctrue.device.daemon.state import DaemonState
from arctrue.device.daemon.zero import checked_zero

TOKEN = "secret"


def answer(folder: Path, request: bytes) -> bytes:
    """Return the first answer of a server to ``request``."""

    async def ask() -> bytes:
        server = Server(
            DaemonSettings("/dev/none", folder, TOKEN),
            DaemonState("/dev/none"),
            lambda _: None,
            lambda *_: [],
            lambda: pytest.fail("no capture is asked"),
            lambda _: {},
            lambda _: {},
        )
        host, port = await server.start()
        reader, writer = await asyncio.open_connection(host, port)
        writer.write(request)
        found = await asyncio.wait_for(reader.readline(), 20.0)
        writer.close()
        await server.close()
        return found

    return asyncio.run(ask())


def said(folder: Path, **request: Any) -> dict[str, Any]:
    line = json.dumps({"token": TOKEN, **request}).encode() + b"\n"
    return dict(json.loads(answer(folder, line)))


@pytest.mark.parametrize(
    "latest", [[1], {}, None, "ten", "10", 1.5, float("nan"), float("inf"), True, -1]
)
def test_a_number_of_turns_that_is_none(latest: Any, tmp_path: Path) -> None:
    error = said(tmp_path, ask="watch", latest=latest)["error"]
    assert error.startswith("latest: expected a whole number from 0, found ")


@pytest.mark.parametrize("asked", [{}, {"latest": 0}, {"latest": 10**30}])
def test_a_number_of_turns(asked: dict[str, int], tmp_path: Path) -> None:
    assert said(tmp_path, ask="watch", **asked) == {"watching": "/dev/none", "earlier": 0}


def test_a_token_that_is_no_text(tmp_path: Path) -> None:
    """A lone surrogate, which JSON permits, has no form in UTF-8."""
    for token in ("\ud800", None, [TOKEN]):
        assert "the token is wrong" in said(tmp_path, ask="status", token=token)["error"]


@pytest.mark.parametrize("method", [b"GET", b"HEAD"])
def test_a_request_line_without_a_path(method: bytes, tmp_path: Path) -> None:
    header = b"Authorization: Bearer " + TOKEN.encode() + b"\r\n\r\n"
    assert answer(tmp_path, method + b" \r\n" + header) == b"HTTP/1.1 400 Bad Request\r\n"
    assert answer(tmp_path, method + b" \r\n\r\n") == b"HTTP/1.1 401 Unauthorized\r\n"


def test_a_zero_above_the_range_of_a_float() -> None:
    """JSON has integers of any length; 10⁴⁰⁰ is above the largest float, 1.8·10³⁰⁸."""
    with pytest.raises(ValueError, match="expected a finite number of degrees"):
        checked_zero(10**400)
