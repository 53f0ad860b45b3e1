"""Tests of the ARM image in QEMU with interrupts, watchdog, flash and temperature of the chip."""

from __future__ import annotations

import json
import shutil
import subprocess
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from sim.tests.firmware.emulator import (
    CORE_BASE,
    PATIENCE_S,
    Emulator,
    build,
    core_window,
    machine_code,
    member_offset,
    running,
    seen_at,
    symbol,
)
from sim.tests.firmware.pin_model import QSPI_PINS, pin_address
from sim.tests.firmware.test_estimates import counts_of
from sim.tests.firmware.zynq_model import AT, QSPI_REFERENCE_MHZ, bitstream, image

from arctrue.gateware.register_access import register_named

pytestmark = [
    pytest.mark.skipif(
        shutil.which("qemu-system-arm") is None or shutil.which("arm-none-eabi-gcc") is None,
        reason="needs qemu-system-arm and gcc-arm-none-eabi; make setup installs them",
    ),
]

READY = "help lists the commands\r\n"
FABRIC_INPUT = 29
"""Number of the shared interrupt: IRQ_F2P[0] is interrupt 61, and the shared interrupts begin at
32."""
GIC_SET_PENDING = 0xF8F0_1204
GIC_SET_ENABLE = 0xF8F0_1100
GIC_ENABLED = 0xF8F0_1104
GIC_CLEAR_ENABLE = 0xF8F0_1180
GIC_KIND = 0xF8F0_1C00
GLOBAL_TIMER = 27
SCRATCH = CORE_BASE + 0x3C000
"""Free address in the emulated window, behind the capture."""
CAPTURE_READY = 1 << 2
WATCHDOG_RESET = 1 << 17
KEPT_FAULT = 24
"""First of the REBOOT_STATUS bits that survive a reset."""
FAULT_CODES = {"data_abort": 4, "hang": 7, "bus_error": 8}
ASYNCHRONOUS_ABORTS_OFF = 1 << 8
FLASH_BYTES = 16 << 20
KEPT_MEMORY, KEPT_MEMORY_BYTES = 0x2F000, 4096
"""Last page of on_chip_memory.ld. A reset of the system clears it, but a start of the firmware does
not."""
STAY_HERE = bytes.fromhex("feffffea")
"""Instruction that branches to its own address, in ARM state; the code of `start` runs in this
state."""
IMAGE_OFFSET = 0x10_0000


@pytest.fixture(scope="module", autouse=True)
def built() -> None:
    build()


def field(status: str, name: str) -> str:
    (value,) = [line.split()[1] for line in status.splitlines() if line.startswith(f"{name} ")]
    return value


def assemble(folder: Path, text: str) -> bytes:
    """Return the Thumb code of an assembly text."""
    source, made, code = folder / "code.s", folder / "code.o", folder / "code.bin"
    source.write_text(f".syntax unified\n.thumb\n{text}\n", encoding="ascii")
    subprocess.run(["arm-none-eabi-as", "-mcpu=cortex-a9", source, "-o", made], check=True)
    subprocess.run(["arm-none-eabi-objcopy", "-O", "binary", made, code], check=True)
    return code.read_bytes()


def one_sample() -> bytes:
    """Return a window with a bank that the firmware will refuse at once; the bank is not ready
    yet."""
    window = bytearray(core_window(counts_of(samples=600)[:, :1]))
    window[register_named("status").address] = 0
    return bytes(window)


def hand_over(machine: Emulator) -> None:
    """Make the bank ready by a bus access, not through the debugger, because QEMU 10 wakes the
    processor after a debugger's stop."""
    machine.write_register(CORE_BASE + register_named("status").address, CAPTURE_READY)


def controller_is_on_the_bus(machine: Emulator) -> bool:
    """Tell whether the bus reaches the interrupt controller, as in QEMU 7.2.

    In QEMU 7.2 a debugger's write reaches no device. In QEMU 10 qtest accesses are non-secure, but
    all interrupts belong to the secure side, as on the chip: the controller reads as 0 and ignores
    the writes. A debugger's access counts as the processor's own access and is secure.
    """
    return machine.read_register(GIC_ENABLED) != 0


def read_controller(machine: Emulator, address: int) -> int:
    on_the_bus = controller_is_on_the_bus(machine)
    return (machine.read_register if on_the_bus else machine.read_own_register)(address)


