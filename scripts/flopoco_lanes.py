"""Calls FloPoCo for operators of sine and cosine, and reads them: for scripts/compare_cordic.py.

FloPoCo is a program that the caller builds (https://www.flopoco.org, AGPL, like what it generates);
nothing of it and nothing that it writes comes into this tree. Versions differ in their operators:
up to 4 there are FixSinCos (table and products) and CordicSinCos; from 5 on FixSinCos has a method.
"""

from __future__ import annotations

import re
import subprocess
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from scripts.netlist import ToolError

TARGETS: Final = ("Zynq7000", "Kintex7", "Virtex6")
"""The first of these that the program has is taken: the nearest to a Zynq."""
FREQUENCIES_MHZ: Final = (400, 600, 800, 1000)
"""The program is asked for one after the other: its estimate of a path is shorter than ours."""
LSBS: Final = (-16, -15)
"""Exponent of the last bit of the result, and of the angle in half turns. With -16 the error at any
angle is smaller than our lane's; -15 is the coarsest with a smaller error at its own angles."""
LARGEST_SELECT: Final = 512
"""The most words of a table that stays a select statement. GHDL makes a multiplexer of that, which
takes Yosys many minutes when it is large, and a memory of an array."""
SELECT: Final = re.compile(r"\bwith\s+(\w+)\s+select\s+(\w+)\s*<=([^;]*);", re.I)
CHOICE: Final = re.compile(r'"([01]+)"\s+when\s+"([01]+)"', re.I)
TIMEOUT_S: Final = 300
COLOUR: Final = re.compile(r"\x1b\[[0-9;]*m")
ENTITY: Final = re.compile(
    r"^\s*entity\s+(\w+)\s+is\s+port\s*\((.*?)\)\s*;\s*end\s+entity", re.I | re.M | re.S
)
WIDTH: Final = re.compile(
    r"^\s*(\w+)\s*:\s*(?:in|out)\s+std_logic_vector\((\d+) downto 0\)", re.I | re.M
)


class NotMadeError(ToolError):
    """FloPoCo refused to make an operator."""


@dataclass(frozen=True)
class Operator:
    """What FloPoCo is asked for: a name for people, its words, the target, the last bit."""

    name: str
    words: tuple[str, ...]
    target: str
    lsb: int

    @property
    def call(self) -> tuple[str, ...]:
        """The words with the last bit, as the program wants them."""
        kind, *options = self.words
        return kind, f"lsb={self.lsb}", *options


@dataclass(frozen=True)
class Generated:
    """VHDL that FloPoCo wrote: its entity, its ports for clock and reset, widths of X and C."""

    file: Path
    entity: str
    control: tuple[str, ...]
    angle_bits: int
    cosine_bits: int


def _ask(program: Path, words: tuple[str, ...], folder: Path) -> str:
    try:
        done = subprocess.run(
            [program, *words],
            cwd=folder,
            capture_output=True,
            text=True,
            errors="replace",
            check=False,
            timeout=TIMEOUT_S,
        )
    except FileNotFoundError:
        raise ToolError(
            f"There is no program {program}. Build FloPoCo (https://www.flopoco.org) and name its "
            "program: --flopoco VERSION=PROGRAM"
        ) from None
    except OSError as error:
        raise ToolError(f"{program} cannot be run ({error})") from None
    except subprocess.TimeoutExpired:
        raise ToolError(f"{program} {' '.join(words)} took more than {TIMEOUT_S} s") from None
    return COLOUR.sub("", done.stdout + done.stderr)


