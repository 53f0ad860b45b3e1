"""Converts a measurement set into rows with their conditions, for comparison with a model.

Rows contain measured values and conditions, no fitted values. Of the workbench's other packages,
this package imports only ``numeric``.
"""

from arctrue.workbench.observations.observations import Observations
from arctrue.workbench.observations.rows import CaptureRows, ReferenceRows

__all__ = ["CaptureRows", "Observations", "ReferenceRows"]
