"""Tests which tri-state pads in a FASM file get the feature that nextpnr omits."""

from __future__ import annotations

from pathlib import Path

from scripts.bitstream_tristates import add_straight_enables, straight_enables

TWO_WIRES = """\
RIOI3_X73Y51.IOI_OLOGIC0_T1.IOI_IMUX15_1
RIOI3_X73Y51.IOI_OLOGIC1_T1.IOI_IMUX15_0
RIOI3_X73Y51.OLOGIC_Y1.ZINV_T1
RIOI3_X73Y87.OLOGIC_Y0.OSERDES.DATA_RATE_TQ.BUF
RIOI3_X73Y87.IOI_OLOGIC0_D1.IOI_IMUX34_1
"""


def test_a_routed_enable_is_straight_once(tmp_path: Path) -> None:
    """Each routed enable gets the feature once: the second pad already has it, and the pad that
    always drives must not get it."""
    wanted = ["RIOI3_X73Y51.OLOGIC_Y0.ZINV_T1"]
    assert straight_enables(TWO_WIRES) == wanted
    path = tmp_path / "routed.fasm"
    path.write_text(TWO_WIRES, encoding="ascii")
    assert add_straight_enables(path) == 1
    assert straight_enables(path.read_text(encoding="ascii")) == []
