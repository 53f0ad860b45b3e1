"""Finds a lag between a condition and an error that a product of parts describes as a function of
it.

A body that follows a condition T through a first order lag has T_b′ = (T − T_b)/τ. The product of T
alone then has too small a size. The remaining error, plotted over T, is a loop with the periods of
T itself.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from arctrue.workbench.diagnose.candidate import Candidate
from arctrue.workbench.effects.first_order_lag import behind, both_ways
from arctrue.workbench.effects.part_conditions import LAG, TEMPERATURE
from arctrue.workbench.effects.product_of_parts import ProductOfParts
from arctrue.workbench.inference.design_matrix import channel_columns
from arctrue.workbench.inference.solution import Solution

Float = NDArray[np.float64]

MOST_OF_LEFT = 0.5
"""Smallest share that the lag must remove of two errors: the error that remains with the condition
alone, and the error that remains with the condition after symmetric smoothing. Any smoothing
removes most of the noise and display steps of a recorded column; only a real lag also removes the
error that symmetric smoothing leaves."""
AHEAD_SPANS = 0.125
"""Longest lag, in lengths of the record: with a longer lag, the error depends on the condition
before the first row, which is not known."""
TRIED = 24
"""Number of lags that are tried, in equal ratios: each is less than half longer than the one
before. The same number is then tried between the neighbours of the best lag."""
LEAST_ROWS = 100
"""Smallest number of rows: a lag, a size, a constant and the model's orders are fitted to them."""
MOST_ROWS = 20_000
"""Largest number of rows with which lags are tried, to limit cost: neighbouring rows of a longer
record are averaged."""
LEAST_CHANGE = 3.0
"""Smallest number of reversals of the condition behind the lag: if a condition only rises evenly,
its lag is an offset."""


@dataclass(frozen=True)
class Lag:
    """Time constant and size of an error that follows a condition through a lag."""

    part: str
    time_constant_s: float
    size: float
    unit: str

    def words(self) -> str:
        """Describe the lag in words."""
        lag_s = float(f"{self.time_constant_s:.3g}")
        return (
            f"The error follows {self.part} with a lag of about {lag_s:g} s: with "
            f"this lag its size is {abs(self.size):.3g}{self.unit}. A further line or slow change "
            "at the periods of this column is not another error."
        )


def lag_of(item: Candidate | None, base: Solution) -> Lag | None:
    """Return the lag of the condition of a product without orders, in a reference with times; None
    if the rows show no lag."""
    rows = base.observations.reference
    if item is None or not isinstance(item.effect, ProductOfParts) or rows is None:
        return None
    condition = item.effect.condition
    if condition.form == LAG and condition.time_constant_s is not None:
        size, unit = item.parameters()["size"].value, f"″{_per(condition.unit)}"
        return Lag(condition.part.removeprefix("lag:"), condition.time_constant_s, size, unit)
    recorded = condition.column is not None or condition is TEMPERATURE
    if item.effect.orders or condition.by_direction or not recorded:
        return None
    values, time_s = condition.values(rows), rows.time_s
    if values is None or time_s is None or time_s.size < LEAST_ROWS:
        return None
    if not np.all(np.diff(time_s) > 0.0):
        return None
    columns = channel_columns(base.terms, base.observations, base.context, capture=False)
    others = np.column_stack([np.ones(time_s.size), columns])
    each = -(-time_s.size // MOST_ROWS)
    values, time_s, others = (_averaged(one, each) for one in (values, time_s, others))
    measured = _averaged(rows.measured_arcsec, each)
    alone, _ = _left(others, values, measured)
    longest, shortest = AHEAD_SPANS * float(np.ptp(time_s)), float(np.median(np.diff(time_s)))
    if longest <= shortest:
        return None
    lags = np.geomspace(shortest, longest, TRIED)
    tried = [_left(others, behind(values, time_s, lag), measured) for lag in lags]
    at = int(np.argmin([left for left, _ in tried]))
    if at == TRIED - 1 or tried[at][0] > (1.0 - MOST_OF_LEFT) * alone:
        return None
    symmetric = min(_left(others, both_ways(values, time_s, lag), measured)[0] for lag in lags)
    if tried[at][0] > (1.0 - MOST_OF_LEFT) * symmetric:
        return None
    fine = np.geomspace(lags[max(at - 1, 0)], lags[at + 1], TRIED)
    tried = [_left(others, behind(values, time_s, lag), measured) for lag in fine]
    at = int(np.argmin([left for left, _ in tried]))
    smooth = behind(values, time_s, float(fine[at]))
    turns = np.count_nonzero(np.diff(np.sign(np.diff(smooth))))
    if turns < LEAST_CHANGE:
        return None
    return Lag(condition.part, float(fine[at]), tried[at][1], f"″{_per(condition.unit)}")


def _per(unit: str) -> str:
    return "" if unit in ("", "1") else f"/{unit}"


def _averaged(values: Float, each: int) -> Float:
    """Return the means of ``each`` neighbouring rows; the last mean may have fewer."""
    if each == 1:
        return values
    first = np.arange(0, values.shape[0], each)
    rows = np.diff(np.append(first, values.shape[0]))
    means = np.add.reduceat(values, first, axis=0).T / rows
    return np.asarray(means.T)


def _left(others: Float, own: Float, measured: Float) -> tuple[float, float]:
    """Return the sum of squares that remains with a column, and this column's coefficient."""
    columns = np.column_stack([own, others])
    fitted = np.linalg.lstsq(columns, measured, rcond=1e-10)[0]
    rest = measured - columns @ fitted
    return float(rest @ rest), float(fitted[0])
