"""Tests that the local table removes a scratch at the paper's 2²⁴ counts per turn, at every head of
a weighted mean, from a moving table's pins to the output.

The heads are only 8° apart, so that the run is short; each of the table's two windows, 11.25° wide,
covers the scratch at two heads.
"""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray
from sim.tests.instrument.sizes import DEPTH, LANES

from arctrue.gateware.coefficients import Coefficients
from arctrue.gateware.local_table import LocalTable
from arctrue.gateware.mean_set import MeanSet
from arctrue.generated.number_formats import HEADS_MAX
from arctrue.generated.registers import MEAN_ADDRESS
from arctrue.instrument import Instrument
from arctrue.workbench.effects.base import LocalError
from arctrue.workbench.model.local_errors import at_heads_of_mean, table_of

Float = NDArray[np.float64]

COUNTS = 1 << 24
DEGREE = COUNTS / 360.0
KNOT = 8
PACE = 0.8
"""Speed in counts per clock."""
PLACES_DEG = (0.0, 8.0, 16.0, 24.0)
WEIGHT_WORDS = (20316, 14418, 19661, 11141)
"""Weights of the heads in 2⁻¹⁶, between 0.17 and 0.31."""
SCRATCH_DEG = 32.0
HEIGHT_ARCSEC, WIDTH_DEG = 20.0, 0.2
"""Height of the scratch, and its width at half height."""
HEIGHT_COUNTS = HEIGHT_ARCSEC / 1_296_000 * COUNTS
SIGMA_DEG = WIDTH_DEG / 2.3548
"""Standard deviation of a bell of that width, which is 2·√(2·ln 2) of them."""
FIRST_DEG, LAST_DEG = -25.0, 33.0
"""The table turns from before the index of head 4, at −24°, until head 1 has passed the scratch."""


def scratch_counts(reading_deg: Float) -> Float:
    return HEIGHT_COUNTS * np.exp(-0.5 * ((reading_deg - SCRATCH_DEG) / SIGMA_DEG) ** 2)


class FourHeads:
    """A disc with the scratch, which turns at a constant speed under four heads."""

    counts_per_rev = COUNTS
    index_width_counts = 1
    rounding_counts = 0.0
    clocks = round((LAST_DEG - FIRST_DEG) * DEGREE / PACE)

    def piece(self, first_clock: int, clocks: int) -> tuple[int, *tuple[Float, ...]]:  # type: ignore[override]
        """Return a piece of the curve in the form of :class:`Curves`."""
        intervals = max(1, min(clocks, self.clocks - first_clock) // KNOT)
        clock = first_clock + KNOT * np.arange(-1.0, intervals + 2)
        place_deg = FIRST_DEG + np.clip(clock, 0.0, float(self.clocks)) * PACE / DEGREE
        readings = []
        for head_deg in PLACES_DEG:
            true = (place_deg + head_deg) * DEGREE
            reading = true
            # The error is a function of the reading with a slope of at most 0.04, so that each
            # iteration divides the deviation by 25.
            for _ in range(8):
                reading = true + scratch_counts(reading / DEGREE)
            readings.append(reading)
        return KNOT, *readings, np.radians(place_deg)


def error_counts(instrument: Instrument, mean: MeanSet, table: LocalTable | None) -> Float:
    """Return place in degrees and error of the output in counts at every edge, (2, edges)."""
    instrument.attach_curves(FourHeads())  # type: ignore[arg-type]
    instrument.reset()
    instrument.write("counts_per_rev", COUNTS)
    instrument.command("rearm")
    for name, value in (
        ("ramp_rate", 0xFFFF_FFFF),
        ("ramp_acceleration", 0),
        ("output_spacing", 1),
    ):
        instrument.write(name, value)
    for number, word in enumerate(mean.words()):
        instrument.write_words(MEAN_ADDRESS + 4 * number, [word])
    instrument.write_coefficients(Coefficients.from_harmonics([], [], [], COUNTS, LANES))
    if table is not None:
        instrument.write_local_table(table)
    instrument.command("swap")
    instrument.update("control", compensate=1, output_enable=1)
    # Head 1, whose index is the zero of the output, sees its index last.
    instrument.run_until(true_angle_rad=np.radians(2.0))
    instrument.record(every=1)
    instrument.run_until(end_of_stimulus=True)
    seen = instrument.recording().output
    instrument.detach()
    error = seen.position - seen.true_angle_rad / (2.0 * np.pi) * COUNTS
    return np.stack([np.degrees(seen.true_angle_rad), error])


@pytest.mark.large
def test_a_scratch_is_taken_away_at_every_head_of_the_mean() -> None:
    """The table leaves at most a tenth of the scratch at each head; without the table, the output
    has the head's share of the scratch."""
    offsets = tuple(round(16 * place * DEGREE) for place in PLACES_DEG)
    mean = MeanSet(WEIGHT_WORDS, offsets)
    assert len(mean.words()) == 2 * HEADS_MAX + 1

    def of_disc(reading_rad: Float) -> Float:
        return scratch_counts(np.degrees(reading_rad)) * HEIGHT_ARCSEC / HEIGHT_COUNTS

    scratch = LocalError(np.radians(SCRATCH_DEG), np.radians(5.0 * SIGMA_DEG), of_disc)
    points = table_of(at_heads_of_mean([scratch], mean, COUNTS), COUNTS)
    assert (len(points.starts_counts), points.width_exponent) == (2, 5)
    table = LocalTable.of_file(points, COUNTS)
    with Instrument(LANES, DEPTH, generics={"HEADS": 4, "LOCAL_TABLE": "true"}) as instrument:
        # A reset keeps an active table, so the run without it is the first after power-up.
        without = error_counts(instrument, mean, None)
        corrected = error_counts(instrument, mean, table)
    for weight, head_deg in zip(WEIGHT_WORDS, PLACES_DEG, strict=True):
        share = HEIGHT_COUNTS * weight / 65536
        for (place_deg, error), most, least in (
            (corrected, 0.1 * share, 0.0),
            # The roundings of readings and output add at most two counts.
            (without, share + 2.0, share - 2.0),
        ):
            away = np.abs(place_deg + head_deg - SCRATCH_DEG)
            # Far from the scratch the output has only its constant offset.
            far = (away > 1.0) & (away < 2.0)
            near = away < 0.6
            assert near.sum() > 1.1 * DEGREE
            size = np.abs(error[near] - error[far].mean()).max()
            assert least <= size <= most, (head_deg, size, share)
