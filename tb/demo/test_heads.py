"""Tests that the decoders in VHDL output the counts of the simulated table."""

from pathlib import Path

import numpy as np

from arctrue.table import (
    DiscEccentricity,
    GraduationHarmonics,
    Motion,
    RotaryTable,
    clocked_pins,
    count_edges,
    two_heads,
)
from tb.support.simulation import simulate

CLOCK_HZ = 1e6
# latency of quadrature_decoder: synchroniser 2, filter (off) 1, decoding 2
DECODER_CLOCKS = 5


def test_decoders_show_the_counts_of_the_table(tmp_path: Path) -> None:
    table = RotaryTable(
        two_heads(),
        (DiscEccentricity(400e-6, 2.0), GraduationHarmonics((2,), (5e-4,), (0.4,))),
        counts_per_rev=4096,
        noise_rad=2e-5,
    )
    # The table turns from −40° over both marks, past a whole turn, and back over both marks.
    motion = Motion((0.0, 2e-3, 12e-3, 14e-3, 21e-3), (0.0, 800.0, 800.0, -1000.0, -1000.0), -0.7)
    random = np.random.default_rng(7)
    heads = [count_edges(table, head, motion, random) for head in (0, 1)]
    assert heads[0].count.max() > table.counts_per_rev
    assert heads[0].count[-1] < 4000
    clocked_pins(heads, table.counts_per_rev, CLOCK_HZ).write(tmp_path / "played.txt")
    simulate(
        "heads_harness",
        "tb.demo.heads_bench",
        generics={"PLAYED": str(tmp_path / "played.txt"), "COUNTS_PER_REV": table.counts_per_rev},
        environment={"ARCTRUE_NOTED": str(tmp_path / "noted.npy")},
    )
    noted = np.load(tmp_path / "noted.npy")
    clock = noted[:, 0]
    for head, edges in enumerate(heads):
        played = np.ceil(edges.time_s * CLOCK_HZ)
        index = np.searchsorted(played, clock - DECODER_CLOCKS, side="right")
        expected = np.concatenate([[edges.first_count], edges.count])[index]
        seen = noted[:, 5 + head] == 1
        assert 0 < np.count_nonzero(~seen) < np.count_nonzero(seen)
        np.testing.assert_array_equal(noted[seen, 1 + head], expected[seen])
        np.testing.assert_array_equal(noted[seen, 3 + head], expected[seen] % table.counts_per_rev)
