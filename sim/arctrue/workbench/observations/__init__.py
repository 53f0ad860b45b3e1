"""Converts a measurement set into rows with their conditions, for comparison with a model.

The rows are pure data: they hold no result of a fit and call no other package.
"""

from arctrue.workbench.observations.observations import Observations
from arctrue.workbench.observations.rows import CaptureRows, ReferenceRows

__all__ = ["CaptureRows", "Observations", "ReferenceRows"]
