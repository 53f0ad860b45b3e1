"""What is measured of a lane, without lanes: a model stands for what they put out."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scripts import lane_measurement
from scripts.compare_cordic import CORES
from scripts.lane_measurement import (
    LATENCIES,
    SWEEP_BITS,
    Core,
    Measured,
    WrongOutputError,
    latency_and_errors,
    measure_once,
)
from scripts.netlist import TimeLimitError, ToolError
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
    latency, error, _ = latency_and_errors(core, _outputs(core, 16))
    # Read after the edge that takes the phase in: one register more than the delay.
    assert latency == 17
    # Rounding to the last bit errs by half of it at the most, and a million phases come near.
    half_a_bit = 0.5 / core.amplitude
    assert 0.99 * half_a_bit < error <= half_a_bit * (1.0 + 1e-9)


def test_a_gain_that_is_off_is_in_the_error() -> None:
    core = CORES["ours"]
    _, error, _ = latency_and_errors(core, _outputs(core, 20, wrong=1e-3))
    assert error == pytest.approx(1e-3, abs=0.5 / core.amplitude)


def test_at_any_angle_half_a_bit_of_the_angle_comes_on_top() -> None:
    core = CORES["extras"]
    _, error, any_angle = latency_and_errors(core, _outputs(core, 16))
    # Where the cosine is steepest, half of 2**-18 turn moves it by 2 pi times as much.
    assert any_angle == pytest.approx(error + np.pi * 2.0**-18, rel=0.02)


def test_what_is_no_cosine_is_refused() -> None:
    core = CORES["ours"]
    with pytest.raises(ToolError, match="no cosine comes out"):
        latency_and_errors(core, np.zeros((1 << SWEEP_BITS) + LATENCIES.stop))


def test_zipcpu_amplitude_is_the_gain_of_its_rotations() -> None:
    # Its stages turn by atan(2^-1) … atan(2^-16); each lengthens by 1/cos; the output is halved.
    gain = np.prod(1.0 / np.cos(np.arctan(2.0 ** -np.arange(1, 17)))) / 2.0
    assert CORES["zipcpu"].amplitude == pytest.approx((2**17 - 1) * gain, rel=1e-12)


def test_an_error_above_the_promised_one_is_refused() -> None:
    core = replace(CORES["extras"], promised_error=1e-4)
    with pytest.raises(WrongOutputError, match=r"off by 0\.001"):
        latency_and_errors(core, _outputs(core, 16, wrong=1e-3))


class _Tools:
    """Stands for Yosys and Verilator: counts how often a lane is mapped."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.mapped = 0
        self.needs_s = 0.0
        self.wrong = 0.0
        self.yosys = "Yosys 0.23"
        monkeypatch.setattr(lane_measurement, "find_yosys", lambda: ("yosys", self.yosys))
        monkeypatch.setattr(lane_measurement, "verilator_version", lambda: "5.006")
        monkeypatch.setattr(lane_measurement, "_map", self._map)
        monkeypatch.setattr(
            lane_measurement, "_sweep", lambda core, _: _outputs(core, 16, wrong=self.wrong)
        )

    def _map(self, _core: Core, _source: Path, limit_s: float) -> tuple[Resources, float]:
        self.mapped += 1
        if self.needs_s > limit_s:
            raise TimeLimitError(limit_s)
        return Resources(lut=560, ff=558, ramb36=0.5), 4.6


@pytest.fixture
def tools(monkeypatch: pytest.MonkeyPatch) -> _Tools:
    return _Tools(monkeypatch)


def _source(folder: Path, text: str = "module lane; endmodule") -> Path:
    source = folder / "lane.v"
    source.write_text(text, encoding="utf-8")
    return source


def test_the_same_lane_is_measured_once(tmp_path: Path, tools: _Tools) -> None:
    core = CORES["extras"]
    first = measure_once(core, _source(tmp_path), tmp_path / "results", 60.0)
    assert first == measure_once(core, _source(tmp_path), tmp_path / "results", 60.0)
    assert isinstance(first, Measured)
    assert first.resources == Resources(lut=560, ff=558, ramb36=0.5)
    assert tools.mapped == 1


def test_another_lane_or_tool_or_code_is_measured_anew(
    tmp_path: Path, tools: _Tools, monkeypatch: pytest.MonkeyPatch
) -> None:
    core = CORES["extras"]
    results = tmp_path / "results"
    measure_once(core, _source(tmp_path), results, 60.0)
    measure_once(core, _source(tmp_path, "module lane; wire a; endmodule"), results, 60.0)
    assert tools.mapped == 2
    measure_once(replace(core, promised_error=0.02), _source(tmp_path), results, 60.0)
    assert tools.mapped == 3
    tools.yosys = "Yosys 0.24"
    measure_once(core, _source(tmp_path), results, 60.0)
    assert tools.mapped == 4
    code = tmp_path / "code.py"
    code.write_text("changed = True", encoding="utf-8")
    monkeypatch.setattr(lane_measurement, "CODE", (*lane_measurement.CODE, str(code)))
    measure_once(core, _source(tmp_path), results, 60.0)
    assert tools.mapped == 5


def test_a_longer_limit_is_tried_and_a_shorter_one_is_not(tmp_path: Path, tools: _Tools) -> None:
    core, source, results = CORES["extras"], _source(tmp_path), tmp_path / "results"
    tools.needs_s = 500.0
    for limit_s in (360.0, 360.0, 60.0):
        with pytest.raises(TimeLimitError, match=f"did not map it in {limit_s / 60.0:g} minutes"):
            measure_once(core, source, results, limit_s)
    assert tools.mapped == 1
    assert measure_once(core, source, results, 600.0).resources.lut == 560
    # What is known does not depend on the limit.
    assert measure_once(core, source, results, 60.0).resources.lut == 560
    assert tools.mapped == 2


def test_a_wrong_output_is_found_once(tmp_path: Path, tools: _Tools) -> None:
    core = replace(CORES["extras"], promised_error=1e-4)
    tools.wrong = 1e-3
    for _ in range(2):
        with pytest.raises(WrongOutputError, match=r"off by 0\.001"):
            measure_once(core, _source(tmp_path), tmp_path / "results", 60.0)
    assert tools.mapped == 1
