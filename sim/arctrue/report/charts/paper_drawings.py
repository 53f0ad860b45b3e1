"""Redraws the paper's figures 1, 3 to 9, A.1 and A.2 for this implementation.

The numbers in the figures are taken from the constants of the number formats. Figures 2 and 10 are
photographs.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle, FancyBboxPatch

from arctrue.generated.number_formats import (
    AMPLITUDE_FRACTION,
    AMPLITUDE_WIDTH,
    ANGLE_WIDTH,
    CAPTURE_DEPTH_DEFAULT,
    COMPENSATION_LATENCY,
    CORDIC_ITERATIONS,
    COSINE_WIDTH,
    DELAY_LINE_LATENCY,
    HARMONIC_LATENCY,
    LANES_DEFAULT,
    PHASE_LATENCY,
    PHASE_STEP_WIDTH,
    PHASE_WIDTH,
    POSITION_WIDTH,
)
from arctrue.report.log_scale import set_log_y
from arctrue.report.picture_file import save_picture
from arctrue.report.svg import AFTER, BEFORE, INK, LIMIT, MUTED, house_style
from arctrue.studies.paper.appendix import approximation_bound, rounding_bound
from arctrue.table.pins import pin_states

_SUPERSCRIPT = str.maketrans("0123456789", "⁰¹²³⁴⁵⁶⁷⁸⁹")
_GATEWARE, _SOFTWARE, _OUTSIDE = "#e4eff7", "#fbeedd", "#f1f3f5"

Box = tuple[float, float, float, float, str, str]
"""A box: left, bottom, width and height in units of the drawing, text, colour."""
Arrow = tuple[tuple[float, float], tuple[float, float], str]


def _boxes(axes: Axes, boxes: Sequence[Box], arrows: Sequence[Arrow]) -> None:
    """Draw boxes and arrows on an empty page that is 100 units wide, with a margin for the
    outlines."""
    axes.set_axis_off()
    axes.set_xlim(-1, 101)
    for left, bottom, width, height, text, colour in boxes:
        axes.add_patch(
            FancyBboxPatch(
                (left, bottom),
                width,
                height,
                boxstyle="round,pad=0.2",
                facecolor=colour,
                edgecolor=MUTED,
                linewidth=0.9,
            )
        )
        axes.text(left + width / 2, bottom + height / 2, text, ha="center", va="center", fontsize=8)
    for start, end, text in arrows:
        axes.annotate(
            "", end, start, arrowprops={"arrowstyle": "-|>", "color": INK, "linewidth": 1.0}
        )
        if text:
            axes.text(
                (start[0] + end[0]) / 2,
                (start[1] + end[1]) / 2 + 0.6,
                text,
                ha="center",
                va="bottom",
                fontsize=7,
                color=MUTED,
            )


def _figure_1(axes: Axes) -> None:
    axes.set_axis_off()
    axes.set_aspect("equal")
    axes.set_xlim(-1.7, 2.1)
    axes.set_ylim(-1.45, 1.45)
    axes.add_patch(Circle((0, 0), 1.0, facecolor=_OUTSIDE, edgecolor=MUTED))
    for line in np.arange(0, 360, 3):
        c, s = np.cos(np.radians(line)), np.sin(np.radians(line))
        axes.plot([0.95 * c, c], [0.95 * s, s], color=MUTED, linewidth=0.6)
    for place, name in ((0.0, "head 1, at 0: R₁ = θ + ε(θ)"),
                        (-33.0, "head 2, at −α: R₂ = θ + α + ε(θ + α)")):  # fmt: skip
        c, s = np.cos(np.radians(place)), np.sin(np.radians(place))
        axes.plot([1.08 * c], [1.08 * s], marker="s", markersize=11, color=AFTER)
        axes.plot([0, c], [0, s], color=LIMIT, linewidth=0.9)
        axes.text(1.2 * c, 1.2 * s, name, va="center", fontsize=8)
    arc = np.radians(np.linspace(-33, 0, 30))
    axes.plot(0.5 * np.cos(arc), 0.5 * np.sin(arc), color=INK)
    axes.text(0.56, -0.19, "α = 33°", fontsize=8)
    turn = np.radians(np.linspace(60, 120, 30))
    axes.plot(1.2 * np.cos(turn), 1.2 * np.sin(turn), color=INK)
    axes.annotate(
        "", (1.2 * np.cos(turn[-1]), 1.2 * np.sin(turn[-1])),
        (1.2 * np.cos(turn[-4]), 1.2 * np.sin(turn[-4])), arrowprops={"arrowstyle": "-|>"},
    )  # fmt: skip
    axes.text(0.0, 1.28, "θ rises: a line passes head 2 first", ha="center", fontsize=8)


def _figure_3(axes: Axes) -> None:
    axes.set_ylim(0, 34)
    _boxes(
        axes,
        [
            (0, 22, 13, 8, "read head 1\nreference", _OUTSIDE),
            (0, 6, 13, 8, "read head 2\ncalibration", _OUTSIDE),
            (22, 22, 15, 8, "decoder 1", _GATEWARE),
            (22, 6, 15, 8, "decoder 2", _GATEWARE),
            (46, 22, 22, 8, f"real-time compensation\n{LANES_DEFAULT} lanes", _GATEWARE),
            (46, 6, 15, 8, f"sampler\n2 × {CAPTURE_DEPTH_DEFAULT:,}", _GATEWARE),
            (70, 6, 28, 8, "self-calibration\nfirmware in C, Cortex-A9", _SOFTWARE),
            (76, 22, 22, 8, "quadrature output\nto the servo", _GATEWARE),
        ],
        [
            ((13, 26), (22, 26), "A, B, Z"),
            ((13, 10), (22, 10), "A, B, Z"),
            ((37, 26), (46, 26), "R₁"),
            ((37, 10), (46, 10), "R₂"),
            ((34, 22), (49, 14), ""),
            ((61, 10), (70, 10), "AXI"),
            ((80, 14), (62, 22), "coefficients"),
            ((68, 26), (76, 26), "θ_com"),
        ],
    )


def _figure_4(axes: Axes) -> None:
    count = np.arange(9)
    pins = pin_states(count, 1 << 10)
    up = np.column_stack([pins & 1, pins >> 1 & 1]).astype(np.int64)
    for row, (name, values) in enumerate(
        (
            ("A, readings rise", up[:, 0]),
            ("B, readings rise", up[:, 1]),
            ("A, readings fall", up[::-1, 0]),
            ("B, readings fall", up[::-1, 1]),
        )
    ):
        low = 4.5 - 1.5 * row
        axes.step(count, low + values, where="post", color=AFTER if row % 2 == 0 else BEFORE)
        axes.text(-0.2, low + 0.4, name, ha="right", fontsize=8)
    for step in range(8):
        axes.text(step + 0.5, 6.0, f"{up[step, 0]:d}{up[step, 1]:d}", ha="center", fontsize=8)
        axes.text(
            step + 0.5, -0.7, f"{up[::-1][step, 0]:d}{up[::-1][step, 1]:d}", ha="center",
            fontsize=8,
        )  # fmt: skip
    axes.set_axis_off()
    axes.set_xlim(-2.6, 8.2)
    axes.set_ylim(-1.1, 6.5)


def _figure_5(axes: Axes) -> None:
    axes.set_ylim(0, 20)
    _boxes(
        axes,
        [
            (0, 6, 8, 8, "A, B, Z", _OUTSIDE),
            (14, 6, 15, 8, "synchroniser\n3 stages", _GATEWARE),
            (35, 6, 13, 8, "glitch filter", _GATEWARE),
            (54, 6, 17, 8, "edges: up, down,\nillegal", _GATEWARE),
            (78, 11, 20, 7, f"position s{POSITION_WIDTH - 1}.0", _GATEWARE),
            (78, 2, 20, 7, f"angle u{ANGLE_WIDTH}.0\nzero by Z", _GATEWARE),
        ],
        [
            ((8, 10), (14, 10), ""),
            ((29, 10), (35, 10), ""),
            ((48, 10), (54, 10), ""),
            ((71, 11), (78, 14), ""),
            ((71, 9), (78, 6), ""),
        ],
    )


def _figure_6(axes: Axes) -> None:
    axes.set_ylim(0, 30)
    _boxes(
        axes,
        [
            (0, 16, 14, 8, "1 kHz or\nequal angles", _GATEWARE),
            (0, 4, 14, 8, "R₁, R₂", _GATEWARE),
            (22, 10, 15, 8, "one latch\nfor both", _GATEWARE),
            (44, 10, 17, 8, f"two banks of\n{CAPTURE_DEPTH_DEFAULT:,} samples", _GATEWARE),
            (68, 18, 30, 9, "check of the steps, least squares\nor DFT · TF(n), uncertainty",
             _SOFTWARE),
            (68, 3, 30, 8, "two banks of coefficients\nswapped in one clock, ramp", _GATEWARE),
        ],
        [
            ((14, 20), (22, 15), ""),
            ((14, 8), (22, 12), ""),
            ((37, 14), (44, 14), ""),
            ((61, 15), (68, 21), "a turn"),
            ((83, 18), (83, 11), "amplitude, phase"),
        ],
    )  # fmt: skip


def _figure_7(axes: Axes) -> None:
    axes.set_ylim(0, 30)
    _boxes(
        axes,
        [
            (0, 11, 8, 8, "R₁", _OUTSIDE),
            (16, 17, 20, 9, f"phase unit\n{PHASE_LATENCY} clocks", _GATEWARE),
            (44, 17, 20, 9, f"harmonic unit\n{HARMONIC_LATENCY} clocks", _GATEWARE),
            (16, 3, 48, 8, f"delay compensation: {DELAY_LINE_LATENCY} clocks", _GATEWARE),
            (73, 10, 25, 9, f"error compensation\n{COMPENSATION_LATENCY} clocks: R − ε(R)",
             _GATEWARE),
        ],
        [
            ((8, 16), (16, 21), ""),
            ((8, 14), (16, 7), ""),
            ((36, 21), (44, 21), "n·θ + Φ"),
            ((64, 21), (73, 16), "a·cos φ"),
            ((64, 7), (73, 13), ""),
        ],
    )  # fmt: skip


def _figure_8(axes: Axes) -> None:
    axes.set_ylim(0, 22)
    _boxes(
        axes,
        [
            (0, 12, 14, 7, f"R, u{ANGLE_WIDTH}.0", _OUTSIDE),
            (0, 2, 14, 7, f"K_n = n/turn\nu0.{PHASE_STEP_WIDTH}", _OUTSIDE),
            (24, 7, 20, 8, "multiplier\nthree DSP48E1", _GATEWARE),
            (54, 7, 16, 8, "adder\nrounded once", _GATEWARE),
            (54, 17.5, 16, 4, f"Φ_n, u0.{PHASE_WIDTH}", _OUTSIDE),
            (80, 7, 18, 8, f"phase, u0.{PHASE_WIDTH}\nof a turn", _OUTSIDE),
        ],
        [
            ((14, 15), (24, 12), ""),
            ((14, 6), (24, 9), ""),
            ((44, 11), (54, 11), "mod 1 turn"),
            ((62, 17.5), (62, 15), ""),
            ((70, 11), (80, 11), ""),
        ],
    )


def _figure_9(axes: Axes) -> None:
    axes.set_ylim(0, 22)
    last = CORDIC_ITERATIONS - 1
    _boxes(
        axes,
        [
            (0, 7, 13, 8, "quadrant fold", _GATEWARE),
            (20, 7, 13, 8, "i = 0\nx, y, z", _GATEWARE),
            (40, 7, 13, 8, "i = 1\n± 2⁻¹", _GATEWARE),
            (61, 7, 13, 8, f"i = {last}\n± 2⁻{str(last).translate(_SUPERSCRIPT)}", _GATEWARE),
            (82, 7, 16, 8, f"rounded once\ns1.{COSINE_WIDTH - 2} × a,\n"
             f"s{AMPLITUDE_WIDTH - 1 - AMPLITUDE_FRACTION}.{AMPLITUDE_FRACTION}", _GATEWARE),
        ],
        [
            ((13, 11), (20, 11), ""),
            ((33, 11), (40, 11), ""),
            ((53, 11), (61, 11), "…"),
            ((74, 11), (82, 11), "x"),
        ],
    )  # fmt: skip
    axes.text(
        47,
        3.5,
        f"{CORDIC_ITERATIONS} iterations, one a clock: y_{{i+1}} = y_i + x_i d_i 2⁻ⁱ",
        ha="center",
        fontsize=8,
    )


def _figure_a1(axes: Axes) -> None:
    count = np.arange(1, 25)
    axes.plot(count, [approximation_bound(int(n)) for n in count], "o-", color=AFTER)
    axes.axvline(CORDIC_ITERATIONS, color=LIMIT, linestyle=(0, (4, 3)))
    set_log_y(axes)
    axes.set_xlabel("iterations n; dashed: 16")
    axes.set_ylabel("δ_max, rad")


def _figure_a2(axes: Axes) -> None:
    count = np.arange(4, 25)
    for bits, colour in ((14, MUTED), (16, LIMIT), (18, AFTER), (20, "#3a7d44"), (22, BEFORE)):
        axes.plot(
            count, [rounding_bound(bits, int(n)) for n in count], "o-", markersize=3,
            color=colour, label=f"b = {bits}",
        )  # fmt: skip
    axes.axvline(CORDIC_ITERATIONS, color=LIMIT, linestyle=(0, (4, 3)))
    set_log_y(axes)
    axes.set_xlabel("iterations n; dashed: 16")
    axes.set_ylabel("ε_max, as printed in (A.5)")
    axes.legend(ncols=5, fontsize=8)


DRAWINGS: dict[str, tuple[str, tuple[float, float], Callable[[Axes], None]]] = {
    "1": ("Read heads", (7.0, 4.6), _figure_1),
    "3": ("The system", (9.0, 3.4), _figure_3),
    "4": ("Square waves of a read head; the numbers are A and B", (8.0, 3.6), _figure_4),
    "5": ("Pre-processing of one head", (9.0, 2.2), _figure_5),
    "6": ("Self-calibration", (9.0, 3.0), _figure_6),
    "7": ("Real-time compensation", (9.0, 3.0), _figure_7),
    "8": ("Phase lane", (9.0, 2.4), _figure_8),
    "9": ("CORDIC pipeline of a harmonic lane", (9.0, 2.4), _figure_9),
    "A1": ("Fig. A.1: bound of the approximation error", (7.0, 3.6), _figure_a1),
    "A2": ("Fig. A.2: bound of the rounding error", (7.0, 3.6), _figure_a2),
}
"""Title, size in inches, and drawing function of each figure, by the number of the figure."""


def drawing_name(number: str) -> str:
    """Return the file name of a figure."""
    return f"paper_fig_{number.lower()}.svg"


def draw_figures(folder: Path) -> list[Path]:
    """Write all drawings; make the folder if it does not exist."""
    paths = []
    for number, (title, size, draw) in DRAWINGS.items():
        path = folder / drawing_name(number)
        with house_style():
            figure = Figure(figsize=size, layout="constrained")
            axes = figure.subplots()
            axes.set_title(title)
            draw(axes)
            paths.append(save_picture(figure, path))
    return paths
