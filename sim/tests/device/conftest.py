"""Provides two fixtures for tests of the daemon: a folder for its announcements, and a device that
replays telemetry."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest
from sim.tests.device.daemon_process import Replay

from arctrue.device.announcement import FOLDER_VARIABLE


@pytest.fixture(autouse=True)
def run_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    folder = tmp_path / "run"
    monkeypatch.setenv(FOLDER_VARIABLE, str(folder))
    return folder


@pytest.fixture
def replay() -> Iterator[Replay]:
    return Replay()
