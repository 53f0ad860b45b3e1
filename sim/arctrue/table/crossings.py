"""Finds, for each of many functions at once, the argument at which the function reaches its
target."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

Function = Callable[[NDArray[np.float64]], NDArray[np.float64]]


def solve_brackets(
    function: Function,
    lower: NDArray[np.float64],
    upper: NDArray[np.float64],
    target: NDArray[np.float64],
    *,
    tolerance: float,
    iterations: int = 100,
) -> NDArray[np.float64]:
    """Return the arguments between ``lower`` and ``upper`` at which ``function`` equals ``target``,
    shape ``(n,)``.

    Each bracket contains one root, at which ``function − target`` changes its sign. The method is
    false position in the Illinois variant (which halves the value at the end that it keeps), with a
    bisection in every fourth step. It stops when |function − target| <= ``tolerance``. Raises
    ArithmeticError if the sign does not change in a bracket, or if ``iterations`` do not suffice.
    """
    low, high = lower.astype(np.float64), upper.astype(np.float64)
    value_low, value_high = function(low) - target, function(high) - target
    if np.any(value_low * value_high > 0):
        bad = int(np.argmax(value_low * value_high > 0))
        raise ArithmeticError(
            f"no crossing of {target[bad]} between {low[bad]} and {high[bad]}: "
            f"{value_low[bad]:+g} and {value_high[bad]:+g} from it"
        )
    at_low = np.abs(value_low) < np.abs(value_high)
    root = np.where(at_low, low, high)
    active = np.flatnonzero(np.minimum(np.abs(value_low), np.abs(value_high)) > tolerance)
    low, high = low[active], high[active]
    value_low, value_high = value_low[active], value_high[active]
    for iteration in range(iterations):
        if not active.size:
            return root
        if iteration % 4 == 3:
            middle = (low + high) / 2
        else:
            middle = high - value_high * (high - low) / (value_high - value_low)
        value = function(middle) - target[active]
        root[active] = middle
        same_as_low = value * value_low > 0
        value_high = np.where(same_as_low, value_high / 2, value)
        value_low = np.where(same_as_low, value, value_low / 2)
        low, high = np.where(same_as_low, middle, low), np.where(same_as_low, high, middle)
        going_on = np.abs(value) > tolerance
        active, low, high = active[going_on], low[going_on], high[going_on]
        value_low, value_high = value_low[going_on], value_high[going_on]
    if active.size:
        raise ArithmeticError(
            f"{active.size} crossings not found to {tolerance} in {iterations} steps; "
            f"the first is that of {target[active[0]]}"
        )
    return root


def level_crossings(
    function: Function, grid: NDArray[np.float64], offset: float, *, tolerance: float
) -> tuple[NDArray[np.float64], NDArray[np.int64], NDArray[np.int8]]:
    """Return every crossing of ``function`` through a level k + ``offset`` with whole k, in order.

    ``grid`` rises, and ``function`` must be monotonic between neighbouring points of the grid.
    Returns the arguments, the levels k and the directions (+1 upwards, −1 downwards), each
    ``(n,)``.
    """
    values = function(grid)
    cell = np.floor(values - offset).astype(np.int64)
    passed = np.diff(cell)
    number = np.abs(passed)
    interval = np.repeat(np.arange(number.size), number)
    within = np.arange(interval.size) - np.repeat(np.cumsum(number) - number, number)
    step = np.sign(passed)[interval]
    level = np.where(step > 0, cell[interval] + 1 + within, cell[interval] - within)
    where = solve_brackets(
        function, grid[interval], grid[interval + 1], level + offset, tolerance=tolerance
    )
    return where, level, step.astype(np.int8)
