"""Figures of the page, of ``arctrue report`` and of the demo's pages, one figure per file.

Each file converts results to a :class:`Chart`, which describes axes with units, and the layers
drawn on them, as data. ``matplotlib_chart`` makes SVG and PNG from it, ``plotly_chart`` an
interactive figure.
"""
