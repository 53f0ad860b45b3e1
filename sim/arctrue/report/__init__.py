"""Makes figures and pages for human readers."""

from arctrue.base.extras import installed

if installed("matplotlib"):
    import matplotlib as mpl

    # A "$" in a title or a name is plain text, so matplotlib must not parse it as mathematics.
    mpl.rcParams["text.parse_math"] = False
