"""Draws docs/images/data_way.svg: the path of the data through the units, with folders and
latencies."""

from __future__ import annotations

from dataclasses import dataclass
from html import escape

WIDTH = 1180
HEIGHT = 520

INK = "#1c2530"
MUTED = "#5b6675"
FILL = {"outside": "#f1f3f5", "gateware": "#e4eff7", "software": "#fbeedd"}
EDGE = {"outside": "#9aa5b1", "gateware": "#1f6f9f", "software": "#b86e14"}


@dataclass(frozen=True)
class Box:
    """Box that stands for one unit of the path: position and size in pixels, name, folder, and one
    line of text."""

    x: int
    y: int
    width: int
    kind: str
    name: str
    folder: str
    remark: str
    height: int = 84


BOXES = (
    Box(20, 90, 130, "outside", "Read head 1", "sim/arctrue/table", "A, B, Z: reference"),
    Box(20, 290, 130, "outside", "Read head 2", "sim/arctrue/table", "A, B, Z: calibration"),
    Box(200, 90, 150, "gateware", "Decoder 1", "rtl/decoder", "angle and position R₁"),
    Box(200, 290, 150, "gateware", "Decoder 2", "rtl/decoder", "position R₂"),
    Box(410, 135, 150, "gateware", "Phase unit", "rtl/phase", "n·θ + Φ: 5 clocks"),
    Box(600, 135, 150, "gateware", "Harmonic unit", "rtl/harmonic", "a·cos φ: 20 clocks"),
    Box(
        410,
        45,
        340,
        "gateware",
        "Delay line",
        "rtl/compensation",
        "R waits for ε(R): 25 clocks",
        64,
    ),
    Box(800, 90, 160, "gateware", "Error compensation", "rtl/compensation", "R − ε(R): 4 clocks"),
    Box(
        1010,
        90,
        150,
        "gateware",
        "Quadrature output",
        "rtl/quadrature_output",
        "A, B, Z to the servo",
    ),
    Box(410, 290, 150, "gateware", "Sampler", "rtl/sampler", "both heads, full turns"),
    Box(600, 290, 150, "gateware", "Coefficient memory", "rtl/coefficients", "two banks, one swap"),
    Box(410, 415, 340, "gateware", "Registers", "rtl/registers", "AXI4-Lite, interrupt", 64),
    Box(800, 405, 160, "software", "Firmware", "firmware", "ε from R₂ − R₁, check, swap"),
)

# Each arrow has its points in pixels, the text on it, and the place of the text.
ARROWS: tuple[tuple[tuple[tuple[int, int], ...], str, tuple[int, int]], ...] = (
    (((150, 132), (200, 132)), "", (0, 0)),
    (((150, 332), (200, 332)), "", (0, 0)),
    (((350, 115), (380, 115), (380, 77), (410, 77)), "R₁", (366, 90)),
    (((350, 150), (380, 150), (380, 177), (410, 177)), "angle", (362, 195)),
    (((560, 177), (600, 177)), "", (0, 0)),
    (((750, 177), (775, 177), (775, 150), (800, 150)), "", (0, 0)),
    (((750, 77), (775, 77), (775, 115), (800, 115)), "", (0, 0)),
    (((960, 132), (1010, 132)), "", (0, 0)),
    (((275, 174), (275, 240), (450, 240), (450, 290)), "R₁", (360, 233)),
    (((350, 332), (410, 332)), "R₂", (380, 324)),
    (((485, 374), (485, 415)), "captured turn", (535, 400)),
    (((675, 415), (675, 374)), "coefficients", (718, 400)),
    (((750, 432), (800, 432)), "", (0, 0)),
    (((800, 462), (750, 462)), "", (0, 0)),
    (((640, 290), (640, 255), (520, 255), (520, 219)), "K, Φ", (580, 248)),
    (((675, 290), (675, 219)), "amplitudes", (714, 258)),
    (((750, 332), (880, 332), (880, 174)), "offset", (905, 258)),
)


def _box(box: Box) -> list[str]:
    middle = box.x + box.width // 2
    top = box.y + box.height // 2
    return [
        f'<rect x="{box.x}" y="{box.y}" width="{box.width}" height="{box.height}" rx="7" '
        f'fill="{FILL[box.kind]}" stroke="{EDGE[box.kind]}" stroke-width="1.5"/>',
        f'<text x="{middle}" y="{top - 13}" class="name">{escape(box.name)}</text>',
        f'<text x="{middle}" y="{top + 5}" class="remark">{escape(box.remark)}</text>',
        f'<text x="{middle}" y="{top + 23}" class="folder">{escape(box.folder)}</text>',
    ]


def _arrow(way: tuple[tuple[int, int], ...], words: str, place: tuple[int, int]) -> list[str]:
    points = " ".join(f"{x},{y}" for x, y in way)
    lines = [f'<polyline points="{points}" class="way" marker-end="url(#tip)"/>']
    if words:
        lines.append(f'<text x="{place[0]}" y="{place[1]}" class="words">{escape(words)}</text>')
    return lines


def draw() -> str:
    """Return the picture as SVG text."""
    lines = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {HEIGHT}" role="img">',
        "<title>Path of the data through ArcTrue</title>",
        "<!-- Made by scripts/data_way.py. Do not edit. -->",
        "<style>",
        "text { font-family: 'Segoe UI', 'Helvetica Neue', Arial, 'DejaVu Sans', sans-serif; "
        f"text-anchor: middle; fill: {INK}; }}",
        ".name { font-size: 15px; font-weight: 600; } .remark { font-size: 12px; }",
        f".folder, .words {{ font-size: 11px; fill: {MUTED}; }}",
        ".folder { font-family: monospace; }",
        f".way {{ fill: none; stroke: {MUTED}; stroke-width: 1.6; }}",
        ".title { font-size: 13px; font-weight: 600; text-anchor: start; }",
        "</style>",
        '<defs><marker id="tip" viewBox="0 0 10 10" refX="9" refY="5" markerWidth="7" '
        f'markerHeight="7" orient="auto">'
        f'<path d="M0,0 L10,5 L0,10 z" fill="{MUTED}"/></marker></defs>',
        f'<rect width="{WIDTH}" height="{HEIGHT}" fill="#ffffff"/>',
        '<rect x="180" y="10" width="990" height="500" rx="10" fill="none" stroke="#cfd6dd" '
        'stroke-dasharray="5 4"/>',
        '<text x="192" y="28" class="title">one chip: fabric (rtl/core) and processor</text>',
    ]
    for box in BOXES:
        lines += _box(box)
    for arrow in ARROWS:
        lines += _arrow(*arrow)
    legend = (("outside", "table"), ("gateware", "gateware"), ("software", "processor"))
    for row, (kind, words) in enumerate(legend):
        y = 420 + 24 * row
        lines.append(
            f'<rect x="28" y="{y}" width="18" height="14" rx="3" fill="{FILL[kind]}" '
            f'stroke="{EDGE[kind]}"/>'
        )
        lines.append(
            f'<text x="56" y="{y + 12}" class="remark" style="text-anchor:start">{words}</text>'
        )
    lines.append("</svg>")
    return "\n".join(lines) + "\n"