def write_controller(machine: Emulator, address: int, value: int) -> None:
    on_the_bus = controller_is_on_the_bus(machine)
    (machine.write_register if on_the_bus else machine.write_own_register)(address, value)


def stop_timer(machine: Emulator, write: Callable[[int, int], None]) -> None:
    """Stop the timer, so that it cannot wake the processor; ``write`` writes through the
    processor."""
    to = machine.write_register if controller_is_on_the_bus(machine) else write
    to(GIC_CLEAR_ENABLE, 1 << GLOBAL_TIMER)


def test_an_interrupt_alone_wakes_it(tmp_path: Path) -> None:
    with running(tmp_path, one_sample()) as machine:
        machine.wait_for(READY)
        machine.send("telemetry on")
        machine.ask("status", "phase capture")
        with machine.stopped_at(symbol("interrupts_sleep_unless")) as write:
            stop_timer(machine, write)
        start = len(machine.said)
        hand_over(machine)
        with pytest.raises(TimeoutError):
            machine.wait_for("{", 0.5, start)
        write_controller(machine, GIC_SET_PENDING, 1 << FABRIC_INPUT)
        assert '"reason":"short_of_a_turn"' in machine.wait_for("}\r\n", start=start)
        status = machine.send("status")
        assert field(status, "interrupts") == "1"
        assert field(status, "banks_without_interrupt") != "0", (
            "in this model the last bank stays ready"
        )


def test_a_command_that_comes_before_the_sleep_is_heard(tmp_path: Path) -> None:
    """The firmware processes a command whose interrupt comes just before the processor sleeps; no
    other event would wake the processor."""
    with running(tmp_path, one_sample()) as machine:
        machine.wait_for(READY)
        machine.ask("status", "phase capture")
        start = len(machine.said)
        with machine.stopped_at(symbol("interrupts_sleep_unless")) as write:
            stop_timer(machine, write)
            machine.console.sendall(b"set\r")
            time.sleep(0.3)
        machine.wait_for("error: use: set", start=start)


def test_a_lost_interrupt_does_not_stop_it(tmp_path: Path) -> None:
    with running(tmp_path, one_sample()) as machine:
        machine.wait_for(READY)
        machine.send("telemetry on")
        machine.ask("status", "phase capture")
        start = len(machine.said)
        hand_over(machine)
        machine.wait_for("}\r\n", start=start)
        status = machine.send("status")
        assert field(status, "interrupts") == "0"
        assert int(field(status, "banks_without_interrupt")) > 0


def interrupts(machine: Emulator) -> int:
    return int(field(machine.send("status"), "interrupts"))


def wait_until(holds: Callable[[], bool], seconds: float = PATIENCE_S) -> bool:
    """Wait until ``holds`` returns true; return False if this does not happen in time."""
    end = time.monotonic() + seconds
    while not holds():
        if time.monotonic() > end:
            return False
        time.sleep(0.02)
    return True


def test_a_line_that_is_stuck_does_not_stop_it(tmp_path: Path) -> None:
    """The firmware continues although the interrupt line stays high: its main program enables the
    interrupt once per round, and so takes one interrupt per round."""
    with running(tmp_path, one_sample()) as machine:
        machine.wait_for(READY)
        (controller,) = [
            item["name"]
            for item in machine.machine_command("qom-list", path="/machine/unattached")
            if item["type"] == "child<a9mpcore_priv>"
        ]
        path = f"/machine/unattached/{controller}"
        machine.on_the_bus(f"set_irq_in {path} unnamed-gpio-in {FABRIC_INPUT} 1")
        first = interrupts(machine)
        assert wait_until(lambda: interrupts(machine) > first + 2), (
            "interrupts repeat while the line is high"
        )
        machine.on_the_bus(f"set_irq_in {path} unnamed-gpio-in {FABRIC_INPUT} 0")
        assert wait_until(lambda: interrupts(machine) == interrupts(machine)), (
            "interrupts end with the line"
        )


def temperature_of(machine: Emulator) -> Any:
    return json.loads(machine.next_line("{"))


