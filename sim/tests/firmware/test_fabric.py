"""Tests that the loader configures the fabric from the flash; a Python model stands for the
configuration port."""

from __future__ import annotations

import zlib
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from sim.tests.firmware.library import firmware
from sim.tests.firmware.zynq_model import AT, CONFIGURED, ZynqModel, bitstream, image

STEPS_MOST = 3_000_000
"""Largest number of steps. A register read takes 5 µs; the loader's longest wait is 2 s."""


def load(model: ZynqModel) -> tuple[str, Any]:
    """Run the loader; return the name of its final state, and the loader."""
    ffi, library = firmware()
    fabric = ffi.new("struct fabric *")
    library.fabric_prepare(fabric, model.access)
    for _ in range(STEPS_MOST):
        if not library.fabric_step(fabric):
            name = ffi.string(library.fabric_state_name(fabric.state)).decode()
            assert not library.fabric_step(fabric), "a finished loader does nothing more"
            return name, fabric
    raise AssertionError("it never ends")


def usable(fabric: Any) -> bool:
    return bool(firmware()[1].fabric_usable(fabric))


def test_a_bitstream_reaches_the_fabric_whole() -> None:
    body = bitstream()
    model = ZynqModel(image(body))
    name, fabric = load(model)
    assert name == "loaded"
    assert usable(fabric)
    assert model.received == body
    assert sum(model.pieces) == len(body)
    assert len(model.pieces) > 1
    assert model.value("SLCR_LVL_SHFTR_EN") == 0xF
    assert model.value("SLCR_FPGA_RST_CTRL") == 0


@given(words=st.integers(16, 40_000))
@settings(max_examples=20, deadline=None)
def test_any_length(words: int) -> None:
    body = bitstream(4 * words)
    model = ZynqModel(image(body))
    assert load(model)[0] == "loaded"
    assert model.received == body


def test_a_port_that_is_slower_than_the_dma() -> None:
    model = ZynqModel(image(bitstream(20_000)))
    model.port_us = 1_000_000
    assert load(model)[0] == "loaded", "within the 2 s of a transfer"


def test_a_fabric_that_is_configured_is_left_alone() -> None:
    model = ZynqModel(image(bitstream()))
    model.interrupt_status = CONFIGURED
    name, fabric = load(model)
    assert (name, usable(fabric)) == ("configured", True)
    assert "DEVC_CTRL" not in model.log
    assert model.value("SLCR_LVL_SHFTR_EN") == 0xF


def test_without_a_flash_it_is_not_touched() -> None:
    model = ZynqModel(image(bitstream()), boot_mode=0)
    name, fabric = load(model)
    assert (name, usable(fabric)) == ("no_flash", False)
    assert not any(entry.startswith("QSPI") for entry in model.log)
    assert firmware()[1].fabric_state_name(fabric.state)


def spoilt(body: bytes) -> bytes:
    return body[:-7] + bytes([body[-7] ^ 0x10]) + body[-6:]


BAD_IMAGES = {
    "empty flash": (b"", "no_image"),
    "other data": (b"\x00" * 4096, "no_image"),
    "version": (image(bitstream(), version=2), "version"),
    "no length": (image(bitstream(), length=0), "length"),
    "odd length": (image(bitstream(), length=1001), "length"),
    "longer than the flash": (image(bitstream(), length=0x00F0_0000), "length"),
    "bytes not swapped": (
        image(b"\xff" * 48 + b"\xaa\x99\x55\x66" + b"\x00" * 4096),
        "no_sync_word",
    ),
    "one bit": (image(bitstream(), crc=zlib.crc32(spoilt(bitstream()))), "crc"),
    "cut off": (image(bitstream())[:-4096], "crc"),
}


@pytest.mark.parametrize("case", BAD_IMAGES)
def test_a_bad_image_leaves_the_fabric_as_it_is(case: str) -> None:
    flash, reason = BAD_IMAGES[case]
    model = ZynqModel(flash)
    name, fabric = load(model)
    assert (name, usable(fabric)) == (reason, False)
    assert "DEVC_CTRL" not in model.log, "the fabric is not cleared"
    assert model.value("SLCR_LVL_SHFTR_EN") == 0


PORT_FAULTS = {
    "init_high": "not_ready",
    "init_low": "not_ready",
    "clear": "not_cleared",
    "queue": "queue_busy",
    "dma": "dma_timeout",
    "dma_error": "dma_error",
    "done": "not_done",
}


@pytest.mark.parametrize("stuck", PORT_FAULTS)
def test_a_port_that_fails_is_given_up(stuck: str) -> None:
    model = ZynqModel(image(bitstream(20_000)), stuck=stuck)
    name, fabric = load(model)
    assert (name, usable(fabric)) == (PORT_FAULTS[stuck], False)
    assert model.value("SLCR_LVL_SHFTR_EN") != 0xF, "signals of an empty fabric are blocked"
    assert model.now_us < 3_000_000, "the loader gives up within 3 s"


def test_a_fabric_that_jtag_configures_later() -> None:
    model = ZynqModel(boot_mode=0)
    _, fabric = load(model)
    _, library = firmware()
    library.fabric_look_again(fabric)
    assert not usable(fabric)
    model.interrupt_status = CONFIGURED
    library.fabric_look_again(fabric)
    assert usable(fabric)
    assert model.value("SLCR_LVL_SHFTR_EN") == 0xF


@pytest.mark.parametrize(("register", "word"), [("DEVC_MCTRL", 0x2080_0008), ("DEVC_CTRL", 0)])
def test_an_emulator_is_known_for_one(register: str, word: int) -> None:
    model = ZynqModel()
    model.words[AT[register]] = word
    name, fabric = load(model)
    assert (name, fabric.emulated, usable(fabric)) == ("no_image", True, True)


def test_every_state_has_a_name_and_a_meaning() -> None:
    ffi, library = firmware()
    names = [ffi.string(library.fabric_state_name(i)) for i in range(library.FABRIC_STATES)]
    assert len(set(names)) == library.FABRIC_STATES
    assert all(library.fabric_state_meaning(i) for i in range(library.FABRIC_STATES))
    assert ffi.string(library.fabric_state_name(library.FABRIC_STATES)) == b"unknown"


@given(st.lists(st.integers(0, 2**32 - 1), max_size=50))
def test_the_check_is_zlibs(words: list[int]) -> None:
    crc = 0
    for word in words:
        crc = firmware()[1].crc32_add_word(crc, word)
    assert crc == zlib.crc32(b"".join(word.to_bytes(4, "little") for word in words))
