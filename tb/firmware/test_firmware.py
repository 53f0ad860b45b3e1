"""The firmware against the VHDL: index, capture, calibration, swap, corrected edges."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from arctrue.demo.calibrate import calibrate_capture
from arctrue.demo.files import DemoFiles
from arctrue.demo.judgement import decode_recording, pin_to_pin_latency, turn_error
from arctrue.demo.scene import build_scene
from arctrue.demo.settings import DemoSettings
from arctrue.table import PinEvents
from tb.support.simulation import simulate

SETTINGS = DemoSettings(counts_per_rev=1 << 13, capture_depth=512, judged_orders=8)
STOP_TIME = "300us"
"""The test is over after 277 µs. GHDL 2.0 goes on after cocotb's finish once calls came from other
threads, as those of the C code do."""
PEAK_LIMIT_COUNTS = 2.0
"""One count of the edge grid of each side, as in the demo."""


@pytest.mark.slow
def test_the_firmware_corrects_the_real_core(tmp_path: Path) -> None:
    files = DemoFiles(tmp_path)
    scene = build_scene(SETTINGS)
    SETTINGS.write(files.settings)
    scene.pins.write(files.played)
    simulate(
        "demo_harness",
        "tb.firmware.firmware_bench",
        generics={
            "LANES": SETTINGS.lanes,
            "CAPTURE_DEPTH": SETTINGS.capture_depth,
            "PLAYED": str(files.played),
            "RECORDED": str(files.recorded),
        },
        environment={"ARCTRUE_DEMO_FOLDER": str(files.folder)},
        backend="llvm",
        stop_time=STOP_TIME,
    )
    outcome = json.loads(files.run.read_text("utf-8"))
    told = outcome["told"]
    # A count is 158″ here: its rounding alone is above the alarm's preset.
    assert (told["result"], told["alarms"]) == ("applied", ["noise"])
    assert "refused" not in outcome["status"]

    counts = np.array(outcome["bank"], dtype=np.int64).reshape(-1, 2).T
    assert counts.shape[1] == told["samples"]
    reference = calibrate_capture(counts, SETTINGS)
    chosen = {int(n): (a, p) for n, a, p, _, applied in told["harmonics"] if applied}
    assert sorted(chosen) == sorted(reference.orders)
    for order, amplitude, phase in zip(
        reference.orders, reference.amplitudes_counts, reference.phases_rad, strict=True
    ):
        # Nine decimals on the console.
        assert chosen[order][0] == pytest.approx(amplitude * SETTINGS.arcsec_per_count, abs=2e-9)
        assert chosen[order][1] == pytest.approx(phase, abs=2e-9)

    output = decode_recording(PinEvents.read(files.recorded))
    latency = pin_to_pin_latency(scene, SETTINGS, output)
    before = turn_error(scene, SETTINGS, output, latency, latency)
    after = turn_error(scene, SETTINGS, output, outcome["settled_clock"], latency)
    assert before.peak_counts > 5.0
    assert after.peak_counts < PEAK_LIMIT_COUNTS
    assert after.amplitude_counts.max() < before.amplitude_counts.max() / 10.0
