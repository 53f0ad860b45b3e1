"""Places a legend below its axes, where it covers no curve."""

from __future__ import annotations

from matplotlib.axes import Axes
from matplotlib.transforms import ScaledTranslation

BELOW_AXES_POINTS = 36.0
"""Space in points between the axes and the legend, for the numbers and the label of the horizontal
axis."""


def legend_below(axes: Axes, *, columns: int) -> None:
    """Place the legend below the label of the horizontal axis, in this number of columns."""
    figure = axes.get_figure(root=True)
    assert figure is not None
    down = ScaledTranslation(0.0, -BELOW_AXES_POINTS / 72.0, figure.dpi_scale_trans)
    axes.legend(
        loc="upper center",
        bbox_to_anchor=(0.5, 0.0),
        bbox_transform=axes.transAxes + down,
        ncols=columns,
        fontsize=8,
    )
