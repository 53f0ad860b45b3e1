"""From a measurement set to what a model is compared with: rows with their conditions.

Pure data: nothing is kept in them that a fit has worked out, and they call nobody.
"""

from arctrue.workbench.observations.observations import Observations
from arctrue.workbench.observations.rows import CaptureRows, ReferenceRows

__all__ = ["CaptureRows", "Observations", "ReferenceRows"]
