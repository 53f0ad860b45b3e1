"""Tests of ``arctrue flash`` over the C code's own console and a model of the flash."""

from __future__ import annotations

from pathlib import Path

import pytest
from click.testing import CliRunner, Result
from sim.tests.firmware.flash_model import Chip

from arctrue.cli import flash as command
from arctrue.cli import main
from arctrue.device.console import ConsoleError
from scripts.image import flash_image
from scripts.tests.image.test_image_store import OLD, Board, program, starts


def _run(monkeypatch: pytest.MonkeyPatch, chip: Chip, file: Path) -> Result:
    monkeypatch.setattr(command, "console_at", lambda _port: Board(chip))
    return CliRunner().invoke(main, ["flash", "board", str(file)])


def test_an_image_is_written_and_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    file, chip = tmp_path / "BOOT.BIN", Chip()
    file.write_bytes(flash_image(OLD, 0, None))
    answer = _run(monkeypatch, chip, file)
    assert answer.exit_code == 0, answer.output
    assert "the golden image is the same" in answer.output
    assert starts(chip) == (0, program(OLD))
    assert "the golden image stays" in _run(monkeypatch, chip, file).output


def test_what_cannot_be_written_is_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    file = tmp_path / "BOOT.BIN"
    answer = _run(monkeypatch, Chip(), file)
    assert (answer.exit_code, "cannot be read" in answer.output) == (2, True)
    file.write_bytes(b"no image")
    answer = _run(monkeypatch, Chip(), file)
    assert (answer.exit_code, "make image" in answer.output) == (1, True)

    def absent(_port: str) -> Board:
        raise ConsoleError("board: cannot be opened")

    monkeypatch.setattr(command, "console_at", absent)
    file.write_bytes(flash_image(OLD, 0, None))
    assert CliRunner().invoke(main, ["flash", "board", str(file)]).exit_code == 2