def test_the_temperature_of_the_die(tmp_path: Path) -> None:
    """The firmware reports no temperature while QEMU's converter gives 0 K, which it does until the
    test writes its register. Then the firmware reports the written 87 °C, with an alarm."""
    with running(tmp_path, one_sample()) as machine:
        machine.wait_for(READY)
        machine.ask("status", "phase capture")
        hand_over(machine)
        machine.ask("status", "temperature_c absent")
        machine.send("telemetry on")
        assert temperature_of(machine)["temperature_c"] is None
        machine.send("telemetry off")
        code = 0xB70
        machine.write_register(AT["XADC_CMDFIFO"], 2 << 26 | code << 4)
        celsius = code * 503.975 / 4096 - 273.15
        machine.ask("status", f"temperature_c {celsius:.9f}")
        machine.send("telemetry on")
        reported = temperature_of(machine)
        # The first line may have been sent before the write.
        reported = reported if reported["temperature_c"] is not None else temperature_of(machine)
        assert reported["temperature_c"] == pytest.approx(celsius, abs=0.005)
        assert reported["alarms"] == ["temperature"], "87 °C is above the preset of 85"


def flash_options(folder: Path, content: bytes) -> list[str]:
    """Return the options for both chip selects of the controller, because QEMU selects both at
    once."""
    options = []
    for number in (8, 9):
        file = folder / f"flash{number}.bin"
        with file.open("wb") as flash:
            flash.write(b"\xff" * FLASH_BYTES)
            flash.seek(IMAGE_OFFSET)
            flash.write(content)
        options += ["-drive", f"if=mtd,index={number},format=raw,file={file}"]
    return options


@pytest.mark.parametrize(
    ("content", "state"),
    [
        # QEMU of Debian 12 has no configuration port, so that the loader waits in vain for the
        # signal INIT.
        pytest.param(image(bitstream(200_000)), "not_ready", marks=pytest.mark.large),
        (image(bitstream(20_000), crc=1), "crc"),
        (image(bitstream(20_000), version=9), "version"),
    ],
)
def test_the_flash_is_read_or_a_refusal_reported(
    tmp_path: Path, content: bytes, state: str
) -> None:
    options = flash_options(tmp_path, content)
    with running(tmp_path, core_window(None), *options, real_time=True) as machine:
        said = machine.wait_for(READY)
        assert f"fabric {state}: " in said
        status = machine.ask("status", "phase wait_for_index")
        assert field(status, "fabric") == state, "the firmware continues with the emulated window"


def test_without_a_fabric_its_window_is_not_touched(tmp_path: Path) -> None:
    """The firmware makes no access to the core's window on a chip that is not configured, because
    the access would never end."""
    control = CORE_BASE + register_named("control").address
    # The word includes output_enable; without this bit the firmware would conclude that the core
    # was reset and set it up.
    canary = 0xCA9A_1236
    with running(tmp_path, core_window(None)) as machine:
        machine.wait_for(READY)
        machine.ask("status", "phase wait_for_index")
        machine.write_register(control, canary)
        machine.write_memory(symbol("fabric") + member_offset("emulated"), b"\x00")
        assert machine.send("rearm") == "error: no core answers\r\n"
        assert machine.send("bypass on") == "ok\r\n"
        place = symbol("console_step")
        bad = assemble(tmp_path, "udf.w #0")
        machine.write_memory(symbol("start"), STAY_HERE)
        machine.write_memory(place, bad)
        machine.wait_for("state 0x")
        assert machine.read_register(control) == canary, "no bypass is written to an empty fabric"


def test_a_hang_is_noticed_and_reported(tmp_path: Path) -> None:
    """The interrupt handler of the global timer detects that the main program loops for ever,
    restarts the firmware and reports the address of the loop."""
    with running(tmp_path, core_window(None), real_time=True) as machine:
        machine.wait_for(READY)
        place = symbol("application_step")
        loop = assemble(tmp_path, "b .")
        original = machine_code(place, len(loop))
        machine.write_memory(place, loop)
        machine.wait_for("fault hang at 0x")
        machine.write_memory(place, original)
        machine.wait_for("began anew after hang at 0x")
        status = machine.ask("status", "reset hang")
        assert int(field(status, "reset_instruction"), 16) == place


def reset_by_the_watchdog(machine: Emulator, status: int) -> None:
    """Imitate the chip's reset by the watchdog, because QEMU lacks it: clear the on-chip memory and
    set REBOOT_STATUS, which this reset keeps, to ``status``."""
    machine.machine_command("stop")
    machine.machine_command("system_reset")
    while machine.machine_command("query-status")["status"] != "prelaunch":
        time.sleep(0.01)
    machine.on_the_bus(f"memset {KEPT_MEMORY:#x} {KEPT_MEMORY_BYTES} 0")
    machine.write_register(AT["SLCR_UNLOCK"], 0xDF0D)
    machine.write_register(AT["SLCR_REBOOT_STATUS"], status)
    machine.machine_command("cont")


