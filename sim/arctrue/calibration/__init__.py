"""Calibrates a table: computes the error of head 1 from the difference of the readings of two
heads, or the error of the mean of three or four heads."""

from arctrue.calibration.calibration import Calibration, CalibrationSettings, calibrate
from arctrue.calibration.capture_check import CaptureRefusedError, WholeTurns, whole_turns
from arctrue.calibration.estimate import Estimate
from arctrue.calibration.fourier import fourier
from arctrue.calibration.least_squares import least_squares

__all__ = [
    "Calibration",
    "CalibrationSettings",
    "CaptureRefusedError",
    "Estimate",
    "WholeTurns",
    "calibrate",
    "fourier",
    "least_squares",
    "whole_turns",
]
