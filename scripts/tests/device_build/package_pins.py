"""Lists the pins of the clg400 package on the boards' connectors, from the package file of the
XC7Z020.

Bank and function of a pin come from AMD's xc7z020clg400pkg.txt; the connectors are listed as in the
boards' manuals.
"""

from __future__ import annotations

FIRST_PMOD_PINS = ("Y18", "Y19", "Y16", "Y17", "U18", "U19", "W18", "W19")
SECOND_PMOD_PINS = ("W14", "Y14", "T11", "T10", "V16", "W16", "V12", "W13")
I2C_PINS = {"i2c_scl": "P16", "i2c_sda": "P15"}
"""Pins SCL and SDA of the Arduino (ChipKit) header."""
FURTHER_HEADS = {
    "head3": ("V13", "V15", "T15"),
    "head4": ("R16", "U17", "V17"),
}
"""Pins A, B and Z of heads 3 and 4: IO3 to IO8 of the Arduino (ChipKit) header."""
HEADER_PAIRS = (
    {"U13", "V13"},
    {"V15", "W15"},
    {"T14", "T15"},
    {"R16", "R17"},
    {"T16", "U17"},
    {"V17", "V18"},
)
"""Positive and negative pins of pairs 3, 10, 5, 19, 9 and 21 of bank 34. Pin U13 is also PUDC_B."""
LEDS = ("R14", "P14", "N16", "M14")
OSCILLATOR = "H16"

BANKS = {
    **dict.fromkeys((*FIRST_PMOD_PINS, *SECOND_PMOD_PINS), 34),
    **dict.fromkeys((*LEDS[:2], *I2C_PINS.values()), 34),
    **dict.fromkeys((pin for pins in FURTHER_HEADS.values() for pin in pins), 34),
    **dict.fromkeys((*LEDS[2:], OSCILLATOR), 35),
}

SUPPLY_VOLTS = {34: 3.3, 35: 3.3}
"""Supply voltage of each bank on both boards."""

# The keys are the numbers of the pins at the connector; 5, 6, 11 and 12 are ground and supply. The
# connectors of both boards are at the same pins of the package, but these pins have other names on
# the connectors.
PLACES = (1, 2, 3, 4, 7, 8, 9, 10)
FIRST_PMOD = dict(zip(PLACES, FIRST_PMOD_PINS, strict=True))
SECOND_PMOD = dict(zip(PLACES, SECOND_PMOD_PINS, strict=True))
