"""Tests that the recorder writes exactly the file that the player plays."""

from pathlib import Path

import numpy as np
import pytest

from arctrue.table import PinEvents
from tb.support.simulation import simulate


def play(played: Path, recorded: Path) -> None:
    simulate(
        "edge_file_harness",
        "tb.demo.edge_file_bench",
        generics={"PLAYED": str(played), "RECORDED": str(recorded)},
    )


def test_recorded_file_equals_the_played_one(tmp_path: Path) -> None:
    random = np.random.default_rng(2)
    clock = np.cumsum(random.integers(1, 5, 5000))
    levels = np.cumsum(random.integers(1, 64, 5000)) % 64  # successive levels differ
    events = PinEvents(0, clock, levels.astype(np.uint8))
    events.write(tmp_path / "played.txt")
    play(tmp_path / "played.txt", tmp_path / "recorded.txt")
    assert (tmp_path / "recorded.txt").read_text() == (tmp_path / "played.txt").read_text()


@pytest.mark.parametrize("text", ["0 1\n5 64\n", "0 1\n0 2\n", "0 1\n4\n", ""])
def test_wrong_file_stops_the_simulation(tmp_path: Path, text: str) -> None:
    (tmp_path / "played.txt").write_text(text)
    with pytest.raises((AssertionError, SystemExit, OSError, RuntimeError)):
        play(tmp_path / "played.txt", tmp_path / "recorded.txt")
