"""Tests how the firmware computes the angle at the last index, in both directions and with
positions that wrap. This angle is the number of counts by which a head's zero has moved."""

from __future__ import annotations

import numpy as np
import pytest
from sim.tests.firmware.library import firmware
from sim.tests.firmware.model_core import ModelCore


@pytest.mark.parametrize("counts_per_rev", [4, 8192, 12_000_001, 1 << 24])
@pytest.mark.parametrize("head", [0, 1])
def test_angle_at_the_last_index(counts_per_rev: int, head: int) -> None:
    _ffi, library = firmware()
    core = ModelCore()
    random = np.random.default_rng(counts_per_rev + head)
    for _ in range(200):
        # The index has a random 32-bit position; since then the table has moved by up to a turn in
        # either direction.
        index = int(random.integers(0, 1 << 32))
        travel = int(random.integers(-counts_per_rev + 1, counts_per_rev))
        slip = int(random.integers(-((counts_per_rev - 1) // 2), counts_per_rev // 2 + 1))
        core.set(f"head{head + 1}.index", index)
        core.set(f"snapshot.head{head + 1}_position", index + travel)
        core.set(f"snapshot.head{head + 1}_angle", (slip + travel) % counts_per_rev)
        assert library.core_angle_at_index(core.access, head, counts_per_rev) == slip
