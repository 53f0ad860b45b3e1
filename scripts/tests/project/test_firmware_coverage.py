"""Tests how scripts/firmware_coverage.py combines the counts of several objects; ``make
coverage-firmware`` runs the whole script."""

from __future__ import annotations

import json

from scripts.firmware_coverage import FIRMWARE, LEAST, counted, share


def _answer(file: str, lines: dict[int, int]) -> str:
    rows = [{"line_number": number, "count": count} for number, count in lines.items()]
    return json.dumps({"files": [{"file": file, "lines": rows}]})


def test_a_line_that_any_object_runs_is_run() -> None:
    """A line counts as executed if any object executes it, because a header is compiled into
    several objects; files outside the firmware do not count."""
    header = str(FIRMWARE / "calibration" / "capture.h")
    counts = counted(
        [
            _answer(header, {10: 0, 11: 3, 12: 0}),
            _answer(header, {10: 2, 11: 0, 12: 0}),
            _answer("/usr/include/math.h", {1: 0}),
        ]
    )
    assert counts == {"calibration/capture.h": {10: 2, 11: 3, 12: 0}}
    assert share(counts["calibration/capture.h"]) == 2 / 3 < LEAST
