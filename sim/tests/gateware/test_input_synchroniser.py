"""Tests that the model of the synchroniser delays its input."""

import numpy as np
import pytest

from arctrue.gateware.input_synchroniser import input_synchroniser


@pytest.mark.parametrize("stages", [2, 3, 4])
def test_levels_come_stages_clocks_later(stages: int) -> None:
    levels = np.random.default_rng(0).integers(2, size=(50, 3))
    delayed = input_synchroniser(levels, stages)
    assert delayed.shape == levels.shape
    assert (delayed[stages:] == levels[:-stages]).all()
    assert not delayed[:stages].any()
    # The input has fewer samples than the delay.
    assert input_synchroniser([1], stages).tolist() == [0]


@pytest.mark.parametrize("stages", [1, 5])
def test_other_numbers_of_stages_are_refused(stages: int) -> None:
    with pytest.raises(ValueError, match="expected 2 to 4"):
        input_synchroniser([0, 1], stages)
