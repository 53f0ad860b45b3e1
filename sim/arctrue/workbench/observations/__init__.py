"""From a measurement set to what a model is compared with: rows with their conditions."""

from arctrue.workbench.observations.observations import Observations
from arctrue.workbench.observations.rows import CaptureRows, ReferenceRows

__all__ = ["CaptureRows", "Observations", "ReferenceRows"]
