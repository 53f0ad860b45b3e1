"""Makes the figures of the page, of ``arctrue report`` and of the pages of demo and studies; each
module makes the figures of one kind.

Each module converts results to a :class:`Chart`, which describes axes with units and the layers
drawn on them as data. ``matplotlib_chart`` converts a chart to SVG and PNG, ``plotly_chart`` to an
interactive figure. The modules of the studies' pages draw an SVG or PNG directly.
"""
