"""Models the multiplexed pins (MIO) to which the quad-SPI flash is wired.

The model is written from UG585 (chapter 2.5, and slcr.MIO_PIN in its register tables), not from the
C code.
"""

from __future__ import annotations

from sim.tests.firmware.zynq_model import AT, UNLOCK_KEYS

FIRST_PIN = 0xF800_0700
QSPI_PINS = range(1, 7)
"""Pins of the first flash, MIO 1 to 6: select, four data wires and clock."""
TRISTATE, LEVEL_0, LEVELS_1_TO_3 = 1, 1 << 1, 0xFC
VOLTAGE = 7 << 9
LVCMOS33 = 3 << 9
"""Voltage code of 3.3 V, which bank 500 has on both boards; LVCMOS18 is 1 and LVCMOS25 is 2."""


def pin_address(pin: int) -> int:
    """Return the address of a pin's register."""
    return FIRST_PIN + 4 * pin


class Pins:
    """The pins MIO 1 to 6; after a reset of the system they are inputs without a function."""

    def __init__(self) -> None:
        self.locked = True
        self.words = {pin: 0x1601 if pin == 1 else 0x0601 for pin in QSPI_PINS}

    def write(self, address: int, word: int) -> None:
        """Handle a write to a system-level control register: the unlock key, or the register of one
        of these pins."""
        if address == AT["SLCR_UNLOCK"]:
            self.locked = word != UNLOCK_KEYS["SLCR_UNLOCK"]
        pin = (address - FIRST_PIN) // 4
        if pin in self.words and not self.locked:
            self.words[pin] = word

    def reach_the_flash(self) -> bool:
        """Tell whether all six pins carry the controller's signals at the voltage of the pins'
        bank."""
        return all(
            word & (LEVEL_0 | LEVELS_1_TO_3 | TRISTATE) == LEVEL_0 and word & VOLTAGE == LVCMOS33
            for word in self.words.values()
        )
