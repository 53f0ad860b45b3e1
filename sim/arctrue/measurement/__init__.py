"""Defines the measurement set, the folder in which programs exchange captures and reference
runs."""

from arctrue.measurement.errors import MeasurementError
from arctrue.measurement.join import JoinError, OverlapError, joined
from arctrue.measurement.measurement_set import (
    Capture,
    MeasurementSet,
    Origin,
    Reference,
    Table,
)
from arctrue.measurement.reader import open_capture, read_measurement_set
from arctrue.measurement.writer import write_measurement_set

__all__ = [
    "Capture",
    "JoinError",
    "MeasurementError",
    "MeasurementSet",
    "Origin",
    "OverlapError",
    "Reference",
    "Table",
    "joined",
    "open_capture",
    "read_measurement_set",
    "write_measurement_set",
]
