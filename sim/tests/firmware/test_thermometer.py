"""Tests of ADT7420 and TMP117, read through the registers of the I2C controller."""

from __future__ import annotations

from typing import Any

import pytest
from sim.tests.firmware.i2c_model import I2C0_RESET, I2C_RESET, Adt7420, I2cModel, Tmp117
from sim.tests.firmware.library import firmware

BUS_HZ = 650_000_000 // 6
HELD: list[I2cModel] = []
"""Models that must not be freed, because the C code holds pointers to them."""


def found(model: I2cModel) -> Any:
    ffi, library = firmware()
    HELD.append(model)
    library.i2c_prepare(model.access, BUS_HZ)
    thermometer = ffi.new("struct thermometer *")
    library.thermometer_find(thermometer, model.access)
    return thermometer


def name(thermometer: Any) -> str:
    ffi, library = firmware()
    return str(ffi.string(library.thermometer_name(thermometer.kind)).decode())


def read(thermometer: Any) -> float | None:
    ffi, library = firmware()
    celsius = ffi.new("double *", -999.0)
    return celsius[0] if library.thermometer_read(thermometer, celsius) else None


@pytest.mark.parametrize("bus_hz", [BUS_HZ, 25_000_000, 111_111_111, 133_000_000])
def test_the_bus_is_not_faster_than_100_khz(bus_hz: int) -> None:
    _, library = firmware()
    model = I2cModel()
    library.i2c_prepare(model.access, bus_hz)
    assert 90_000 < model.scl_hz(bus_hz) <= 100_000


@pytest.mark.parametrize("address", ["48", "49", "4a", "4b"])
@pytest.mark.parametrize(("kind", "made"), [("adt7420", Adt7420), ("tmp117", Tmp117)])
def test_it_is_found_and_read(kind: str, made: Any, address: str) -> None:
    sensor = made()
    thermometer = found(I2cModel(**{f"at_{address}": sensor}))
    assert (name(thermometer), thermometer.device) == (kind, int(address, 16))
    for celsius in (21.35, 0.0, -12.0078125, 127.9921875):
        sensor.celsius = celsius
        assert read(thermometer) == pytest.approx(celsius, abs=1 / 256)


def test_nobody_is_there() -> None:
    model = I2cModel()
    thermometer = found(model)
    assert (name(thermometer), read(thermometer)) == ("none", None)


def test_another_device_at_its_address() -> None:
    class Other(Tmp117):
        def read(self, number: int) -> bytes:
            return b"\x55" * number

    assert name(found(I2cModel(at_48=Other(), at_4a=Adt7420()))) == "adt7420"


def test_before_its_first_conversion_it_says_nothing() -> None:
    sensor = Tmp117(None)
    thermometer = found(I2cModel(at_48=sensor))
    assert (name(thermometer), read(thermometer)) == ("tmp117", None)
    sensor.celsius = 20.5
    assert read(thermometer) == 20.5


def test_one_that_was_without_its_supply_is_set_up_again() -> None:
    sensor = Adt7420(20.53)
    model = I2cModel(at_48=sensor)
    thermometer = found(model)
    device = model.devices.pop(0x48)
    assert read(thermometer) is None
    sensor.power_on()
    model.devices[0x48] = device
    assert read(thermometer) is None, "the driver first searches the thermometer"
    assert read(thermometer) == pytest.approx(20.53, abs=1 / 256), (
        "the driver has set 16 bits again"
    )


def test_a_bus_that_is_stuck_is_given_up() -> None:
    model = I2cModel(at_48=Adt7420())
    thermometer = found(model)
    model.stuck = True
    start = model.now_us
    assert read(thermometer) is None
    assert model.now_us - start < 30_000
    model.stuck = False
    read(thermometer)
    assert read(thermometer) == 25.0


@pytest.mark.parametrize("clocks", range(1, 10))
@pytest.mark.parametrize(("made", "address"), [(Adt7420, "48"), (Tmp117, "49")])
def test_a_device_that_holds_sda_is_brought_back(clocks: int, made: Any, address: str) -> None:
    """The driver frees the bus with up to nine clocks and a STOP, after the master stopped while
    the thermometer was sending a byte."""
    model = I2cModel(**{f"at_{address}": made(21.5)})
    thermometer = found(model)
    for _ in range(3):
        model.hold_sda(clocks)
        assert read(thermometer) is None
        assert read(thermometer) in (None, 21.5), "the driver may first search the thermometer"
        assert read(thermometer) == 21.5
    assert model.fastest_us >= 5, "no half period is shorter than that of 100 kHz"


@pytest.mark.parametrize("clocks", range(1, 10))
def test_a_device_that_holds_sda_at_the_start_is_found(clocks: int) -> None:
    """The driver finds a thermometer that holds SDA at the start, because the processor was reset
    during a transfer and the thermometer was not."""
    model = I2cModel(at_48=Tmp117(20.0))
    model.hold_sda(clocks)
    thermometer = found(model)
    assert (name(thermometer), read(thermometer)) == ("tmp117", 20.0)
    assert model.scl_hz(BUS_HZ) <= 100_000


def test_a_wire_that_stays_low_takes_no_longer_than_a_bus_that_is_stuck() -> None:
    model = I2cModel(at_48=Adt7420())
    thermometer = found(model)
    model.hold_sda(1_000_000)
    start = model.now_us
    assert read(thermometer) is None
    assert model.now_us - start < 30_000
    model.bits_held = 1
    read(thermometer)
    read(thermometer)
    assert read(thermometer) == 25.0


def test_a_device_that_is_not_there_is_no_reason_to_reset_the_controller() -> None:
    model = I2cModel()
    found(model)
    assert model.log.count((I2C_RESET, I2C0_RESET)) == 1, "one reset, at the preparation of the bus"
