"""Tests the bus of the instrument: registers by name, bus errors, stalls and interrupts."""

from __future__ import annotations

import subprocess
from collections.abc import Iterator

import numpy as np
import pytest
from sim.tests.instrument.sizes import DEPTH, LANES

from arctrue.gateware.coefficients import Coefficients
from arctrue.generated.registers import COEFFICIENTS_ADDRESS
from arctrue.instrument import (
    HEAD1_A,
    HEAD1_B,
    BusError,
    Instrument,
    InstrumentError,
    PinFault,
    build,
)


@pytest.fixture
def instrument() -> Iterator[Instrument]:
    with Instrument(LANES, DEPTH) as made:
        yield made


def test_identity_and_values(instrument: Instrument) -> None:
    built = instrument.read_fields("core_configuration")
    assert (built["lanes"], built["capture_depth"]) == (LANES, DEPTH)
    assert instrument.read("identification") == int.from_bytes(b"ARCT", "big")
    instrument.write("scratch", 0xDEADBEEF)
    assert instrument.read("scratch") == 0xDEADBEEF
    with pytest.raises(KeyError, match=r"no register 'speed\.value'"):
        instrument.read("speed.value")


def test_refused_accesses_are_errors(instrument: Instrument) -> None:
    beyond = COEFFICIENTS_ADDRESS + LANES * 16
    with pytest.raises(BusError, match=f"0x{beyond:05X}") as caught:
        instrument.read_words(COEFFICIENTS_ADDRESS, LANES * 4 + 1)
    assert caught.value.address == beyond
    with pytest.raises(BusError):
        instrument.write("identification", 1)


def test_time_goes_on_during_an_access(instrument: Instrument) -> None:
    """During an access, the core counts as many clocks as the harness."""
    first = instrument.snapshot().time
    begin = instrument.clock
    second = instrument.snapshot().time
    taken = instrument.clock - begin
    assert second - first == taken > 0
    instrument.run(1000)
    assert instrument.snapshot().time - second == taken + 1000


def test_stalls_change_nothing_but_the_time(instrument: Instrument) -> None:
    bank = Coefficients(
        np.array([5, 7, 0, 0], dtype=np.uint64),
        np.array([1, 2, 0, 0], dtype=np.uint32),
        np.array([-3, 4, 0, 0], dtype=np.int32),
        -9,
        1 << 24,
    )
    begin = instrument.clock
    instrument.write_coefficients(bank)
    swift = instrument.clock - begin
    instrument.stall_bus(20, seed=3)
    begin = instrument.clock
    instrument.write_coefficients(bank)
    assert instrument.clock - begin > 2 * swift
    words = instrument.read_words(COEFFICIENTS_ADDRESS, 8)
    assert words == [5, 0, 1, 0xFFFF_FFFD, 7, 0, 2, 4]
    assert instrument.read("coefficient_offset") == -9


def test_interrupt_of_a_fault(instrument: Instrument) -> None:
    instrument.update("interrupt_enable", head1_fault=1)
    assert not instrument.interrupt
    instrument.disturb(PinFault(instrument.clock + 500, 1, invert=HEAD1_A | HEAD1_B))
    begin = instrument.clock
    assert instrument.run_until(interrupt=True, at_most_clocks=2000) == "interrupt"
    assert 500 < instrument.clock - begin < 550
    assert instrument.read_fields("head1.flags")["illegal"] == 1


def test_a_core_in_reset_does_not_hang_the_caller(instrument: Instrument) -> None:
    instrument.library.instrument_hold_reset(instrument.handle, 1)
    with pytest.raises(InstrumentError, match="does not answer on the bus"):
        instrument.read("scratch")


def test_waiting_for_nothing_is_refused(instrument: Instrument) -> None:
    with pytest.raises(InstrumentError, match="run for ever"):
        instrument.run_until(interrupt=True)


def test_two_instruments_side_by_side() -> None:
    with Instrument(LANES, DEPTH) as first, Instrument(LANES, DEPTH) as second:
        first.write("scratch", 1)
        second.write("scratch", 2)
        assert (first.read("scratch"), second.read("scratch")) == (1, 2)


def test_libraries_of_two_sizes_share_no_name() -> None:
    """The models in two libraries have no name in common; otherwise the second library would use
    the C++ functions of the first."""
    listed = subprocess.run(
        ["nm", "-D", "--defined-only", build(LANES, DEPTH)],
        capture_output=True,
        text=True,
        check=True,
    ).stdout
    kinds = {line.split()[-1].split("@")[0]: line.split()[-2] for line in listed.splitlines()}
    ours = {name for name in kinds if name.startswith(("instrument_", "firmware_"))}
    assert ours
    # Both libraries may contain names of the C++ runtime, but no name of the other library's model.
    assert not [name for name in kinds if "arctrue" in name.lower() and name not in ours]
    assert not [name for name, kind in kinds.items() if kind == "u"]
