"""Provides the virtual instrument: the gateware as a compiled netlist, and the firmware's C code.
GHDL creates a netlist from arctrue_core, and Verilator creates a library from the netlist. A
simulated table supplies the signals of the heads."""

from arctrue.instrument.build import build
from arctrue.instrument.curves import Curves, TableCurves
from arctrue.instrument.errors import BusError, InstrumentError
from arctrue.instrument.firmware import Firmware
from arctrue.instrument.instrument import Instrument, clock_hz_for
from arctrue.instrument.noise import ReadingNoise
from arctrue.instrument.pins import (
    COMPARE_OUT,
    HEAD1_A,
    HEAD1_B,
    HEAD1_Z,
    HEAD2_A,
    HEAD2_B,
    HEAD2_Z,
    HEAD3_A,
    HEAD3_B,
    HEAD3_Z,
    HEAD4_A,
    HEAD4_B,
    HEAD4_Z,
    PROBE_IN,
    SYNC_IN,
    TRIGGER_OUT,
    PinFault,
)
from arctrue.instrument.recording import EdgeTrack, Recording
from arctrue.instrument.run_progress import ReportRun, RunProgress

__all__ = [
    "COMPARE_OUT",
    "HEAD1_A",
    "HEAD1_B",
    "HEAD1_Z",
    "HEAD2_A",
    "HEAD2_B",
    "HEAD2_Z",
    "HEAD3_A",
    "HEAD3_B",
    "HEAD3_Z",
    "HEAD4_A",
    "HEAD4_B",
    "HEAD4_Z",
    "PROBE_IN",
    "SYNC_IN",
    "TRIGGER_OUT",
    "BusError",
    "Curves",
    "EdgeTrack",
    "Firmware",
    "Instrument",
    "InstrumentError",
    "PinFault",
    "ReadingNoise",
    "Recording",
    "ReportRun",
    "RunProgress",
    "TableCurves",
    "build",
    "clock_hz_for",
]
