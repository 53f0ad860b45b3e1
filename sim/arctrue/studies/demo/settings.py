"""Defines the settings of the demo, among them its scale."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass
from pathlib import Path

from arctrue.base.typed_content import read_json
from arctrue.base.units import arcsec_per_count
from arctrue.base.whole_file import write_whole_text
from arctrue.gateware.correction_ramp import ramp_arcsec_s


@dataclass(frozen=True, slots=True)
class DemoSettings:
    """Settings of the demo, which is smaller than full scale (2²⁴ counts a turn, 12,000 samples a
    turn, 32 lanes)."""

    counts_per_rev: int = 1 << 16
    """Counts per turn: the paper's 16,384 lines with 4 counts per line in place of 1024."""
    lanes: int = 4
    capture_depth: int = 3072
    clock_hz: float = 100e6
    clocks_per_count: float = 1.3
    """Mean clocks per edge of a head; not an integer, so that the edges come at varying instants
    within a clock."""
    sample_period_clocks: int = 40
    disc_scale: float = 8.0
    """Ratio of the disc's errors to the errors of the paper's disc."""
    noise_arcsec: float = 0.4
    ripple_rad: float = 0.002
    ripple_order: int = 7
    turns: float = 3.2
    """Length of the simulated motion in turns; the simulation ends as soon as the judged turn is
    complete."""
    ramp_rate: int = 64 << 24
    """Rate of the swap's ramp, u8.24 in 2⁻¹¹ count per clock."""
    output_spacing_clocks: int = 1
    peak_limit_counts: float = 2.0
    order_limit_counts: float = 0.1
    fitted_orders: int = 32
    seed: int = 1

    @property
    def arcsec_per_count(self) -> float:
        """Return the size of a count in seconds of arc."""
        return arcsec_per_count(self.counts_per_rev)

    @property
    def speed_rad_s(self) -> float:
        """Return the speed, in rad/s, at which ``clocks_per_count`` clocks pass per count on
        average."""
        return 2 * 3.141592653589793 / self.counts_per_rev * self.clock_hz / self.clocks_per_count

    def console_commands(self) -> list[str]:
        """Return the commands to type on the firmware's console before the table turns.

        The default alarm limits are for full scale, where a count is far smaller than the limits.
        The demo sets one count for the noise and two counts for the error.
        """
        values = {
            "counts_per_rev": f"{self.counts_per_rev}",
            "sample_period": f"{self.sample_period_clocks}",
            "ramp_arcsec_s": f"{ramp_arcsec_s(self.ramp_rate, self.counts_per_rev):.6f}",
            "ramp_arcsec_s2": "0",
            "output_spacing": f"{self.output_spacing_clocks}",
            "orders": f"{self.fitted_orders}",
            "alarm_noise_arcsec": f"{self.arcsec_per_count:.3f}",
            "alarm_error_arcsec": f"{self.peak_limit_counts * self.arcsec_per_count:.3f}",
        }
        return [*(f"set {name} {value}" for name, value in values.items()), "telemetry on"]

    def write(self, file: Path) -> None:
        """Write the settings as JSON, for the process inside the simulator."""
        write_whole_text(file, json.dumps(asdict(self), indent=1))

    @classmethod
    def read(cls, file: Path) -> DemoSettings:
        """Read the file that :meth:`write` wrote."""
        return read_json(file, cls)
