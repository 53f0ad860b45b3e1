"""Figures of the page, of ``arctrue report`` and of the demo's pages, one figure a file.

A file turns results into a :class:`Chart`: axes with units and what is drawn on them, as data.
``matplotlib_chart`` makes SVG and PNG from it, ``plotly_chart`` an interactive figure.
"""
