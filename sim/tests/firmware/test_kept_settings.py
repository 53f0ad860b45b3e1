"""Tests that the operator's settings survive a fault, and that the output is safe if they are
lost."""

from __future__ import annotations

from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from sim.tests.firmware.library import firmware
from sim.tests.firmware.model_core import Firmware, ModelCore, address, bit
from sim.tests.firmware.test_application import controls, turn

ORDERS = (
    "set separation_deg 47.5",
    "set counts_per_rev 3600000",
    "set method 0",
    "set index_detection_arcsec 3.5",
    "freeze on",
    "telemetry on",
)
HELD_AFTER = 3
FORGOTTEN_AFTER_TURNS = 20


class Device:
    """A core, and the memory that survives a restart; ``firmware`` is the firmware that was started
    last on both."""

    def __init__(self) -> None:
        ffi, _ = firmware()
        self.core = ModelCore()
        self.kept = ffi.new("struct kept_settings *")
        size = ffi.sizeof(self.kept[0])
        ffi.buffer(self.kept)[:] = bytes(37 * i % 256 for i in range(size))
        self.settled = 0
        self._settle = ffi.callback("memory_settle", self._settle_memory)
        self.start(after_fault=False)

    def _settle_memory(self) -> None:
        self.settled += 1

    def start(self, *, after_fault: bool) -> None:
        """Start the firmware as main() does; after a fault the core has kept its state."""
        self.firmware = Firmware(self.core)
        library, application = self.firmware.library, self.firmware.application
        library.application_keep_settings(application, self.kept, self._settle)
        library.application_recover(application, after_fault)
        library.application_begin(application)
        self.core.see_index()
        self.firmware.step()

    def work(self, turns: int) -> None:
        for seed in range(turns):
            self.core.hand_over(turn(seed=seed))
            self.firmware.step(3)


def test_a_new_start_after_a_fault_has_the_operators_settings() -> None:
    device = Device()
    assert device.firmware.status("settings") == ["preset"]
    for order in ORDERS:
        assert device.firmware.send(order).startswith("ok")
    ordered = device.firmware.parameters()
    assert ordered["counts_per_rev"] == "3600000"
    device.start(after_fault=True)
    assert device.firmware.parameters() == ordered
    assert device.firmware.status("settings") == ["kept"]
    assert device.firmware.status("coefficients") == ["frozen"]
    assert device.firmware.status("faults_in_a_row") == ["1"]
    assert device.core.get("counts_per_rev") == 3_600_000
    assert device.firmware.application.telemetry


@pytest.mark.parametrize("bypassed", [True, False])
def test_the_output_after_a_fault_is_what_was_ordered(bypassed: bool) -> None:
    device = Device()
    device.work(1)
    assert controls(device.core)["compensate"]
    device.firmware.send("bypass on" if bypassed else "bypass off")
    device.core.writes.clear()
    device.start(after_fault=True)
    words = [word for offset, word in device.core.writes if offset == address("control")]
    assert all(bool(word & 1) != bypassed for word in words), (
        "the correction never changes in between"
    )
    assert not any(
        word & bit("command", "rearm")
        for offset, word in device.core.writes
        if offset == address("command")
    )
    assert not device.firmware.application.has_active, (
        "the firmware has no copy of the coefficients"
    )
    assert device.firmware.status("compensation") == ["bypassed" if bypassed else "on"]
    device.work(1)
    assert device.firmware.application.has_active
    assert controls(device.core)["compensate"] != bypassed
    assert controls(device.core)["output_enable"]


def test_lost_settings_leave_the_output_uncorrected() -> None:
    """If the settings are lost after a fault, the firmware calibrates with the preset parameters,
    but the output stays uncorrected until the operator sends "bypass off"."""
    device = Device()
    device.firmware.send("set separation_deg 47.5")
    ffi, _ = firmware()
    ffi.buffer(device.kept)[:] = bytes(ffi.sizeof(device.kept[0]))
    device.start(after_fault=True)
    assert device.firmware.status("settings") == ["lost"]
    assert any("as they were saved, or preset" in line for line in device.firmware.status("advice"))
    assert device.firmware.parameters()["separation_deg"] == "33.000000000"
    device.work(1)
    assert device.firmware.application.has_active
    assert not controls(device.core)["compensate"]
    device.firmware.send("bypass off")
    assert controls(device.core)["compensate"]
    device.start(after_fault=True)
    assert device.firmware.status("settings") == ["kept"], "later orders are kept"


def test_lost_settings_leave_a_correction_that_is_at_work() -> None:
    """If the settings are lost after a fault while the correction is active, the correction
    continues and the firmware processes no turn."""
    device = Device()
    device.work(1)
    assert controls(device.core)["compensate"]
    ffi, _ = firmware()
    ffi.buffer(device.kept)[:] = bytes(ffi.sizeof(device.kept[0]))
    device.core.writes.clear()
    device.start(after_fault=True)
    assert device.firmware.phase == "held"
    assert not device.core.writes
    assert device.firmware.status("compensation") == ["on"]
    # The operator may switch the correction off; only a re-arm switches it on.
    assert device.firmware.send("bypass on") == "ok\r\n"
    assert not controls(device.core)["compensate"]
    assert controls(device.core)["output_enable"]


