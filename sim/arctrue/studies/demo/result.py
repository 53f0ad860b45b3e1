"""Defines the results of the demo, which the page and the terminal show."""

from __future__ import annotations

from dataclasses import dataclass

from arctrue.instrument.turn_score import TurnScore
from arctrue.studies.demo.files import ConsoleLine
from arctrue.studies.demo.settings import DemoSettings
from arctrue.studies.demo.telemetry import ReportedTurn


@dataclass(frozen=True, slots=True)
class UnitLatency:
    """Latency of one unit of the gateware: the measured latency of the VHDL, and the latency in
    Table 1 of the paper."""

    unit: str
    measured_clocks: int
    paper_clocks: int


@dataclass(frozen=True, slots=True)
class LoadedHarmonic:
    """Coefficients that the firmware wrote for one lane, and the amplitudes of the lane's order in
    the error before and after the correction."""

    order: int
    amplitude_counts: float
    phase_deg: float
    standard_uncertainty_counts: float
    before_counts: float
    after_counts: float


@dataclass(frozen=True, slots=True)
class DemoResult:
    """Result of one run of the demo: errors, latencies, loaded orders, telemetry, exceeded
    limits."""

    settings: DemoSettings
    before: TurnScore
    after: TurnScore
    faults: tuple[str, ...]
    latencies: tuple[UnitLatency, ...]
    pin_to_pin_clocks: int
    index_offset_counts: float
    """Distance, in counts, of the output's Z from the zero of the corrected angle."""
    harmonics: tuple[LoadedHarmonic, ...]
    turns: tuple[ReportedTurn, ...]
    """Telemetry of the firmware for each turn; the loaded coefficients come from the first turn."""
    console: tuple[ConsoleLine, ...]
    words_moved: int
    """Number of words that the firmware read and wrote over AXI4-Lite."""
    edges_played: int
    clocks_simulated: int
    simulation_s: float
    total_s: float
    simulator: str

    @property
    def passed(self) -> bool:
        """Tell whether the output keeps all limits."""
        return not self.faults
