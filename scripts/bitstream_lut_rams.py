"""Writes Verilog for the look-up tables of a slice that are used as RAM.

The sources are the 7 Series Configurable Logic Block User Guide (UG474, "Distributed RAM") and
Project X-Ray's page on the configuration of distributed RAM.

The inputs of table D are the write address of all tables. A table is one RAM of 64 words, which is
written from data input 1, or two RAMs of 32 words (``SMALL``). With two RAMs, O5 reads the words
written from data input 1, and O6 reads the words written from data input 2; input 6 of the table
and of table D must be 1. ``WA7USED`` and ``WA8USED`` join several tables to a deeper RAM. A write
then goes to the table that the wide multiplexers select at this address.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Final

from scripts.bitstream_features import vector
from scripts.netlist import ToolError

LETTERS: Final = "ABCD"
CHAINED_DATA: Final = {"A": ("AI", "B"), "B": ("BI", "D"), "C": ("CI", "D")}
"""Pin of the slice that a table can use as data input 1, and the table whose data input 1 it uses
otherwise."""
ADDRESS_7: Final = ("WA7USED", "CX", {"A": 1, "B": 0, "C": 1, "D": 0})
ADDRESS_8: Final = ("WA8USED", "BX", {"A": 1, "B": 1, "C": 0, "D": 0})
"""Feature that uses a further bit of the write address, the pin of this bit, and the level of the
bit at which each table is written."""

Pin = Callable[[str], str]


def is_ram(features: frozenset[str], letter: str) -> bool:
    """Tell whether a look-up table is a RAM."""
    return f"{letter}LUT.RAM" in features


def is_small(features: frozenset[str], letter: str) -> bool:
    """Tell whether a look-up table as RAM is two RAMs of 32 words."""
    return f"{letter}LUT.SMALL" in features


def check_rams(name: str, features: frozenset[str]) -> None:
    """Raise ToolError if this program cannot decode the RAMs of a slice."""
    rams = [letter for letter in LETTERS if is_ram(features, letter)]
    shifts = [letter for letter in LETTERS if f"{letter}LUT.SRL" in features]
    if not rams:
        return
    if "D" not in rams:
        raise ToolError(
            f"{name}: {rams[0]}LUT is a RAM, and DLUT, whose inputs are its write address, is not"
        )
    if shifts:
        raise ToolError(
            f"{name}: {rams[0]}LUT is a RAM and {shifts[0]}LUT is a shift register; a slice with "
            "both is not decoded"
        )
    small = [letter for letter in rams if is_small(features, letter)]
    deep = [feature for feature, _, _ in (ADDRESS_7, ADDRESS_8) if feature in features]
    if small and deep:
        raise ToolError(f"{name}: {small[0]}LUT is a RAM of 32 words with {deep[0]}")
    if deep == ["WA8USED"]:
        raise ToolError(f"{name}: WA8USED without WA7USED is not decoded")


def data_pin(features: frozenset[str], letter: str) -> str:
    """Return the pin of the slice that is data input 1 of a table."""
    if letter == "D":
        return "DI"
    own, other = CHAINED_DATA[letter]
    return own if f"{letter}LUT.DI1MUX.{own}" in features else data_pin(features, other)


def enable_pin(features: frozenset[str]) -> str:
    """Return the pin of the slice that enables writes of its RAMs and shift registers."""
    return "CE" if "WEMUX.CE" in features else "WE"


def ram_pins(features: frozenset[str]) -> list[str]:
    """Return the input pins of a slice on which its RAMs depend."""
    rams = [letter for letter in LETTERS if is_ram(features, letter)]
    if not rams:
        return []
    pins = {"CLK", enable_pin(features)}
    pins |= {pin for feature, pin, _ in (ADDRESS_7, ADDRESS_8) if feature in features}
    for letter in rams:
        pins |= {f"{table}{place}" for table in (letter, "D") for place in range(1, 7)}
        pins.add(data_pin(features, letter))
        if is_small(features, letter):
            pins.add(f"{letter}X")
    return sorted(pins)


class TableRam:
    """Look-up table that is a RAM."""

    def __init__(self, name: str, features: frozenset[str], pin: Pin, letter: str) -> None:
        """Store the RAM; ``name`` is the name of the slice, and ``pin`` returns the net at an input
        of the slice."""
        self.name = f"{name}_{letter}ram"
        self._place = name
        self._features = features
        self._pin = pin
        self._letter = letter
        if is_small(features, letter):
            self._check_input_6()

    def _check_input_6(self) -> None:
        for table in sorted({self._letter, "D"}):
            if self._pin(f"{table}6") != "1'b1":
                raise ToolError(
                    f"{self._place}: {self._letter}LUT is two RAMs of 32 words, and {table}6 is "
                    "not always 1, which is not decoded"
                )

    def register(self, output: str) -> tuple[str, int, int]:
        """Return name, number of words and initial content of the memory that O5 or O6 reads.

        Raises ToolError for an output that this program cannot decode.
        """
        init = vector(self._features, f"{self._letter}LUT.INIT")
        if not is_small(self._features, self._letter):
            if output == "O5":
                raise ToolError(
                    f"{self._place}: O5 of {self._letter}LUT, a RAM of 64 words, is not decoded"
                )
            return self.name, 64, init
        if output == "O5":
            return f"{self.name}_lower", 32, init & 0xFFFF_FFFF
        return f"{self.name}_upper", 32, init >> 32

    def _address(self, table: str, depth: int) -> str:
        places = range(1, depth.bit_length())
        return ", ".join(self._pin(f"{table}{place}") for place in reversed(places))

    def read(self, output: str) -> str:
        """Return the Verilog expression for the level at output O5 or O6."""
        register, depth, _ = self.register(output)
        return f"1'b1 & ({register} >> {{{self._address(self._letter, depth)}}})"

    def write(self, output: str) -> str:
        """Return the Verilog statement that writes, at the clock edge, the memory that output O5 or
        O6 reads."""
        register, depth, _ = self.register(output)
        is_second = is_small(self._features, self._letter) and output == "O6"
        data = self._pin(
            f"{self._letter}X" if is_second else data_pin(self._features, self._letter)
        )
        allowed = [self._pin(enable_pin(self._features))]
        for feature, pin, levels in (ADDRESS_7, ADDRESS_8):
            if feature in self._features:
                allowed.append(f"{self._pin(pin)} == 1'b{levels[self._letter]}")
        condition = " && ".join(allowed)
        return f"if ({condition}) {register}[{{{self._address('D', depth)}}}] <= {data};"
