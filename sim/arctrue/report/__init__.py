"""Figures and pages that people read."""

from arctrue.base.extras import installed

if installed("matplotlib"):
    import matplotlib as mpl

    # A "$" in a title or a name is text; matplotlib must not parse it as mathematics.
    mpl.rcParams["text.parse_math"] = False