@pytest.mark.parametrize("name", ["data_abort", pytest.param("hang", marks=pytest.mark.large)])
def test_a_faults_name_survives_a_reset_of_the_system(tmp_path: Path, name: str) -> None:
    """The name of a fault survives a reset: a fault restarts the firmware, the restart does not
    finish, and the watchdog resets the system."""
    with running(tmp_path, core_window(None)) as machine:
        machine.wait_for(READY)
        machine.write_memory(symbol("start"), STAY_HERE)
        codes = {"data_abort": "movw r0, #0\nmovt r0, #0xD000\nldr r0, [r0]", "hang": "b ."}
        machine.write_memory(symbol("application_step"), assemble(tmp_path, codes[name]))
        machine.wait_for("state 0x", 60.0)
        kept = machine.read_register(AT["SLCR_REBOOT_STATUS"])
        assert kept >> KEPT_FAULT == FAULT_CODES[name]
        reset_by_the_watchdog(machine, kept | WATCHDOG_RESET)
        machine.ask("status", f"reset {name}\r\n")
        assert machine.read_register(AT["SLCR_REBOOT_STATUS"]) >> 16 == 0
        machine.machine_command("system_reset")
        machine.ask("status", "reset none\r\n")


def test_a_write_that_the_bus_refuses_is_reported(tmp_path: Path) -> None:
    """The firmware reports a write that the bus refuses. Because QEMU's bus refuses no write, the
    test calls the handler with the state that the chip would give."""
    with running(tmp_path, core_window(None)) as machine:
        machine.wait_for(READY)
        reported = machine.machine_command(
            "human-monitor-command", **{"command-line": "info registers"}
        )
        state = int(reported.split("PSR=")[1].split()[0], 16)
        assert not state & ASYNCHRONOUS_ABORTS_OFF, "asynchronous aborts are enabled"
        place = symbol("application_step")
        handler = symbol("fault_taken") | 1
        code = assemble(
            tmp_path,
            f"""
            movs r0, #4
            movw r1, #0x1234
            movw r2, #0x8004
            movt r2, #1
            movw r3, #0x1C06
            movw r12, #{handler & 0xFFFF}
            movt r12, #{handler >> 16}
            bx r12
            """,
        )
        original = machine_code(place, len(code))
        machine.write_memory(place, code)
        machine.wait_for("fault bus_error at 0x00001234 address 0x00000000")
        machine.write_memory(place, original)
        machine.ask("status", "reset bus_error\r\n")


def test_a_fabric_that_holds_something_else(tmp_path: Path) -> None:
    """If the bus answers the first word with an error, the firmware reports that there is no core,
    and does not fault again."""
    with running(tmp_path, core_window(None)) as machine:
        machine.wait_for(READY)
        machine.ask("status", "phase wait_for_index")
        place = symbol("application_step")
        bad = assemble(tmp_path, "udf.w #0")
        original = machine_code(place, len(bad))
        # The test unmaps the section of the core: in QEMU an abort of the load stands for the bus
        # error. A restart discards the processor's copy of the page table. The emulator may discard
        # it earlier; therefore the processor must not reach the core in between.
        with machine.stopped_at(place) as write:
            write(symbol("translation_table") + 4 * (seen_at(CORE_BASE) >> 20), 0)
            write(place, int.from_bytes(bad, "little"))
        machine.wait_for("state 0x")
        machine.write_memory(place, original)
        machine.ask("status", "phase no_core")
        assert machine.send("rearm") == "error: no core answers\r\n"
        said = machine.said.replace("output_fault ", "")
    assert said.count("fault ") - said.count("fault undefined") == 0


