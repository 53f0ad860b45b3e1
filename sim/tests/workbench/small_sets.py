"""Makes small measurement sets from their definitions, without the package's own models."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from arctrue.measurement import Capture, MeasurementSet, Reference, Table

Float = NDArray[np.float64]
Error = Callable[[Float, Float, float], Float]
"""Error function ε in arcseconds; its arguments are disc angle in rad, temperature in °C and speed
in rad/s."""

COUNTS_PER_REV = 1 << 24
LINES = 16_384
ALPHA = np.radians(33.0)
ARCSEC = np.pi / 648_000.0
SAMPLES_A_TURN = 1200
TURNS = 3
RUNS = ((30.0, 20.0, 20.0, 0.0), (-30.0, 20.0, 20.0, 60.0), (90.0, 20.0, 20.0, 120.0),
        (30.0, 23.5, 24.5, 1800.0))  # fmt: skip
"""Speed in deg/s, temperature at the start and at the end in °C, and start time in s, for each
run."""
CAPTURE_NOISE = 0.1
REFERENCE_NOISE = 0.15


def paper_error(disc: Float, temperature: Float, speed: float) -> Float:
    """Return an error of orders 1, 2, 3 and 5."""
    return (
        90.0 * np.cos(disc + 0.4)
        + 0.8 * np.cos(2 * disc + 1.0)
        + 0.5 * np.cos(3 * disc - 2.0)
        + 0.4 * np.cos(5 * disc + 3.0)
    )


def measurement_set(
    error: Error = paper_error,
    *,
    seed: int = 1,
    runs: int = 4,
    head2_only: Callable[[Float, float], Float] | None = None,
    electrical: Callable[[Float], Float] | None = None,
    reversal_arcsec: float = 0.0,
    cycles: int = 6,
    turns: int = TURNS,
    reference: bool = True,
) -> MeasurementSet:
    """Return a set with a capture of ``runs`` runs, and with a reference run over 24 faces in both
    directions.

    ``head2_only`` is a function of time (s) and speed (rad/s); its value in arcseconds is added to
    head 2. ``electrical`` is a function of the electrical phase (rad); its value in arcseconds is
    added to both heads and to the reference.
    """
    random = np.random.default_rng(seed)
    columns: dict[str, list[Float]] = {name: [] for name in ("run", "time", "h1", "h2", "warm")}
    for run, (speed_deg, cold, warm, start) in enumerate(RUNS[:runs]):
        size = SAMPLES_A_TURN * turns
        start *= turns / TURNS
        step = np.sign(speed_deg) * 2.0 * np.pi / SAMPLES_A_TURN
        angle = random.uniform(0.0, 2.0 * np.pi) + np.arange(size) * step
        time = start + np.arange(size) * abs(step) / np.radians(abs(speed_deg))
        temperature = np.linspace(cold, warm, size)
        speed = float(np.radians(speed_deg))
        readings = []
        for head, offset in ((1, 0.0), (2, ALPHA)):
            value = angle + offset + error(angle + offset, temperature, speed) * ARCSEC
            if head == 2 and head2_only is not None:
                value = value + head2_only(time, speed) * ARCSEC
            if electrical is not None:
                value = value + electrical(LINES * value) * ARCSEC
            value = value + random.normal(0.0, CAPTURE_NOISE * ARCSEC, size)
            readings.append(np.round(value / (2.0 * np.pi) * COUNTS_PER_REV))
        for name, values in zip(
            ("run", "time", "h1", "h2", "warm"),
            (np.full(size, run), time, *readings, temperature),
            strict=True,
        ):
            columns[name].append(values)
    joined = {name: np.concatenate(values) for name, values in columns.items()}
    capture = Capture(
        run=joined["run"].astype(np.int64),
        time_s=joined["time"],
        head1_counts=joined["h1"].astype(np.int64),
        head2_counts=joined["h2"].astype(np.int64),
        temperature_c=joined["warm"],
    )
    table = Table(
        counts_per_rev=COUNTS_PER_REV,
        grating_lines=LINES,
        disc_diameter_mm=107.95,
        head_separation_deg=33.0,
    )
    run = _reference(error, electrical, reversal_arcsec, cycles, random) if reference else None
    return MeasurementSet(table, capture, run, title="small set")


def _reference(
    error: Error,
    electrical: Callable[[Float], Float] | None,
    reversal_arcsec: float,
    cycles: int,
    random: np.random.Generator,
) -> Reference:
    faces = np.arange(24) * 15.0
    target = np.tile(np.concatenate([faces, faces[::-1]]), cycles)
    direction = np.tile(np.repeat([1, -1], 24), cycles)
    angle = np.radians(target)
    value = error(angle, np.full(angle.size, 20.0), 0.0) + 0.5 * reversal_arcsec * direction
    if electrical is not None:
        value = value + electrical(LINES * (angle + value * ARCSEC))
    counts = np.round((angle + value * ARCSEC) / (2.0 * np.pi) * COUNTS_PER_REV)
    return Reference(
        target_deg=target,
        error_arcsec=value + random.normal(0.0, REFERENCE_NOISE, angle.size),
        run=np.zeros(angle.size, dtype=np.int64),
        time_s=np.arange(angle.size) * 4.0,
        cycle=np.repeat(np.arange(cycles), 48),
        direction=direction,
        head1_counts=counts.astype(np.int64),
        temperature_c=np.full(angle.size, 20.0),
        faces=24,
    )
