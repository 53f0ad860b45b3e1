"""Tests the tie-offs of a DSP's constant pins, with a handmade database of one tile."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from scripts.bitstream_database import Chip
from scripts.bitstream_ties import tie_constants, ties
from scripts.netlist import ToolError

PART = "xc7z020clg400-1"
TILE = "DSP_R_X5Y10"
PINS = ("INMODE0", "INMODE1", "ALUMODE2", "RSTD")
SEGBITS = "".join(
    f"DSP_R.DSP_{half}_{pin}.DSP_{supply}_R 00_{half}{place}\n"
    for half in (0, 1)
    for place, pin in enumerate(PINS)
    for supply in ("GND", "VCC")
) + "".join(
    f"DSP_R.DSP48.DSP_{half}.ZIS_{pin}_INVERTED[{bit}] 01_{half}{bit}\n"
    for half in (0, 1)
    for pin, bit in (("INMODE", 0), ("INMODE", 1), ("ALUMODE", 2))
)
GROUND, SUPPLY, SIGNAL = 7, 8, 9


@pytest.fixture
def chip(tmp_path: Path) -> Chip:
    family = tmp_path / "zynq7"
    (family / "xc7z020").mkdir(parents=True)
    grid = {
        TILE: {
            "type": "DSP_R",
            "grid_x": 12,
            "grid_y": 34,
            "bits": {},
            "sites": {"DSP48_X1Y4": "DSP48E1", "DSP48_X1Y5": "DSP48E1"},
        }
    }
    (family / "xc7z020" / "tilegrid.json").write_text(json.dumps(grid), encoding="utf-8")
    (family / "segbits_dsp_r.db").write_text(SEGBITS, encoding="utf-8")
    return Chip(family, PART)


def routed(folder: Path, place: str, pins: dict[str, int], **parameters: str) -> Path:
    """Write a netlist with one DSP."""
    cell = {
        "type": "DSP48E1_DSP48E1",
        "attributes": {"NEXTPNR_BEL": place},
        "parameters": parameters,
        "connections": {pin: [net] for pin, net in pins.items()},
    }
    nets = {"$PACKER_GND_NET": {"bits": [GROUND]}, "$PACKER_VCC_NET": {"bits": [SUPPLY]}}
    path = folder / "routed.json"
    netlist = {"modules": {"top": {"cells": {"product": cell}, "netnames": nets}}}
    path.write_text(json.dumps(netlist), encoding="utf-8")
    return path


@pytest.mark.parametrize("place", ["X12Y34/DSP48_X0Y1.DSP48E1", "DSP48_X1Y5/DSP48E1"])
@pytest.mark.parametrize(
    ("net", "inverted", "supply"),
    [(GROUND, "0", "GND"), (SUPPLY, "0", "VCC"), (SUPPLY, "1", "GND"), (GROUND, "1", "VCC")],
)
def test_a_constant_is_tied_to_its_level_and_not_inverted(
    tmp_path: Path, chip: Chip, place: str, net: int, inverted: str, supply: str
) -> None:
    """A constant pin gets the bits (ground, supply, not inverted) 1 0 1 for a constant 0 and 0 1 1
    for a constant 1."""
    parameters = {"IS_INMODE[1]_INVERTED": inverted}
    assert ties(routed(tmp_path, place, {"INMODE1": net}, **parameters), chip) == [
        f"{TILE}.DSP_1_INMODE1.DSP_{supply}_R",
        f"{TILE}.DSP48.DSP_1.ZIS_INMODE_INVERTED[1]",
    ]


def test_what_is_no_constant_and_what_has_no_inverter(tmp_path: Path, chip: Chip) -> None:
    pins = {"INMODE0": SIGNAL, "RSTD": GROUND, "ALUMODE2": SUPPLY}
    parameters = {"IS_ALUMODE_INVERTED": "0100"}
    path = routed(tmp_path, "X12Y34/DSP48_X0Y0.DSP48E1", pins, **parameters)
    fasm, tied = tmp_path / "one.fasm", tmp_path / "tied.fasm"
    fasm.write_text("FIRST.LINE\n", encoding="ascii")
    assert tie_constants(fasm, path, chip, tied) == 3
    lines = [line for line in tied.read_text(encoding="ascii").splitlines() if "." in line]
    assert lines == [
        "FIRST.LINE",
        f"{TILE}.DSP_0_ALUMODE2.DSP_GND_R",
        f"{TILE}.DSP48.DSP_0.ZIS_ALUMODE_INVERTED[2]",
        f"{TILE}.DSP_0_RSTD.DSP_GND_R",
    ]


@pytest.mark.parametrize("place", ["", "X1Y1/DSP48_X0Y0.DSP48E1", "SLICE_X0Y0/A6LUT"])
def test_a_dsp_at_no_known_place_is_refused(tmp_path: Path, chip: Chip, place: str) -> None:
    with pytest.raises(ToolError, match=f"product is placed at '{place}'"):
        ties(routed(tmp_path, place, {"INMODE0": GROUND}), chip)
