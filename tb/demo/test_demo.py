"""The whole demo at an eighth of its counts: table, core, calibration, corrected edges."""

from pathlib import Path

import numpy as np
import pytest

from arctrue.demo.files import DemoFiles, ProcessorRun
from arctrue.demo.run import run_demo
from arctrue.demo.settings import DemoSettings
from arctrue.table import PinEvents

# One lane fewer than the disc has orders: the smallest is left, too small for the limit here.
SETTINGS = DemoSettings(counts_per_rev=1 << 13, lanes=3, disc_scale=16.0)


@pytest.mark.slow
def test_error_falls_through_the_real_core(tmp_path: Path) -> None:
    lines: list[str] = []
    result = run_demo(SETTINGS, tmp_path, lines.append)
    assert result.faults == ()
    assert result.before.peak_counts > 14
    assert result.after.peak_counts <= SETTINGS.peak_limit_counts
    assert [harmonic.order for harmonic in result.harmonics] == [1, 2, 3]
    assert any("reading the capture memory" in line for line in lines)

    files = DemoFiles(tmp_path)
    run = ProcessorRun.read(files.run)
    counts = np.load(files.capture)
    assert counts.shape == (2, run.samples)
    assert counts[0, -1] - counts[0, 0] >= SETTINGS.counts_per_rev > counts[0, -2] - counts[0, 0]
    # No edge of the output is illegal or nearer than a clock to the one before it.
    assert np.diff(PinEvents.read(files.recorded).clock).min() >= 1
