"""Tests ``arctrue save`` against the firmware's own console at the other end of a
pseudo-terminal."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import pytest
from click.testing import CliRunner
from sim.tests.cli.test_monitor import Device
from sim.tests.firmware.emulator import PATIENCE_S
from sim.tests.firmware.flash_model import Chip, Controller
from sim.tests.firmware.library import firmware
from sim.tests.firmware.model_core import Firmware

from arctrue.cli import main

RECORDS = 0xF0_0000
APART = 0x4_0000
SECTORS = 4


class DeviceWithFlash(Device):
    """A device with a flash. The flash controller's clock advances by 20 ms in each round of the
    device's loop, so that an erase (520 ms) ends soon."""

    chip: Chip

    def attach(self, made: Firmware) -> None:
        ffi, library = firmware()
        self.controller = Controller(self.chip)
        self.kept: list[Any] = [ffi.new("struct flash *"), ffi.new("struct save *")]
        library.flash_prepare(self.kept[0], self.controller.access)
        access = ffi.new("struct flash_access *", library.flash_access_to(self.kept[0]))
        library.save_prepare(self.kept[1], access, RECORDS, SECTORS * APART)
        library.application_use_flash(made.application, self.kept[1])

    def tell(self, said: str) -> None:
        self.controller.now_us += 20_000
        super().tell(said)


@pytest.fixture
def device(monkeypatch: pytest.MonkeyPatch) -> Iterator[DeviceWithFlash]:
    monkeypatch.setattr("arctrue.device.save.SAVE_S", PATIENCE_S)
    made = DeviceWithFlash()
    made.chip = Chip()
    with made.running(monkeypatch):
        yield made


def test_a_device_saves_and_says_what(device: DeviceWithFlash) -> None:
    for number in (1, 2):
        done = CliRunner().invoke(main, ["save", device.port])
        assert done.exit_code == 0, done.output
        assert f"record {number}: parameters and " in done.output
    assert device.chip.erased == [RECORDS, RECORDS + APART]


def test_a_flash_that_is_protected(device: DeviceWithFlash) -> None:
    for sector in range(SECTORS):
        device.chip.content[RECORDS + sector * APART] = 0
    device.chip.fault = "protected"
    done = CliRunner().invoke(main, ["save", device.port])
    assert done.exit_code == 1
    assert "flash_not_erased: the flash was not erased; is it protected?" in done.output
