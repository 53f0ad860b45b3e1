"""Figures and pages that people read."""

import matplotlib as mpl

# A "$" in a title or a name is text; matplotlib must not parse it as mathematics.
mpl.rcParams["text.parse_math"] = False