def test_another_turn_than_that_of_the_core_re_arms() -> None:
    """The firmware re-arms the core if the core has another number of counts per turn, because the
    fabric was loaded again or the fault interrupted a command."""
    device = Device()
    device.work(1)
    device.core.set("counts_per_rev_active", 1000)
    device.start(after_fault=True)
    assert not controls(device.core)["compensate"]
    assert device.core.get("counts_per_rev_active") == device.core.get("counts_per_rev")


def test_a_start_without_a_fault_has_presets() -> None:
    device = Device()
    device.firmware.send("set separation_deg 47.5")
    device.firmware.send("bypass on")
    device.start(after_fault=False)
    assert device.firmware.status("settings") == ["preset"]
    assert device.firmware.status("compensation") == ["off"]
    assert device.firmware.parameters()["separation_deg"] == "33.000000000"


def test_faults_in_a_row_end_in_a_state_that_works_on_nothing() -> None:
    device = Device()
    device.work(1)
    for _ in range(HELD_AFTER - 1):
        device.start(after_fault=True)
        assert device.firmware.phase == "capture"
    device.start(after_fault=True)
    device.core.writes.clear()
    assert device.firmware.phase == "held"
    device.work(2)
    device.firmware.send("bypass off")
    device.firmware.send("forget")
    assert device.firmware.application.turns == 0
    assert not device.core.writes
    assert controls(device.core) == {
        "compensate": True,  # with the last coefficients
        "output_enable": True,
        "capture_enable": True,
    }
    assert any("third fault in a row" in line for line in device.firmware.status("advice"))
    assert device.firmware.send("dump").startswith("error: nothing is captured in phase held")
    assert device.firmware.send("rearm").startswith("ok")
    device.core.see_index()
    device.firmware.step()
    device.work(1)
    assert controls(device.core)["compensate"]
    assert device.firmware.status("faults_in_a_row") == []
    device.start(after_fault=True)
    assert device.firmware.phase == "capture"


def test_a_fault_long_ago_does_not_count() -> None:
    device = Device()
    for _ in range(2 * HELD_AFTER):
        device.start(after_fault=True)
        assert device.firmware.phase == "capture"
        device.work(FORGOTTEN_AFTER_TURNS)
    device.start(after_fault=True)
    device.work(FORGOTTEN_AFTER_TURNS - 1)
    device.start(after_fault=True)
    assert device.firmware.status("faults_in_a_row") == ["2"]


def test_every_order_is_kept_before_it_is_confirmed() -> None:
    device = Device()
    for order in (*ORDERS, "bypass on", "bypass off", "freeze off", "telemetry off"):
        before = device.settled
        device.firmware.send(order)
        assert device.settled > before, order


@given(st.data())
@settings(max_examples=60, deadline=None)
def test_a_write_that_a_fault_cuts_off_leaves_the_settings_before_or_after_it(data: Any) -> None:
    """The firmware reads either the old or the new settings if a fault came when only some of the
    32-byte cache lines had been written to memory."""
    device = Device()
    ffi, library = firmware()
    size = ffi.sizeof(device.kept[0])
    for separation in range(40, 40 + data.draw(st.integers(1, 4))):
        device.firmware.send(f"set separation_deg {separation}")
    before = bytes(ffi.buffer(device.kept))
    device.firmware.send("set separation_deg 47.5")
    after = bytes(ffi.buffer(device.kept))
    lines = data.draw(st.lists(st.booleans(), min_size=size // 32 + 1, max_size=size // 32 + 1))
    mixed = b"".join(
        (after if new else before)[32 * i : 32 * i + 32] for i, new in enumerate(lines)
    )
    ffi.buffer(device.kept)[:] = mixed
    found = ffi.new("struct settings *")
    assert library.kept_settings_read(device.kept, found)
    assert found.parameters.separation_deg in (separation, 47.5)


@given(st.data())
@settings(max_examples=100, deadline=None)
def test_no_changed_bit_is_taken_for_an_order(data: Any) -> None:
    device = Device()
    ffi, library = firmware()
    device.firmware.send("set separation_deg 47.5")
    memory = bytearray(ffi.buffer(device.kept))
    bits = data.draw(st.lists(st.integers(0, 8 * len(memory) - 1), min_size=1, max_size=3))
    for place in bits:
        memory[place // 8] ^= 1 << place % 8
    ffi.buffer(device.kept)[:] = bytes(memory)
    found = ffi.new("struct settings *")
    if library.kept_settings_read(device.kept, found):
        assert found.parameters.separation_deg in (33.0, 47.5)
        assert (found.bypassed, found.frozen, found.faults_in_a_row) == (0, 0, 0)


def test_values_out_of_range_are_no_settings() -> None:
    """The firmware refuses settings out of range, although their checksum is right: an older
    firmware with other ranges could have written such values."""
    device = Device()
    ffi, library = firmware()
    made = ffi.new("struct settings *")
    assert library.kept_settings_read(device.kept, made)
    for name, value in (("separation_deg", 400.0), ("orders", 3.5), ("keep", float("nan"))):
        bad = ffi.new("struct settings *", made[0])
        setattr(bad.parameters, name, value)
        kept = ffi.new("struct kept_settings *")
        library.kept_settings_write(kept, bad)
        assert not library.kept_settings_read(kept, ffi.new("struct settings *")), name
    library.kept_settings_write(kept, made)
    assert library.kept_settings_read(kept, made)
