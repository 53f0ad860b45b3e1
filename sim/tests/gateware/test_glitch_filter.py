"""Tests that the model of the glitch filter follows the definition of the filter at each sample."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from arctrue.gateware.glitch_filter import glitch_filter


def by_definition(levels: list[int], lengths: list[int]) -> list[int]:
    """Return the output after each clock: it takes over a level that has lasted for ``length``
    samples."""
    output, outputs = levels[0], []
    for clock, length in enumerate(lengths):
        window = levels[clock + 1 - max(length, 1) : clock + 1] if clock + 1 >= length else []
        if window and len(set(window)) == 1:
            output = window[0]
        outputs.append(output)
    return outputs


@given(st.lists(st.tuples(st.integers(0, 1), st.integers(0, 6)), min_size=1, max_size=80))
def test_level_is_taken_over_after_enough_equal_samples(samples: list[tuple[int, int]]) -> None:
    levels, lengths = (list(column) for column in zip(*samples, strict=True))
    reset = np.arange(len(levels)) == 0
    assert glitch_filter(levels, lengths, reset)[1:].tolist() == by_definition(levels, lengths)


@pytest.mark.parametrize("length", [2, 9, 255])
def test_pulse_one_sample_too_short_leaves_no_trace(length: int) -> None:
    levels = np.zeros(1000, dtype=int)
    levels[300 : 300 + length - 1] = 1
    assert not glitch_filter(levels, length).any()
    levels[300 + length - 1] = 1
    filtered = glitch_filter(levels, length)
    assert np.flatnonzero(filtered)[0] == 300 + length
    assert filtered.sum() == length


@pytest.mark.parametrize("level", [0, 1])
def test_reset_takes_the_level_over_at_once(level: int) -> None:
    reset = np.arange(20) == 7
    levels = np.where(np.arange(20) < 5, 1 - level, level)
    filtered = glitch_filter(levels, 100, reset)
    assert (filtered[8:] == level).all()


def test_shapes_that_do_not_fit_are_refused() -> None:
    with pytest.raises(ValueError, match="shape"):
        glitch_filter(np.zeros(10), np.ones(11))