def test_the_clocks(tmp_path: Path) -> None:
    """The clock registers fit the 50 MHz crystal of both boards. The bits are those of UG585,
    SLCR."""
    with running(tmp_path, core_window(None)) as machine:
        machine.wait_for(READY)

        def pll_mhz(name: str) -> float:
            control = machine.read_register(AT[name])
            assert control & 0x1F == 0, "neither reset nor off nor bypassed"
            return 50.0 * (control >> 12 & 0x7F)

        def divided(name: str) -> float:
            """Return the frequency of this clock: the frequency of the running input-output PLL
            divided by the first divisor."""
            control = machine.read_register(AT[name])
            assert control & 0x31 == 1
            return pll_mhz("SLCR_IO_PLL_CTRL") / (control >> 8 & 0x3F)

        assert pll_mhz("SLCR_ARM_PLL_CTRL") == 1300
        assert divided("SLCR_PCAP_CLK_CTRL") == 200
        assert divided("SLCR_LQSPI_CLK_CTRL") == QSPI_REFERENCE_MHZ
        fabric = machine.read_register(AT["SLCR_FPGA0_CLK_CTRL"])
        assert fabric & 0x30 == 0
        divisors = (fabric >> 8 & 0x3F) * (fabric >> 20 & 0x3F)
        assert pll_mhz("SLCR_IO_PLL_CTRL") / divisors == 100
        baud = divided("SLCR_UART_CLK_CTRL") * 1e6
        baud /= machine.read_register(AT["UART_BAUDGEN"])
        baud /= machine.read_register(AT["UART_BAUDDIV"]) + 1
        # The two ends of the line share an error of half a bit over the ten bits of a character.
        assert baud == pytest.approx(115_200, rel=0.025)
        buses = machine.read_register(AT["SLCR_APER_CLK_CTRL"])
        assert buses >> 20 & buses >> 23 & 1, "UART 0 and flash"
        pins = [machine.read_register(pin_address(pin)) for pin in QSPI_PINS]
        assert pins == [0x1602, *[0x0602] * 5], "the pins of the flash are set up for 3.3 V"


def test_what_was_left_of_interrupts_is_forgotten(tmp_path: Path) -> None:
    """The firmware starts although a debugger or another program left the interrupt of the second
    UART enabled, and made the fabric's interrupt edge-sensitive."""
    with running(tmp_path, core_window(None)) as machine:
        machine.wait_for(READY)
        place = symbol("application_step")
        bad = assemble(tmp_path, "udf.w #0")
        original = machine_code(place, len(bad))
        write_controller(machine, GIC_SET_ENABLE + 8, 1 << 82 % 32)
        write_controller(machine, GIC_KIND + 12, 0xFFFF_FFFF)
        assert read_controller(machine, GIC_SET_ENABLE + 8) == 1 << 82 % 32, (
            "the interrupt is enabled before the start"
        )
        machine.write_memory(place, bad)
        machine.wait_for("state 0x")
        machine.write_memory(place, original)
        machine.ask("status", "reset undefined_instruction")
        enabled = [read_controller(machine, GIC_SET_ENABLE + 4 * i) for i in range(3)]
        # The enabled interrupts are global timer 27, UART 59 and fabric 61; software interrupts
        # (SGI) are always on.
        assert [enabled[0] >> 16, *enabled[1:]] == [1 << 27 - 16, 1 << 27 | 1 << FABRIC_INPUT, 0]
        kinds = read_controller(machine, GIC_KIND + 12)
        assert not kinds & (2 << 2 * (59 - 48) | 2 << 2 * (61 - 48)), (
            "both interrupts are level-sensitive"
        )


def test_a_record_survives_a_new_start(tmp_path: Path) -> None:
    """The record of a fault survives a new start. The test imitates the start by QEMU's reset,
    which does not change the memory."""
    with running(tmp_path, core_window(None)) as machine:
        machine.wait_for(READY)
        control = CORE_BASE + register_named("control").address
        before = machine.read_register(control)
        # The firmware takes the fault but does not restart: the operator resets the system.
        machine.write_memory(symbol("start"), STAY_HERE)
        place = symbol("application_step")
        machine.write_memory(place, assemble(tmp_path, "udf.w #0"))
        machine.wait_for("state 0x")
        assert machine.read_register(control) == before, "the core continues"
        start = len(machine.said)
        # QEMU loads the image again at the reset.
        machine.machine_command("system_reset")
        machine.wait_for(f"began anew after undefined_instruction at 0x{place:08X}", start=start)
        status = machine.ask("status", "reset undefined_instruction")
        assert int(field(status, "reset_instruction"), 16) == place
        machine.machine_command("system_reset")
        machine.ask("status", "reset none")


