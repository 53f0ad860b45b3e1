"""The comparison of CORDIC cores, without the cores: a model stands for what they put out."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scripts import compare_cordic
from scripts.compare_cordic import (
    CORES,
    LATENCIES,
    OWN_LANES,
    SWEEP_BITS,
    Core,
    Measured,
    WrongOutputError,
    measure_fastest,
)
from scripts.flopoco_lanes import NotMadeError
from scripts.netlist import ToolError
from scripts.resources import Resources


def _outputs(core: Core, delay: int, *, wrong: float = 0.0) -> np.ndarray:
    """Cosines rounded to the core's last bit, so many clocks late, before them nothing."""
    count = 1 << min(core.angle_bits, SWEEP_BITS)
    k = np.arange(count)
    turns = k / count
    if core.angle_bits > SWEEP_BITS:
        # The low bits as the harness of the simulation writes them: a multiplicative hash.
        low = core.angle_bits - SWEEP_BITS
        turns = turns + ((k * 2654435761 % 2**32) // 2 ** (32 - low)) / 2.0**core.angle_bits
    cosine = np.round(core.amplitude * np.cos(2.0 * np.pi * turns) * (1.0 + wrong))
    late = np.zeros(count + LATENCIES.stop)
    late[delay : delay + count] = cosine
    return late


@pytest.mark.parametrize("key", ["ours", "extras"])
def test_latency_and_error_are_those_of_the_outputs(key: str) -> None:
    core = CORES[key]
    latency, error, _ = compare_cordic._error(core, _outputs(core, 16))
    # Read after the edge that takes the phase in: one register more than the delay.
    assert latency == 17
    # Rounding to the last bit errs by half of it at the most, and a million phases come near.
    half_a_bit = 0.5 / core.amplitude
    assert 0.99 * half_a_bit < error <= half_a_bit * (1.0 + 1e-9)


def test_a_gain_that_is_off_is_in_the_error() -> None:
    core = CORES["ours"]
    _, error, _ = compare_cordic._error(core, _outputs(core, 20, wrong=1e-3))
    assert error == pytest.approx(1e-3, abs=0.5 / core.amplitude)


def test_at_any_angle_half_a_bit_of_the_angle_comes_on_top() -> None:
    core = CORES["extras"]
    _, error, any_angle = compare_cordic._error(core, _outputs(core, 16))
    # Where the cosine is steepest, half of 2**-18 turn moves it by 2 pi times as much.
    assert any_angle == pytest.approx(error + np.pi * 2.0**-18, rel=0.02)


def test_what_is_no_cosine_is_refused() -> None:
    core = CORES["ours"]
    with pytest.raises(ToolError, match="no cosine comes out"):
        compare_cordic._error(core, np.zeros((1 << SWEEP_BITS) + LATENCIES.stop))


def test_zipcpu_amplitude_is_the_gain_of_its_rotations() -> None:
    # Its stages turn by atan(2^-1) … atan(2^-16); each lengthens by 1/cos; the output is halved.
    gain = np.prod(1.0 / np.cos(np.arctan(2.0 ** -np.arange(1, 17)))) / 2.0
    assert CORES["zipcpu"].amplitude == pytest.approx((2**17 - 1) * gain, rel=1e-12)


def test_without_clones_the_page_says_what_was_not_measured(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    used = Resources(lut=560, ff=558, carry4=141, dsp=0)
    monkeypatch.setattr(
        compare_cordic, "measure", lambda *_: Measured(used, 4.6, 17, 5.25e-5, 5.27e-5)
    )
    monkeypatch.setattr(compare_cordic, "find_ghdl", lambda: ("ghdl", "GHDL 5.0.1"))
    monkeypatch.setattr(compare_cordic, "find_yosys", lambda: ("yosys", "Yosys 0.23"))
    monkeypatch.setattr(compare_cordic, "_run", lambda *_: b"Verilator 5.006 2023-01-22")
    page = tmp_path / "page.md"
    assert compare_cordic.main(["--output", str(page)]) == 0
    text = page.read_text(encoding="utf-8")
    assert "| ArcTrue quadrant_fold + cordic_rotation | this tree | 24 | 560 | 558 |" in text
    for key, core in CORES.items():
        told = f"- not measured: {core.name}: no folder given; {core.origin}" in text
        assert told == (key not in OWN_LANES)
    assert "- not measured: FloPoCo: no program given" in text
    rows = [line for line in text.splitlines() if line.startswith("| ") and "this tree" in line]
    assert len(rows) == len(OWN_LANES)
    assert rows[0].endswith("| 141 | 0 | 0 | 17 | 4.6 | 5.25e-05 | 5.27e-05 |")


def test_a_missing_tool_is_told(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def missing(*_: object) -> Measured:
        raise ToolError("verilator is missing")

    monkeypatch.setattr(compare_cordic, "measure", missing)
    page = tmp_path / "page.md"
    assert compare_cordic.main(["--output", str(page)]) == 2
    assert "verilator is missing" in capsys.readouterr().err
    assert not page.exists()


def _lane(name: str) -> Core:
    return Core(name, "top", "origin", lambda *_: "", 1.0, 17, "")


def _measure_by_name(paths_ns: dict[str, float]) -> Callable[..., Measured]:
    def measure(core: Core, *_: object) -> Measured:
        if core.name not in paths_ns:
            raise NotMadeError(f"{core.name} is refused")
        return Measured(Resources(), paths_ns[core.name], 5, 1e-5, 1e-5)

    return measure


@pytest.mark.parametrize(
    ("paths_ns", "chosen"),
    [
        ({"a": 9.0, "b": 4.9, "c": 4.0}, "b"),  # the first within 5 ns
        ({"a": 9.0, "b": 7.0, "c": 7.5}, "c"),  # none is: the last
        ({"a": 9.0, "b": 7.0}, "b"),  # none is: the last that could be made
    ],
)
def test_the_lowest_frequency_that_fits_is_taken(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, paths_ns: dict[str, float], chosen: str
) -> None:
    monkeypatch.setattr(compare_cordic, "measure", _measure_by_name(paths_ns))
    core, measured = measure_fastest(map(_lane, "abc"), tmp_path)
    assert (core.name, measured.path_ns) == (chosen, paths_ns[chosen])


def test_an_operator_that_no_frequency_gives_is_told(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(compare_cordic, "measure", _measure_by_name({}))
    with pytest.raises(NotMadeError, match="a is refused"):
        measure_fastest(map(_lane, "abc"), tmp_path)


def test_an_error_above_the_promised_one_is_refused() -> None:
    core = replace(CORES["extras"], promised_error=1e-4)
    with pytest.raises(WrongOutputError, match=r"off by 0\.001"):
        compare_cordic._error(core, _outputs(core, 16, wrong=1e-3))


def test_a_missing_flopoco_is_told(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    used = Measured(Resources(), 4.6, 17, 5e-5, 5e-5)
    monkeypatch.setattr(compare_cordic, "measure", lambda *_: used)
    monkeypatch.setattr(compare_cordic, "WORK", tmp_path)
    page = tmp_path / "page.md"
    missing = tmp_path / "nowhere"
    assert compare_cordic.main(["--flopoco", f"5.0={missing}", "--output", str(page)]) == 2
    told = capsys.readouterr().err
    assert f"There is no program {missing}" in told
    assert "--flopoco VERSION=PROGRAM" in told
    assert not page.exists()


def test_a_program_without_its_version_is_refused(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        compare_cordic.main(["--flopoco", "flopoco"])
    assert "expected VERSION=PROGRAM, found flopoco" in capsys.readouterr().err