def operators(program: Path, folder: Path) -> list[Operator]:
    """The operators for sine and cosine that a program offers, by the help that it prints.

    Raises ToolError when the program is not FloPoCo, or does not offer them.
    """
    told = _ask(program, (), folder)
    if not re.search(r"^FixSinCos:", told, re.M):
        raise ToolError(
            f"{program} does not offer FixSinCos; expected a FloPoCo of version 4 or newer"
        )
    targets = [target for target in TARGETS if re.search(rf"\b{target}\b", told)]
    target = targets[0] if targets else "Virtex6"
    if re.search(r"^CordicSinCos:", told, re.M):
        asked = [
            ("table and products", ("FixSinCos",)),
            ("CORDIC", ("CordicSinCos", "reducedIterations=0")),
            ("CORDIC, half of it products", ("CordicSinCos", "reducedIterations=1")),
        ]
    else:
        asked = [
            ("table and products", ("FixSinCos", "method=0")),
            ("CORDIC", ("FixSinCos", "method=1")),
            ("CORDIC, half of it products", ("FixSinCos", "method=2")),
        ]
    return [Operator(name, words, target, lsb) for name, words in asked for lsb in LSBS]


def _as_array(select: re.Match[str]) -> str:
    """A block with the words of a large table in an array; the select itself when words lack."""
    index, result, body = select.groups()
    words = {int(choice, 2): word for word, choice in CHOICE.findall(body)}
    if len(words) <= LARGEST_SELECT or set(words) != set(range(len(words))):
        return select[0]
    content = ",\n".join(f'"{words[number]}"' for number in range(len(words)))
    address = f"ieee.numeric_std.to_integer(ieee.numeric_std.unsigned({index}))"
    return f"""
{result}_table: block
type words is array (0 to {len(words) - 1}) of std_logic_vector({len(words[0]) - 1} downto 0);
constant content : words := (
{content});
begin
{result} <= content({address});
end block;
"""


def large_tables_as_arrays(vhdl: str) -> str:
    """The same VHDL, in which no table of more than LARGEST_SELECT words is a select statement."""
    return SELECT.sub(_as_array, vhdl)


def read_generated(file: Path) -> Generated:
    """Find the operator in a file that FloPoCo wrote: the last entity, with the ports X and C.

    Raises ToolError without such an entity.
    """
    text = file.read_text(encoding="utf-8", errors="replace")
    found = ENTITY.findall(text)
    if found:
        entity, ports = found[-1]
        # Several ports can stand on one line.
        widths = {
            name.lower(): int(high) + 1 for name, high in WIDTH.findall(ports.replace(";", ";\n"))
        }
        if "x" in widths and "c" in widths:
            control = tuple(re.findall(r"\b(?:clk|rst)\b", ports))
            return Generated(file, entity, control, widths["x"], widths["c"])
    raise ToolError(f"{file}: no entity with the ports X and C; FloPoCo writes it last")


def generate(program: Path, operator: Operator, frequency_mhz: int, folder: Path) -> Generated:
    """Let FloPoCo write an operator to ``folder``. Raises ToolError with what the program said."""
    file = folder / "operator.vhdl"
    file.unlink(missing_ok=True)
    words = (
        f"target={operator.target}",
        f"frequency={frequency_mhz}",
        f"outputFile={file.name}",
        *operator.call,
    )
    told = _ask(program, words, folder)
    if not file.exists() or re.search(r"^\s*Error\b", told, re.M | re.I):
        refusals = re.findall(r"^\s*Error\b.*", told, re.M | re.I)
        raise NotMadeError(
            f"asked for {frequency_mhz} MHz it wrote no operator: "
            + (" ".join(refusals) or "nothing was said")
        )
    vhdl = file.read_text(encoding="utf-8", errors="replace")
    file.write_text(large_tables_as_arrays(vhdl), encoding="utf-8")
    return read_generated(file)


def wrapper(generated: Generated, width: int) -> str:
    """Verilog with the ports of the other lanes and a register after the cosine.

    An angle in half turns, two's complement, is a phase in turns with the same bits.
    """
    driven = {"clk": ".clk(clock), ", "rst": ".rst(1'b0), "}
    control = "".join(driven[port] for port in generated.control)
    spare = width - generated.cosine_bits
    return f"""
module flopoco_lane (
    input clock, input [{generated.angle_bits - 1}:0] phase,
    output reg signed [{width - 1}:0] cosine
);
    wire [{generated.cosine_bits - 1}:0] c;
    {generated.entity} operator ({control}.X(phase), .C(c));
    always @(posedge clock) cosine <= {{{{{spare}{{c[{generated.cosine_bits - 1}]}}}}, c}};
endmodule
"""
