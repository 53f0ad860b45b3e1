"""Tests that the host refuses the same coefficient files as the firmware."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from sim.tests.calibration.synthetic import COUNTS
from sim.tests.firmware.model_core import Firmware
from sim.tests.firmware.test_load import running, send
from sim.tests.firmware.test_load_real import REAL_ORDERS
from sim.tests.firmware.test_load_table import LOCAL_TABLE

from arctrue.calibration.acceptance import of_limits
from arctrue.device.load import load_frames
from arctrue.gateware.coefficients import Coefficients, Extension
from arctrue.gateware.extension import POINTS, Conditions, LocalTable
from arctrue.gateware.lane_words import AMPLITUDE_LIMIT_COUNTS
from arctrue.gateware.thermal import ThermalLanes

__all__ = ["running"]

LANES = 32
ORDER = 2000
WIDTH_COUNTS = 200.0
NOMINAL_DEG_S = 900.0
"""Nominal speed; with it, no lane of these files makes the measurement of the speed unstable."""
EVERYTHING = 1 << 5 | REAL_ORDERS | LOCAL_TABLE | 2
"""Bits of ``capability``: MODULATORS, REAL_ORDERS, LOCAL_TABLE, and two heads."""


def everything(running: Firmware) -> None:
    running.core.set("version", 0x000800)
    running.core.set("capability", EVERYTHING)


def file_of(
    plain: float = 0.0,
    reversal: float = 0.0,
    following: float = 0.0,
    real: float = 0.0,
    table: float = 0.0,
    warm: float = 0.0,
    followed_lanes: int = 1,
    real_lanes: int = 1,
) -> Coefficients:
    """Return coefficients whose parts have these slopes |dε/dR|.

    ``plain``: a lane of order 2000. ``reversal``: lanes of order 0 × direction. ``following``: a
    lane of order 2000 × speed. ``real``: lanes of orders that are not integers. ``table``: a local
    table. ``warm``: the amplitude that order 2000 gains at the end of the temperature range.
    """
    counts = COUNTS / (2.0 * np.pi)
    rows: list[tuple[int, float]] = [(ORDER, plain * counts / ORDER)]
    modulators = []
    if reversal:
        for _ in range(followed_lanes):
            modulators.append((len(rows), "direction"))
            rows.append((0, reversal * WIDTH_COUNTS / followed_lanes))
    if following:
        modulators.append((len(rows), "speed"))
        rows.append((ORDER, following * counts / ORDER))
    reals = {}
    if real:
        for number in range(real_lanes):
            order = 1000.5 + number
            reals[len(rows)] = order
            rows.append((0, real * counts / order / real_lanes))
    orders, sizes = zip(*rows, strict=True)
    made = Coefficients.from_harmonics(orders, sizes, [0.3] * len(rows), COUNTS, LANES)
    local = None
    if table:
        step = COUNTS / POINTS
        place = np.arange(POINTS) % 4
        points = np.rint(np.minimum(place, 4 - place) * step * table * 16).astype(int)
        local = LocalTable(tuple(points.tolist()), (0,), 0, 4)
    conditions = Conditions(round(16 * WIDTH_COUNTS), 0, NOMINAL_DEG_S) if modulators else None
    extension = Extension(conditions=conditions, modulators=tuple(modulators), local_table=local)
    made = dataclasses.replace(made, extension=extension)
    made = made.with_real_orders(reals) if reals else made
    if warm:
        slopes = {ORDER: np.array([warm * counts / ORDER / 10.0, 0.0, 0.0, 0.0])}
        made = dataclasses.replace(made, thermal=ThermalLanes.from_slopes(slopes, 20.0))
    return made


def answer(running: Firmware, coefficients: Coefficients) -> str:
    """Return the firmware's answer: ``ok`` or the reason of the first refusal."""
    answers = send(running, load_frames(coefficients, force=True))
    refused = [text.split()[-1] for text in answers if text != "ok"]
    running.send("load abort")
    return refused[0] if refused else "ok"


def judged(coefficients: Coefficients) -> str:
    """Return the answer that the host's objections announce."""
    words = {
        "too steep": "too_steep",
        "would change by": "too_steep",
        "the firmware holds no more": "too_many_lanes",
    }
    objections = of_limits(coefficients)
    found = [reason for said, reason in words.items() for text in objections if said in text]
    assert len(found) >= len(objections)
    return found[-1] if found else "ok"


@pytest.mark.parametrize(
    ("parts", "expected"),
    [
        ({"plain": 0.7, "reversal": 0.25}, "ok"),
        ({"plain": 0.7, "reversal": 0.4}, "too_steep"),
        ({"reversal": 0.49}, "ok"),
        ({"reversal": 0.51}, "too_steep"),
        ({"plain": 0.9, "following": 0.05}, "ok"),
        ({"plain": 0.9, "following": 0.2}, "too_steep"),
        ({"plain": 0.7, "real": 0.2}, "ok"),
        ({"plain": 0.7, "real": 0.4}, "too_steep"),
        ({"plain": 0.7, "table": 0.4}, "too_steep"),
        ({"plain": 0.5, "warm": 0.3}, "ok"),
        ({"plain": 0.5, "warm": 0.6}, "too_steep"),
        # The speed's lane has the order of the lane that follows the temperature, but does not
        # follow the temperature itself.
        ({"plain": 0.3, "following": 0.2, "warm": 0.4}, "ok"),
        ({"real": 0.1, "real_lanes": 8}, "ok"),
        ({"real": 0.1, "real_lanes": 9}, "too_many_lanes"),
        ({"reversal": 0.1, "followed_lanes": 8}, "ok"),
        ({"reversal": 0.1, "followed_lanes": 9}, "too_many_lanes"),
    ],
)
def test_host_and_firmware_give_the_same_answers(
    running: Firmware, parts: dict[str, float], expected: str
) -> None:
    everything(running)
    coefficients = file_of(**parts)  # type: ignore[arg-type]
    assert answer(running, coefficients) == expected
    assert judged(coefficients) == expected


def test_random_files_get_the_same_answer(running: Firmware) -> None:
    """Of 60 files with random parts, about half are refused; no slope happens to be within 10⁻⁹ of
    a limit."""
    everything(running)
    random = np.random.default_rng(7)
    answers = []
    for _ in range(60):
        plain, reversal, following, real, table, warm = random.uniform(0.0, 0.45, 6) * (
            random.uniform(size=6) < 0.6
        )
        coefficients = file_of(
            plain,
            reversal * 1.3,
            following,
            real,
            table,
            warm,
            int(random.integers(1, 8)),
            int(random.integers(1, 9)),
        )
        assert np.abs(coefficients.amplitudes_counts).max() < AMPLITUDE_LIMIT_COUNTS
        answers.append(answer(running, coefficients))
        assert judged(coefficients) == answers[-1]
    assert {"ok", "too_steep"} <= set(answers)
    assert 10 <= answers.count("ok") <= 50


def test_the_limit_of_a_reversal_is_that_of_the_firmware(running: Firmware) -> None:
    """Host and firmware agree just below and just above a slope of 1/2, at which only the limit of
    the reversal is exceeded."""
    everything(running)
    for slope, expected in ((0.499, "ok"), (0.501, "too_steep")):
        coefficients = file_of(reversal=slope)
        assert judged(coefficients) == expected
        assert answer(running, coefficients) == expected
