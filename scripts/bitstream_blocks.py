"""Writes configured DSPs and block RAMs as Verilog instances of scripts/bitstream_models.

The names of the features in Project X-Ray's database and the user guides UG479 (DSP) and UG473
(block RAM) define their meaning. The program refuses features that the gateware does not use: the
DSP's port D, SIMD and pattern detection, and a block RAM as FIFO, with error correction or with
cascaded data. A cascaded address is decoded as a route.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import Final

from scripts.bitstream_features import vector
from scripts.netlist import ToolError

Pin = Callable[[str], str]

DSP_BUSES: Final = {
    "A": 30,
    "B": 18,
    "C": 48,
    "PCIN": 48,
    "CARRYINSEL": 3,
    "INMODE": 5,
    "OPMODE": 7,
    "ALUMODE": 4,
}
DSP_ENABLES: Final = (
    *("CEA1", "CEA2", "CEB1", "CEB2", "CEC", "CEM", "CEP", "CECTRL", "CEALUMODE", "CEINMODE"),
    *("CECARRYIN", "RSTA", "RSTB", "RSTC", "RSTM", "RSTP", "RSTCTRL", "RSTALUMODE", "RSTINMODE"),
    *("RSTALLCARRYIN", "CLK", "CARRYIN"),
)
DSP_REGISTERS: Final = {
    "CREG": "ZCREG[0]",
    "MREG": "ZMREG[0]",
    "PREG": "ZPREG[0]",
    "OPMODEREG": "ZOPMODEREG[0]",
    "ALUMODEREG": "ZALUMODEREG[0]",
    "INMODEREG": "ZINMODEREG[0]",
    "CARRYINREG": "ZCARRYINREG[0]",
    "CARRYINSELREG": "ZCARRYINSELREG[0]",
}
DSP_REFUSED: Final = re.compile(r"USE_DPORT|USE_SIMD|AUTORESET|A_INPUT|B_INPUT")

RAM_REFUSED: Final = re.compile(r"FIFO_MODE|EN_ECC|EN_SYN|FIRST_WORD|RAM_EXTENSION_._LOWER|BRAM36_")
RAM_PINS: Final = {
    "ENA": ("ENARDEN", "RDEN"),
    "ENB": ("ENBWREN", "WREN"),
    "RSTRAMA": ("RSTRAMARSTRAM", "RST"),
    "RSTRAMB": ("RSTRAMB",),
    "RSTREGA": ("RSTREGARSTREG", "RSTREG"),
    "RSTREGB": ("RSTREGB",),
    "CLKA": ("CLKARDCLK", "RDCLK"),
    "CLKB": ("CLKBWRCLK", "WRCLK"),
    "REGCEA": ("REGCEAREGCE", "REGCE"),
    "REGCEB": ("REGCEB",),
}
"""Names of the pin at each port of the model: its name in a RAMB18E1, and its name in a FIFO18E1 if
this differs."""
RAM_BUSES: Final = {"ADDRA": ("ADDRARDADDR", 14), "ADDRB": ("ADDRBWRADDR", 14)}
WRITE_MODES: Final = {"": 0, "READ_FIRST": 1, "NO_CHANGE": 2}
EVERY_BIT: Final = (1 << 18) - 1


def _refuse(name: str, features: frozenset[str], refused: re.Pattern[str]) -> None:
    for feature in sorted(features):
        if refused.search(feature):
            raise ToolError(f"{name}: {feature} is not decoded")


def _joined(bits: list[str]) -> str:
    return f"{{{', '.join(reversed(bits))}}}"


def _instance(model: str, name: str, parameters: dict[str, str], ports: dict[str, str]) -> str:
    """Return Verilog of an instance of ``model``."""
    given = ", ".join(f".{key}({value})" for key, value in parameters.items())
    wired = ", ".join(f".{key}({value})" for key, value in ports.items())
    return f"{model} #({given}) {name} ({wired});"


def dsp(name: str, features: frozenset[str], pin: Pin, product: str) -> str:
    """Return Verilog of a DSP. ``features`` do not contain the site's name; ``product`` is the net
    at P."""
    _refuse(name, features, DSP_REFUSED)

    def level(port: str, bit: int | None) -> str:
        own = port if bit is None else f"{port}{bit}"
        inverter = f"ZIS_{port}_INVERTED" + ("" if bit is None else f"[{bit}]")
        inverts = port in ("INMODE", "OPMODE", "ALUMODE", "CARRYIN", "CLK")
        return f"~{pin(own)}" if inverts and inverter not in features else pin(own)

    parameters = {
        port: str(0 if f"{port}_0" in features else 2 if f"{port}_2" in features else 1)
        for port in ("AREG", "BREG")
    }
    for register, feature in DSP_REGISTERS.items():
        parameters[register] = str(int(feature not in features))
    ports = {
        port: _joined([level(port, bit) for bit in range(width)])
        for port, width in DSP_BUSES.items()
    }
    ports |= {port: level(port, None) for port in DSP_ENABLES}
    return _instance("dsp48e1_slice", name, parameters, {**ports, "P": product})


def _width(features: frozenset[str], name: str) -> int:
    """Return the data width of one port of half a block RAM; 1 if no feature selects a width."""
    found = [feature for feature in features if re.fullmatch(rf"{name}_\d+", feature)]
    return int(found[0].rpartition("_")[2]) if found else 1


def _constant(bits: int, value: int) -> str:
    return f"{bits}'h{value:x}"


def _contents(features: frozenset[str], name: str, rows: int) -> int:
    value = 0
    for feature in features:
        found = re.fullmatch(rf"{name}_([0-9A-F]{{2}})\[(\d+)\]", feature)
        if found and int(found[1], 16) < rows:
            value |= 1 << (int(found[1], 16) * 256 + int(found[2]))
    return value


def ram_half(
    name: str, features: frozenset[str], pin: Pin, has_pin: Callable[[str], bool], out: str
) -> str:
    """Return Verilog of half a block RAM. ``out`` holds its outputs, port A in the lower 18
    bits."""
    _refuse(name, features, RAM_REFUSED)
    parameters = {
        f"{kind}_WIDTH_{port}": str(_width(features, f"{kind}_WIDTH_{port}"))
        for kind in ("READ", "WRITE")
        for port in "AB"
    }
    if "SDP_READ_WIDTH_36" in features:
        parameters["READ_WIDTH_A"] = "36"
    if "SDP_WRITE_WIDTH_36" in features:
        parameters["WRITE_WIDTH_B"] = "36"
    for port in "AB":
        modes = [mode for mode in WRITE_MODES if mode and f"WRITE_MODE_{port}_{mode}" in features]
        parameters[f"WRITE_MODE_{port}"] = str(WRITE_MODES[modes[0] if modes else ""])
        parameters[f"DO{port}_REG"] = str(int(f"DO{port}_REG" in features))
        for value in ("INIT", "SRVAL"):
            inverted = vector(features, f"Z{value}_{port}")
            parameters[f"{value}_{port}"] = _constant(18, EVERY_BIT & ~inverted)
    parameters["INIT"] = _constant(16384, _contents(features, "INIT", 64))
    parameters["INITP"] = _constant(2048, _contents(features, "INITP", 8))

    def level(names: tuple[str, ...]) -> str:
        inverter = f"ZINV_{names[0]}"
        own = next(one for one in names if has_pin(one))
        can_invert = not names[0].startswith("REGCE")
        return f"~{pin(own)}" if can_invert and inverter not in features else pin(own)

    ports = {port: level(names) for port, names in RAM_PINS.items()}
    for port, (own, bits) in RAM_BUSES.items():
        ports[port] = _joined([pin(f"{own}{bit}") for bit in range(bits)])
    for port, bus in (("A", "A"), ("B", "B")):
        data = [pin(f"DI{bus}DI{bit}") for bit in range(16)]
        ports[f"DI{port}"] = _joined(data + [pin(f"DIP{bus}DIP{bit}") for bit in range(2)])
    # Port A has two write-enable pins for each byte, which nextpnr drives with the same signal.
    # Port B has one pin for each byte.
    ports["WEA"] = _joined([pin("WEA0"), pin("WEA2")])
    ports["WEB"] = _joined([pin(f"WEBWE{bit}") for bit in range(4)])
    ports |= {"DOA": f"{out}[17:0]", "DOB": f"{out}[35:18]"}
    return _instance("ramb18_half", name, parameters, ports)