def test_orders_outlive_faults_and_faults_in_a_row_end(tmp_path: Path) -> None:
    """The operator's settings survive three faults at the same place; after the third fault the
    firmware processes no turn."""
    with running(tmp_path, one_sample()) as machine:
        machine.wait_for(READY)
        for order in ("set separation_deg 47.5", "set method 0", "freeze on", "bypass on"):
            assert machine.send(order) == "ok\r\n"
        place = symbol("application_step")
        bad = assemble(tmp_path, "udf.w #0")
        for number in (1, 2, 3):
            start = len(machine.said)
            machine.fault_once(place, bad, symbol("fault_taken"))
            machine.wait_for("settings kept, bypass on\r\n", start=start)
            status = machine.ask("status", f"faults_in_a_row {number}\r\n")
            assert field(status, "settings") == "kept"
            assert field(status, "compensation") == "bypassed"
            assert field(status, "coefficients") == "frozen"
            assert (field(status, "phase") == "held") == (number == 3)
        reported = machine.send("show parameters")
        assert field(reported, "separation_deg") == "47.500000000"
        assert field(reported, "method") == "0"
        assert "held after 3 faults in a row: rearm begins anew\r\n" in machine.said
        assert machine.send("rearm").startswith("ok")
        machine.ask("status", "phase capture")


def test_an_interrupt_that_faults_does_not_block_the_next(tmp_path: Path) -> None:
    with running(tmp_path, core_window(None)) as machine:
        machine.wait_for(READY)
        place = symbol("timer_interrupt")
        bad = assemble(tmp_path, "udf.w #0")
        original = machine_code(place, len(bad))
        machine.write_memory(place, bad)
        machine.wait_for("fault undefined_instruction at 0x")
        machine.write_memory(place, original)
        machine.ask("status", "reset undefined_instruction")


@pytest.mark.large
def test_the_watchdog_runs_out_where_nothing_else_helps(tmp_path: Path) -> None:
    """The processor's watchdog runs out if code without interrupts never restarts it. QEMU's
    watchdog counts but does not reset; therefore the test checks that its counter falls. Then the
    test makes the reset that the chip would make, with the watchdog's flag."""
    with running(tmp_path, core_window(None), real_time=True) as machine:
        machine.wait_for(READY)
        code = assemble(
            tmp_path,
            f"""
            cpsid if
            movw r0, #0x0624
            movt r0, #{seen_at(0xF8F0_0000) >> 16}
            movw r1, #{seen_at(SCRATCH) & 0xFFFF}
            movt r1, #{seen_at(SCRATCH) >> 16}
            again:
            ldr r2, [r0]
            str r2, [r1]
            b again
            """,
        )
        machine.write_memory(symbol("application_step"), code)
        left = []
        end = time.monotonic() + PATIENCE_S
        while (not left or left[0] - left[-1] < 300_000_000) and time.monotonic() < end:
            time.sleep(0.05)
            left += [machine.read_register(SCRATCH)] if machine.read_register(SCRATCH) else []
        assert left[0] - left[-1] >= 300_000_000
        assert left == sorted(left, reverse=True), "the code never restarts the watchdog"
        assert machine.read_register(AT["SLCR_RS_AWDT_CTRL"]) == 1, (
            "the reset concerns this processor alone"
        )
        reset_by_the_watchdog(machine, WATCHDOG_RESET)
        status = machine.ask("status", "reset watchdog")
        assert "settings lost\r\n" in status
        assert field(status, "compensation") == "bypassed", "the operator's settings are lost"


def test_what_is_saved_is_there_after_power_off(tmp_path: Path) -> None:
    """The saved record is there after power off: the firmware writes it through the emulated
    controller to a flash file on this machine, N25Q128, and reads it back."""
    options = flash_options(tmp_path, b"")
    with running(tmp_path, core_window(None), *options) as machine:
        machine.wait_for(READY)
        assert "saved_record none\r\n" in machine.send("status")
        for number, separation in enumerate((33.5, 34.25), start=1):
            machine.send(f"set separation_deg {separation}")
            assert machine.send("save") == f"ok, record {number}: parameters and 0 orders\r\n"
    with running(tmp_path, core_window(None), *options) as machine:
        machine.wait_for("settings saved, bypass off\r\n")
        machine.wait_for(READY)
        assert "saved_record 2\r\n" in machine.send("status")
        assert "separation_deg 34.250000000\r\n" in machine.send("show parameters")
