"""Tests ``arctrue flash`` through the console of the C code, with a model of the flash."""

from __future__ import annotations

import threading
from pathlib import Path

import pytest
from click.testing import CliRunner, Result
from sim.tests.command_line import arctrue
from sim.tests.device.daemon_process import Replay, daemon
from sim.tests.firmware.flash_model import Chip

from arctrue.cli import flash as command
from arctrue.cli import main
from arctrue.device.announcement import FOLDER_VARIABLE
from arctrue.device.console import ConsoleError
from scripts.image import flash_image
from scripts.tests.image.test_image_store import OLD, Board, program, starts


def _run(monkeypatch: pytest.MonkeyPatch, chip: Chip, file: Path) -> Result:
    monkeypatch.setattr(command, "console_at", lambda _port: Board(chip))
    return CliRunner().invoke(main, ["flash", "board", str(file)])


def test_an_image_is_written_and_reported(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    file, chip = tmp_path / "BOOT.BIN", Chip()
    file.write_bytes(flash_image(OLD, 0, None))
    answer = _run(monkeypatch, chip, file)
    assert answer.exit_code == 0, answer.output
    assert "it is the golden image, too" in answer.output
    assert starts(chip) == (0, program(OLD))
    assert "the golden image is unchanged" in _run(monkeypatch, chip, file).output


def test_what_cannot_be_written_is_reported(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file = tmp_path / "BOOT.BIN"
    answer = _run(monkeypatch, Chip(), file)
    assert (answer.exit_code, "no such file" in answer.output) == (2, True)
    file.write_bytes(b"no image")
    answer = _run(monkeypatch, Chip(), file)
    assert (answer.exit_code, "make image" in answer.output) == (1, True)

    def absent(_port: str) -> Board:
        raise ConsoleError("board: cannot be opened")

    monkeypatch.setattr(command, "console_at", absent)
    file.write_bytes(flash_image(OLD, 0, None))
    assert CliRunner().invoke(main, ["flash", "board", str(file)]).exit_code == 2


class BoardAtAPort(Replay):
    """Board whose console is connected to a serial port."""

    def __init__(self, chip: Chip) -> None:
        super().__init__()
        self.board = Board(chip)
        threading.Thread(target=self._answer, daemon=True).start()

    def _answer(self) -> None:
        begun = b""
        while True:
            *lines, begun = (begun + self.received.get()).split(b"\r")
            for line in filter(None, lines):
                try:
                    answer = [*self.board.command(line.decode()), "ok"]
                except ConsoleError as error:
                    answer = [str(error).partition("the device says ")[2]]
                self.send("".join(f"{text}\r\n" for text in answer).encode())


def test_an_image_goes_through_the_daemon(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The daemon, which has the serial port open, passes an image on to the board; a read-only
    daemon refuses the image."""
    monkeypatch.setenv(FOLDER_VARIABLE, str(tmp_path / "run"))
    file, chip = tmp_path / "BOOT.BIN", Chip()
    file.write_bytes(flash_image(OLD, 0, None))
    port = BoardAtAPort(chip).port
    with daemon(port, tmp_path / "store"):
        refused = arctrue("flash", port, file)
    assert (refused.exit_code, "read-only" in refused.output) == (2, True), refused.output
    assert starts(chip) is None
    with daemon(port, tmp_path / "store", "--allow-control"):
        done = arctrue("flash", port, file)
    assert done.exit_code == 0, done.output
    assert "through its daemon" in done.output
    assert starts(chip) == (0, program(OLD))
