"""Tests the firmware on the instrument's bus: parameters, console, bus errors, and a captured
bank."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest
from sim.tests.instrument.sizes import DEPTH, LANES, SAMPLES

from arctrue.gateware.register_access import coefficient_words
from arctrue.generated.registers import COEFFICIENTS_ADDRESS
from arctrue.instrument import BusError, Instrument, InstrumentError
from arctrue.studies.revolution import RevolutionSettings, set_up

SETTINGS = RevolutionSettings(lines=64, lanes=LANES, samples=SAMPLES, orders=8, noise_arcsec=0.0)


@pytest.fixture
def instrument() -> Iterator[Instrument]:
    with Instrument(LANES, DEPTH, clock_hz=SETTINGS.clock_hz) as made:
        yield made


def test_it_finds_the_core_and_sets_it_up(instrument: Instrument) -> None:
    firmware = instrument.firmware
    assert firmware.phase == "no_core"
    set_up(firmware, SETTINGS)
    assert firmware.phase == "wait_for_index"
    assert instrument.read("counts_per_rev_active") == SETTINGS.counts_per_rev
    assert instrument.read("sample_period") == SETTINGS.sample_period_clocks
    assert "phase wait_for_index" in firmware.send("status")


def test_refused_parameters_say_why(instrument: Instrument) -> None:
    with pytest.raises(InstrumentError, match="speed is not a parameter"):
        instrument.firmware.set("speed", 1)
    with pytest.raises(InstrumentError, match="orders is out of range"):
        instrument.firmware.set("orders", 0)
    with pytest.raises(InstrumentError, match="orders must be a whole number"):
        instrument.firmware.set("orders", 1.5)


def test_an_error_of_the_bus_reaches_python(instrument: Instrument) -> None:
    """A bus error during a step of the firmware's C code is raised as a Python exception after the
    step."""
    firmware = set_up(instrument.firmware, SETTINGS)
    for address in (0x20000, 0x3FFFC):
        instrument.library.firmware_bus_read(firmware._bus, address)
    with pytest.raises(BusError, match="0x20000"):
        firmware.step()
    firmware.step()


def test_what_it_writes_is_what_the_core_holds(instrument: Instrument) -> None:
    instrument.attach(SETTINGS.table(), SETTINGS.motion())
    firmware = set_up(instrument.firmware, SETTINGS)
    taken = []
    firmware.calculation_clocks = 3000
    firmware.run(
        until=lambda f: taken.append(instrument.clock) or bool(f.telemetry),
        poll_clocks=SETTINGS.poll_clocks,
    )
    # In the step that calibrates, the firmware reads every word of the capture bank over the bus.
    words = 2 * firmware.telemetry[0]["samples"]
    assert taken[-1] - taken[-2] > 3000 + 4 * words
    assert firmware.telemetry[0]["result"] == "applied"
    bank = firmware.coefficients
    assert bank is not None
    held = instrument.read_words(COEFFICIENTS_ADDRESS, 4 * LANES)
    assert held == coefficient_words(bank)
    # The lane of order 1 contains the eccentricity of 144″; its amplitude is the factor 2·A of
    # equation (9).
    amplitude = np.abs(bank.amplitudes).max() / 2**11 * SETTINGS.arcsec_per_count
    assert amplitude == pytest.approx(144.07, abs=0.5)


def test_a_motion_that_ends_too_early_is_reported(instrument: Instrument) -> None:
    table = SETTINGS.table()
    short = SETTINGS.motion()
    instrument.attach(table, type(short).steady(SETTINGS.speed_rad_s, 0.1, start_rad=-1.0))
    firmware = set_up(instrument.firmware, SETTINGS)
    with pytest.raises(InstrumentError, match="motion ended while the firmware was still in phase"):
        firmware.run(until=lambda f: f.telemetry, poll_clocks=500)
