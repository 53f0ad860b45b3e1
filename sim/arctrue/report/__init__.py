"""Figures and pages that people read."""

from arctrue.base.extras import installed

if installed("matplotlib"):
    import matplotlib as mpl

    # A title or a name may hold "$": it is text, no mathematics, and must not stop a figure.
    mpl.rcParams["text.parse_math"] = False
