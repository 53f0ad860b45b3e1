"""Tests of the die's temperature: the conversion of the code, and its transfer over the serial port
of the converter."""

from __future__ import annotations

import pytest
from sim.tests.firmware.library import firmware
from sim.tests.firmware.zynq_model import ZynqModel


def read(model: ZynqModel) -> float | None:
    ffi, library = firmware()
    library.die_temperature_prepare(model.access)
    celsius = ffi.new("double *", 1234.5)
    if library.die_temperature_read(model.access, celsius):
        return float(celsius[0])
    assert celsius[0] == 1234.5, "a read that fails leaves no number"
    return None


@pytest.mark.parametrize(
    ("status", "celsius"),
    [
        # UG480 (7 Series XADC), temperature sensor: code 0x977 is 25 °C, here within the rounding
        # of the code.
        (0x9770, 25.0),
        # The four low bits are not part of the code.
        (0x977F, 25.0),
        # The value is computed by hand: 2775 * 503.975 / 4096 - 273.15.
        (2775 << 4, 68.288140869140648),
    ],
)
def test_the_conversion(status: int, celsius: float) -> None:
    ffi, library = firmware()
    found = ffi.new("double *")
    assert library.die_temperature_of(status, found)
    half_a_code = 503.975 / 4096 / 2
    assert found[0] == pytest.approx(celsius, abs=half_a_code if celsius == 25.0 else 1e-9)


def test_every_code_gets_its_temperature_or_none() -> None:
    ffi, library = firmware()
    for code in range(4096):
        found = ffi.new("double *", 1e9)
        expected = code * 503.975 / 4096 - 273.15
        possible = -55.0 <= expected <= 150.0
        assert library.die_temperature_of(code << 4, found) == possible
        assert found[0] == (pytest.approx(expected, abs=1e-9) if possible else 1e9)


def test_a_read_over_the_port() -> None:
    model = ZynqModel()
    assert read(model) == pytest.approx(25.0, abs=0.1)
    model.temperature_code = 0xA00
    assert read(model) == pytest.approx(0xA00 * 503.975 / 4096 - 273.15)


def test_answers_that_nobody_took_are_not_taken_for_the_temperature() -> None:
    model = ZynqModel()
    model.answers.extend([0xB000, 0xB000, 0xB000])
    assert read(model) == pytest.approx(25.0, abs=0.1)


def test_a_converter_that_does_not_answer_is_absent() -> None:
    model = ZynqModel()
    model.temperature_code = None
    assert read(model) is None
    assert model.now_us < 10_000


@pytest.mark.parametrize("code", [0, 0xFFF])
def test_a_stuck_line_is_absent(code: int) -> None:
    model = ZynqModel()
    model.temperature_code = code
    assert read(model) is None
