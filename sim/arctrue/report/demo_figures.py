"""The pictures of the demo's page."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from arctrue.report.log_scale import set_log_y
from arctrue.report.svg import AFTER, BEFORE, INK, LIMIT, house_style, to_svg
from arctrue.studies.demo.result import DemoResult

_BINS = 1440


def error_over_a_turn(result: DemoResult) -> str:
    """Error before and after over one turn; below, the same after compensation enlarged."""
    limit = result.settings.peak_limit_counts
    with house_style():
        figure = Figure(figsize=(9.6, 5.6), layout="constrained")
        upper, lower = figure.subplots(2, 1, sharex=True, height_ratios=[3, 2])
        _band(upper, result.before.true_angle_rad, result.before.error_counts, BEFORE, "before")
        _band(upper, result.after.true_angle_rad, result.after.error_counts, AFTER, "after")
        upper.set_title("Output against the true angle")
        upper.set_ylabel("error, counts")
        upper.legend(loc="lower right", bbox_to_anchor=(1.0, 0.98), ncols=2)
        arcsec = result.settings.arcsec_per_count
        right = upper.secondary_yaxis(
            "right", functions=(lambda count: count * arcsec, lambda second: second / arcsec)
        )
        right.set_ylabel("error, arcsec")
        right.spines["right"].set_visible(True)

        _band(lower, result.after.true_angle_rad, result.after.error_counts, AFTER, "after")
        for sign in (-1, 1):
            lower.axhline(sign * limit, color=LIMIT, linestyle=(0, (4, 3)), linewidth=1)
        lower.annotate(
            f"limit ±{limit:g} counts",
            (360, limit),
            xytext=(-4, 3),
            textcoords="offset points",
            ha="right",
            color=LIMIT,
        )
        lower.set_title("After compensation, enlarged")
        lower.set_ylabel("error, counts")
        lower.set_xlabel("true angle of the table, °")
        lower.set_xlim(0, 360)
        lower.set_xticks(range(0, 361, 45))
        reach = max(limit, result.after.peak_counts) * 1.3
        lower.set_ylim(-reach, reach)
        return to_svg(figure)


def spectrum(result: DemoResult, orders: int = 24) -> str:
    """Amplitude of every order before and after, on a logarithmic scale."""
    limit = result.settings.order_limit_counts
    floor = 1e-3
    with house_style():
        figure = Figure(figsize=(9.6, 3.6), layout="constrained")
        axes = figure.subplots()
        for turn, shift, colour, name in (
            (result.before, -0.2, BEFORE, "before"),
            (result.after, 0.2, AFTER, "after"),
        ):
            shown = turn.order <= orders
            axes.bar(
                turn.order[shown] + shift,
                np.maximum(turn.amplitude_counts[shown], floor) - floor,
                0.38,
                bottom=floor,
                color=colour,
                label=name,
            )
        axes.axhline(limit, color=LIMIT, linestyle=(0, (4, 3)), linewidth=1)
        axes.annotate(
            f"limit {limit:g} count an order",
            (orders + 0.6, limit),
            xytext=(-4, 4),
            textcoords="offset points",
            ha="right",
            color=LIMIT,
        )
        set_log_y(axes)
        axes.set_ylim(floor, 2 * result.before.amplitude_counts.max())
        axes.set_xlim(0.4, orders + 0.6)
        axes.set_xticks(range(1, orders + 1))
        axes.grid(axis="x", visible=False)
        axes.set_xlabel("order n, cycles a turn")
        axes.set_ylabel("amplitude, counts")
        axes.set_title("Orders of the error", color=INK)
        axes.legend(loc="lower right", bbox_to_anchor=(1.0, 0.98), ncols=2)
        return to_svg(figure)


def _band(
    axes: Axes,
    angle_rad: NDArray[np.float64],
    error: NDArray[np.float64],
    colour: str,
    name: str,
) -> None:
    # Every edge counts: each quarter of a degree is drawn from its lowest to its highest edge.
    angle_deg = np.rad2deg(angle_rad)
    place = np.minimum((angle_deg * (_BINS / 360)).astype(np.int64), _BINS - 1)
    lowest, highest = np.full(_BINS, np.inf), np.full(_BINS, -np.inf)
    np.minimum.at(lowest, place, error)
    np.maximum.at(highest, place, error)
    filled = highest >= lowest
    middle = (np.arange(_BINS) + 0.5) * (360 / _BINS)
    axes.fill_between(
        middle[filled],
        lowest[filled],
        highest[filled],
        color=colour,
        linewidth=0.9,
        label=name,
    )
