"""What is asked of FloPoCo and read from it, with a program that stands for it."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from scripts.flopoco_lanes import (
    LARGEST_SELECT,
    LSBS,
    Generated,
    NotMadeError,
    Operator,
    generate,
    large_tables_as_arrays,
    operators,
    read_generated,
    wrapper,
)
from scripts.netlist import ToolError

HELP_OF_4 = """     Supported targets: Stratix2...5, Virtex2...6
FixSinCos: Computes (1-2^(-w)) sin(pi*x)
CordicSinCos: Computes (1-2^(-w)) sin(pi*x)"""
HELP_OF_5 = """     Supported targets: Kintex7, Virtex6, Zynq7000
FixSinCos: Computes (1-2^(-w)) sin(pi*x)"""

# The form of what FloPoCo writes: parts first, several ports on a line or one on each.
VHDL = """
entity Table is
   port ( X : in  std_logic_vector(8 downto 0);
          Y : out  std_logic_vector(39 downto 0)   );
end entity;
entity FixSinCos_16_F400 is
   port ( clk{reset} : in std_logic;
          X : in  std_logic_vector(16 downto 0);
          S : out  std_logic_vector(16 downto 0);
          C : out  std_logic_vector(16 downto 0)   );
end entity;
architecture arch of FixSinCos_16_F400 is
begin
end architecture;
"""


def _program(folder: Path, told: str, vhdl: str = "") -> Path:
    """A program that says its help or what it is given, and writes ``vhdl`` if there is any."""
    (folder / "vhdl").write_text(vhdl, encoding="utf-8")
    program = folder / "flopoco"
    lines = [
        "#!/bin/sh",
        'for word in "$@"; do',
        f'  case $word in outputFile=*) [ -s {folder}/vhdl ] && cp {folder}/vhdl "${{word#*=}}";;',
        "  esac",
        "done",
        f'echo "$@" > {folder}/words',
        f"cat <<'END'\n{told}\nEND",
    ]
    program.write_text("\n".join(lines) + "\n", encoding="utf-8")
    program.chmod(0o755)
    return program


def test_operators_are_those_of_the_version(tmp_path: Path) -> None:
    old = operators(_program(tmp_path, HELP_OF_4), tmp_path)
    new = operators(_program(tmp_path, HELP_OF_5), tmp_path)
    assert {one.target for one in old} == {"Virtex6"}
    assert {one.target for one in new} == {"Zynq7000"}
    assert ("CordicSinCos", "reducedIterations=0") in {one.words for one in old}
    assert {one.words[-1] for one in new} == {"method=0", "method=1", "method=2"}
    for lsb in LSBS:
        assert sum(one.lsb == lsb for one in old) == 3
        assert sum(one.lsb == lsb for one in new) == 3


def test_coloured_help_is_read(tmp_path: Path) -> None:
    coloured = HELP_OF_5.replace("FixSinCos:", "\x1b[1;31;49mFixSinCos\x1b[0;39m:")
    assert operators(_program(tmp_path, coloured), tmp_path)


def test_what_is_no_flopoco_is_refused(tmp_path: Path) -> None:
    with pytest.raises(ToolError, match="does not offer FixSinCos"):
        operators(_program(tmp_path, "hello"), tmp_path)


@pytest.mark.parametrize("reset", [", rst", ""])
def test_the_operator_is_the_last_entity(tmp_path: Path, reset: str) -> None:
    program = _program(tmp_path, "Pipeline depth = 2", VHDL.format(reset=reset))
    operator = Operator("CORDIC", ("FixSinCos", "method=1"), "Zynq7000", -16)
    made = generate(program, operator, 400, tmp_path)
    words = (tmp_path / "words").read_text(encoding="utf-8").split()
    assert words[:2] == ["target=Zynq7000", "frequency=400"]
    assert words[-3:] == ["FixSinCos", "lsb=-16", "method=1"]
    control = ("clk", "rst") if reset else ("clk",)
    assert made == Generated(tmp_path / "operator.vhdl", "FixSinCos_16_F400", control, 17, 17)
    text = wrapper(made, 18)
    assert "input [16:0] phase" in text
    assert "FixSinCos_16_F400 operator (.clk(clock), " in text
    assert (".rst(1'b0)" in text) == bool(reset)
    assert "cosine <= {{1{c[16]}}, c};" in text


def test_a_refusal_is_told_in_its_words(tmp_path: Path) -> None:
    told = "Error : FixRealKCM: Error, lsbIn>msbIn"
    operator = Operator("CORDIC", ("CordicSinCos",), "Virtex6", -14)
    with pytest.raises(NotMadeError, match="400 MHz it wrote no operator: Error : FixRealKCM"):
        generate(_program(tmp_path, told, VHDL.format(reset="")), operator, 400, tmp_path)


def test_an_old_file_is_not_taken_for_a_new_one(tmp_path: Path) -> None:
    (tmp_path / "operator.vhdl").write_text(VHDL.format(reset=""), encoding="utf-8")
    operator = Operator("CORDIC", ("CordicSinCos",), "Virtex6", -14)
    with pytest.raises(NotMadeError, match="400 MHz it wrote no operator: nothing was said"):
        generate(_program(tmp_path, "done"), operator, 400, tmp_path)


def _select(choices: list[int]) -> str:
    rows = ",\n".join(f'"{word * 3:012b}" when "{word:010b}"' for word in choices)
    return f'with X_d1 select\n  Y0 <=\n{rows},\n"------------" when others;\n'


def test_a_large_table_becomes_an_array_of_the_same_words() -> None:
    # Not in order: the place of a word follows from its choice.
    text = large_tables_as_arrays("begin\n" + _select([*range(1, 1024), 0]) + "end;\n")
    assert "select" not in text
    assert "array (0 to 1023) of std_logic_vector(11 downto 0)" in text
    assert [int(word, 2) for word in re.findall(r'"([01]+)"', text)] == [
        3 * word for word in range(1024)
    ]
    address = "ieee.numeric_std.to_integer(ieee.numeric_std.unsigned(X_d1))"
    assert f"Y0 <= content({address});" in text


@pytest.mark.parametrize("choices", [range(LARGEST_SELECT), range(1, 1024)])
def test_a_small_table_or_one_that_lacks_words_stays(choices: range) -> None:
    text = "begin\n" + _select([*choices]) + "end;\n"
    assert large_tables_as_arrays(text) == text


def test_the_table_of_a_made_operator_is_an_array(tmp_path: Path) -> None:
    program = _program(tmp_path, "done", _select([*range(1024)]) + VHDL.format(reset=""))
    operator = Operator("table and products", ("FixSinCos", "method=0"), "Zynq7000", -16)
    made = generate(program, operator, 400, tmp_path)
    assert made.angle_bits == 17
    assert "constant content : words" in made.file.read_text(encoding="utf-8")


def test_a_file_without_the_operator_is_refused(tmp_path: Path) -> None:
    file = tmp_path / "operator.vhdl"
    file.write_text("entity Table is port (X : in bit); end entity;", encoding="utf-8")
    with pytest.raises(ToolError, match="no entity with the ports X and C"):
        read_generated(file)
