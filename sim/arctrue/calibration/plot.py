"""The picture of a calibration."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from arctrue.base.whole_file import whole_file
from arctrue.calibration.calibration import Calibration
from arctrue.calibration.comparison import ReferenceComparison, extent
from arctrue.calibration.selection import significance_factor

_BEFORE, _AFTER, _QUIET = "#b5482a", "#1f6f8b", "#8a8a8a"
_EIGHTHS_DEG = range(0, 361, 45)


def save_plot(calibration: Calibration, title: str, path: Path) -> None:
    """Write error over the turn before and after, and the amplitudes of the orders, as PNG."""
    compared = calibration.comparison is not None
    figure = Figure(figsize=(9, 9 if compared else 7), layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.subplots(3 if compared else 2, 1)
    figure.suptitle(title, parse_math=False)
    _curve(axes[0], calibration)
    if compared:
        assert calibration.comparison is not None
        _after(axes[1], calibration.comparison)
    _orders(axes[-1], calibration)
    with whole_file(path) as unfinished:
        figure.savefig(unfinished, dpi=120)


def save_comparison(comparison: ReferenceComparison, title: str, path: Path) -> None:
    """Write the errors of a reference run before and after the gateware, as PNG."""
    figure = Figure(figsize=(9, 6), layout="constrained")
    FigureCanvasAgg(figure)
    before, after = figure.subplots(2, 1)
    figure.suptitle(title, parse_math=False)
    before.plot(
        np.remainder(comparison.target_deg, 360.0),
        comparison.before_arcsec,
        ".",
        color=_BEFORE,
        ms=4,
        label="reference run",
    )
    before.set(xlabel="angle / °", ylabel="error / ″", xlim=(0, 360), xticks=_EIGHTHS_DEG)
    _head(before, "Error of head 1")
    _after(after, comparison)
    with whole_file(path) as unfinished:
        figure.savefig(unfinished, dpi=120)


def _curve(axis, calibration: Calibration) -> None:  # type: ignore[no-untyped-def]
    degrees = np.linspace(0.0, 360.0, 1441)
    estimate = calibration.estimate
    axis.plot(
        degrees,
        estimate.error_arcsec(np.radians(degrees)),
        color=_BEFORE,
        lw=1.2,
        label="from the two heads",
    )
    comparison = calibration.comparison
    if comparison is not None:
        axis.plot(
            np.remainder(comparison.target_deg, 360.0),
            comparison.before_arcsec,
            ".",
            color="black",
            ms=4,
            label="reference run",
        )
    axis.set(xlabel="angle / °", ylabel="error / ″", xlim=(0, 360), xticks=_EIGHTHS_DEG)
    _head(axis, "Error of head 1")


def _after(axis, comparison: ReferenceComparison) -> None:  # type: ignore[no-untyped-def]
    place = np.remainder(comparison.target_deg, 360.0)
    direction = comparison.direction
    for sign, name, marker in ((1, "up", "^"), (-1, "down", "v")):
        rows = np.full(place.size, sign == 1) if direction is None else direction == sign
        if rows.any():
            axis.plot(
                place[rows],
                comparison.after_arcsec[rows],
                marker,
                ms=3.5,
                ls="",
                color=_AFTER if sign == 1 else _QUIET,
                label="after" if direction is None else name,
            )
    if comparison.noise is not None:
        axis.axhspan(
            comparison.noise.lowest,
            comparison.noise.highest,
            color="black",
            alpha=0.07,
            label="scatter of the repeats",
        )
    after = extent(comparison.after_arcsec)
    axis.set(
        xlabel="angle / °",
        ylabel="error / ″",
        xlim=(0, 360),
        xticks=_EIGHTHS_DEG,
    )
    _head(axis, f"After, through the gateware: {after.lowest:+.2f} to {after.highest:+.2f}″")


def _orders(axis, calibration: Calibration) -> None:  # type: ignore[no-untyped-def]
    estimate = calibration.estimate
    applied = np.array([verdict.applied for verdict in calibration.verdicts], dtype=bool)
    seen = np.isfinite(estimate.noise_gain)
    amplitude = np.maximum(estimate.amplitude_arcsec, 1e-5)
    for chosen, colour, name in (
        (applied, _AFTER, "applied"),
        (~applied & seen, _QUIET, "not applied"),
    ):
        if chosen.any():
            axis.vlines(
                estimate.orders[chosen], 1e-5, amplitude[chosen], color=colour, lw=3, label=name
            )
    factor = significance_factor(int(np.count_nonzero(seen)))
    axis.plot(
        estimate.orders[seen],
        factor * estimate.u_component_arcsec[seen],
        "_",
        color="black",
        label=f"{factor:.1f} × standard uncertainty",
    )
    lowest = estimate.u_component_arcsec[seen].min(initial=1e-3)
    axis.set(
        yscale="log",
        xlabel="order n",
        ylabel="amplitude / ″",
        ylim=(max(lowest / 3.0, 1e-5), max(float(amplitude.max()) * 3.0, 1e-3)),
    )
    _head(axis, "Orders")


def _head(axis, title: str) -> None:  # type: ignore[no-untyped-def]
    """Title to the left, legend to the right of it: over the axes, where no point is hidden."""
    axis.set_title(title, loc="left")
    axis.legend(
        loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=3, frameon=False, fontsize="small"
    )
    axis.grid(alpha=0.3)
