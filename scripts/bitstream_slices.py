"""Writes a configured slice as Verilog: look-up tables, carry chain, wide multiplexers, registers.

The 7 Series Configurable Logic Block User Guide defines the features of a slice (UG474, figures 2-3
to 2-5, and "Shift Registers"). scripts/bitstream_lut_rams.py writes the look-up tables that are
used as RAM. The program refuses latches and asynchronous resets, because the gateware has none.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cache
from typing import Final

from scripts.bitstream_features import vector
from scripts.bitstream_lut_rams import LETTERS, TableRam, check_rams, enable_pin, is_ram
from scripts.netlist import ToolError

SHIFT_CHAIN: Final = {
    "A": ("AI", "BDI1_BMC31", "B"),
    "B": ("BI", "DI_CMC31", "C"),
    "C": ("CI", "DI_DMC31", "D"),
}
"""For each look-up table as shift register: its own data pin, the feature that selects another
table as the source, and this other table."""


@dataclass
class Text:
    """Collects Verilog: declarations, assignments, and the statements of each clock edge."""

    declarations: list[str] = field(default_factory=list)
    assignments: list[str] = field(default_factory=list)
    clocked: dict[str, list[str]] = field(default_factory=dict)

    def wire(self, name: str, expression: str) -> str:
        """Declare a wire with the value of an expression; return its name."""
        self.declarations.append(f"wire {name};")
        self.assignments.append(f"assign {name} = {expression};")
        return name

    def register(self, name: str, bits: int, initial: int) -> str:
        """Declare a register of ``bits`` bits with an initial value; return its name."""
        self.declarations.append(f"reg [{bits - 1}:0] {name} = {bits}'d{initial};")
        return name

    def at(self, edge: str, statement: str) -> None:
        """Add a statement that is executed at an edge (``posedge clock``) of a clock."""
        self.clocked.setdefault(edge, []).append(statement)


class Slice:
    """Slice of the chip; it writes the Verilog of each signal once, when the signal is first
    used."""

    def __init__(
        self,
        name: str,
        features: frozenset[str],
        pin: Callable[[str], str],
        text: Text,
    ) -> None:
        """Store a slice; ``features`` do not contain the site's name, and ``pin`` returns the net
        at an input."""
        self.name = name
        self.features = features
        self._pin = pin
        self._text = text
        self._made: dict[str, str] = {}
        self.ram_outputs: list[str] = []
        """Nets at the outputs of look-up tables that are RAM."""
        if "LATCH" in features:
            raise ToolError(f"{name}: latches are not decoded")
        check_rams(name, features)

    def output(self, pin: str) -> str:
        """Return the net at an output pin (A, AMUX, AQ, COUT and so on)."""
        if pin == "COUT":
            return self._carry(3)
        letter, kind = pin[0], pin[1:]
        if kind == "":
            return self._o6(letter)
        if kind == "Q":
            return self._register(f"{letter}FF", letter)
        return self._chosen(letter, "OUTMUX")

    def _wire(self, name: str, expression: str) -> str:
        return self._text.wire(f"{self.name}_{name}", expression)

    def _once(self, name: str, make: Callable[[], str]) -> str:
        if name not in self._made:
            self._made[name] = make()
        return self._made[name]

    def _choice(self, group: str) -> str:
        found = [name for name in self.features if name.startswith(f"{group}.")]
        if len(found) != 1:
            raise ToolError(f"{self.name}: {group} has {len(found)} choices: {sorted(found)}")
        return found[0].rpartition(".")[2]

    def _chosen(self, letter: str, group: str) -> str:
        choice = self._choice(f"{letter}{group}")
        if choice == "O6":
            return self._o6(letter)
        if choice == "O5":
            return self._o5(letter)
        if choice == "XOR":
            return self._sum(LETTERS.index(letter))
        if choice == "CY":
            return self._carry(LETTERS.index(letter))
        if choice == "F7":
            return self._f7(letter)
        if choice == "F8":
            return self._f8()
        if choice == f"{letter}X":
            return self._pin(f"{letter}X")
        if choice == f"{letter}5Q":
            return self._register(f"{letter}5FF", letter)
        if choice == "MC31":
            return self._shift_end(letter)
        raise ToolError(f"{self.name}: {letter}{group}.{choice} is not decoded")

    def _is_shift(self, letter: str) -> bool:
        return f"{letter}LUT.SRL" in self.features

    def _table(self, letter: str, inputs: int) -> str:
        init = vector(self.features, f"{letter}LUT.INIT") & ((1 << (1 << inputs)) - 1)
        pins = [self._pin(f"{letter}{place}") for place in range(1, inputs + 1)]
        free: list[str] = []
        # Remove the constant inputs from the table, so that only variable inputs index it.
        for place in reversed(range(inputs)):
            if pins[place] in ("1'b0", "1'b1"):
                init = _halve(init, place, len(free) + place + 1, pins[place] == "1'b1")
            else:
                free.insert(0, pins[place])
        size = 1 << len(free)
        if init == 0:
            return "1'b0"
        if init == (1 << size) - 1:
            return "1'b1"
        if len(free) == 1 and init == 2:
            return free[0]
        index = ", ".join(reversed(free))
        return f"1'b1 & ({size}'h{init:x} >> {{{index}}})"

    def _o6(self, letter: str) -> str:
        return self._once(f"{letter}o6", lambda: self._make_o6(letter))

    def _make_o6(self, letter: str) -> str:
        if is_ram(self.features, letter):
            return self._ram(letter, "O6")
        if not self._is_shift(letter):
            return self._wire(f"{letter}o6", self._table(letter, 6))
        if f"{letter}LUT.SMALL" in self.features:
            register, bits = self._shift(letter, "hi", 16, self._pin(f"{letter}X")), range(2, 6)
        else:
            register, bits = self._long_shift(letter), range(2, 7)
        index = ", ".join(self._pin(f"{letter}{place}") for place in reversed(bits))
        return self._wire(f"{letter}o6", f"1'b1 & ({register} >> {{{index}}})")

    def _o5(self, letter: str) -> str:
        return self._once(f"{letter}o5", lambda: self._make_o5(letter))

    def _make_o5(self, letter: str) -> str:
        if is_ram(self.features, letter):
            return self._ram(letter, "O5")
        if not self._is_shift(letter):
            return self._wire(f"{letter}o5", self._table(letter, 5))
        if f"{letter}LUT.SMALL" not in self.features:
            raise ToolError(f"{self.name}: O5 of a shift register of 32 is not decoded")
        register = self._shift(letter, "lo", 16, self._shift_data(letter))
        index = ", ".join(self._pin(f"{letter}{place}") for place in reversed(range(2, 6)))
        return self._wire(f"{letter}o5", f"1'b1 & ({register} >> {{{index}}})")

    def _ram(self, letter: str, output: str) -> str:
        ram = TableRam(self.name, self.features, self._pin, letter)
        self._text.register(*ram.register(output))
        self._text.at(self._edge(), ram.write(output))
        net = self._wire(f"{letter}{output.lower()}", ram.read(output))
        self.ram_outputs.append(net)
        return net

    def _shift_data(self, letter: str) -> str:
        if letter == "D":
            return self._pin("DI")
        own, _, before = SHIFT_CHAIN[letter]
        if f"{letter}LUT.DI1MUX.{own}" in self.features:
            return self._pin(own)
        return self._shift_end(before)

    def _long_shift(self, letter: str) -> str:
        return self._once(
            f"{letter}long", lambda: self._shift(letter, "sr", 32, self._shift_data(letter))
        )

    def _shift_end(self, letter: str) -> str:
        if not self._is_shift(letter):
            raise ToolError(
                f"{self.name}: MC31 of {letter}LUT is used, but {letter}LUT is not a shift register"
            )
        return f"{self._long_shift(letter)}[31]"

    def _shift(self, letter: str, part: str, length: int, data: str) -> str:
        if vector(self.features, f"{letter}LUT.INIT"):
            raise ToolError(f"{self.name}: {letter}LUT, a shift register, begins with ones")
        full = self._text.register(f"{self.name}_{letter}{part}", length, 0)
        enable = self._pin(enable_pin(self.features))
        shifted = f"{full} <= {{{full}[{length - 2}:0], {data}}};"
        self._text.at(self._edge(), f"if ({enable}) {shifted}")
        return full

    def _f7(self, letter: str) -> str:
        """Return the net of the wide multiplexer of A and B (``letter`` A), or of C and D
        (``letter`` C); if the pin AX (or CX) is 1, the multiplexer selects table A (or C)."""
        upper = LETTERS[LETTERS.index(letter) + 1]

        def make() -> str:
            one, zero, choice = self._o6(letter), self._o6(upper), self._pin(f"{letter}X")
            return self._wire(f"{letter}f7", f"{choice} ? {one} : {zero}")

        return self._once(f"{letter}f7", make)

    def _f8(self) -> str:
        def make() -> str:
            one, zero, choice = self._f7("A"), self._f7("C"), self._pin("BX")
            return self._wire("f8", f"{choice} ? {one} : {zero}")

        return self._once("f8", make)

    def _carry_into(self, place: int) -> str:
        if place:
            return self._carry(place - 1)
        if "PRECYINIT.CIN" in self.features:
            return self._pin("CIN")
        if "PRECYINIT.AX" in self.features:
            return self._pin("AX")
        return "1'b1" if "PRECYINIT.C1" in self.features else "1'b0"

    def _carry(self, place: int) -> str:
        def make() -> str:
            letter = LETTERS[place]
            own = f"CARRY4.{letter}CY0" in self.features
            generate = self._o5(letter) if own else self._pin(f"{letter}X")
            before, propagate = self._carry_into(place), self._o6(letter)
            return self._wire(f"{letter}cy", f"{propagate} ? {before} : {generate}")

        return self._once(f"cy{place}", make)

    def _sum(self, place: int) -> str:
        def make() -> str:
            before = self._carry_into(place)
            return self._wire(f"{LETTERS[place]}xor", f"{self._o6(LETTERS[place])} ^ {before}")

        return self._once(f"xor{place}", make)

    def _edge(self) -> str:
        return f"{'negedge' if 'CLKINV' in self.features else 'posedge'} {self._pin('CLK')}"

    def _register(self, register: str, letter: str) -> str:
        def make() -> str:
            initial = int(f"{register}.ZINI" not in self.features)
            full = self._text.register(f"{self.name}_{register}", 1, initial)
            # Store the register's name before its data are written, because the data may depend on
            # the register itself.
            self._made[register] = full
            self._text.at(self._edge(), self._update(register, letter, full))
            return full

        return self._once(register, make)

    def _update(self, register: str, letter: str, full: str) -> str:
        if register[1] == "5":
            is_pin = self._choice(f"{letter}5FFMUX") == "IN_B"
            data = self._pin(f"{letter}X") if is_pin else self._o5(letter)
        else:
            data = self._chosen(letter, "FFMUX")
        update = f"{full} <= {data};"
        if "CEUSEDMUX" in self.features:
            update = f"if ({self._pin('CE')}) {update}"
        if "SRUSEDMUX" in self.features:
            if "FFSYNC" not in self.features:
                raise ToolError(f"{self.name}: asynchronous resets are not decoded")
            value = int(f"{register}.ZRST" not in self.features)
            update = f"if ({self._pin('SR')}) {full} <= 1'b{value}; else {update}"
        return update


@cache
def _halve(table: int, place: int, inputs: int, level: bool) -> int:
    """Return the table, with one input fewer, that remains if the input with the index ``place`` is
    constant at ``level``."""
    halved = 0
    for index in range(1 << (inputs - 1)):
        low = index & ((1 << place) - 1)
        whole = (index - low) << 1 | int(level) << place | low
        halved |= (table >> whole & 1) << index
    return halved
