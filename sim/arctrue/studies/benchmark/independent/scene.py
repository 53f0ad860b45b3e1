"""Simulates one experiment with its hidden causes and makes the measurement set and the truth."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from arctrue.measurement import Capture, MeasurementSet, Reference, Table
from arctrue.studies.benchmark.independent.causes.cause import ARCSEC, Cause
from arctrue.studies.benchmark.independent.conditions import Conditions, Stations, Sweep
from arctrue.studies.benchmark.independent.geometry import (
    Disc,
    servo_error_rad,
    swept_reading_rad,
)
from arctrue.studies.benchmark.independent.noise import NoiseProcess, StateNoise
from arctrue.studies.benchmark.independent.sight import Channel, Sight, look, look_at_oscillators

Float = NDArray[np.floating[Any]]
Random = np.random.Generator

ROOM_C = 20.0
SENSOR_NOISE_K = 0.005


@dataclass(frozen=True)
class Accepted:
    """Answers that are accepted in addition to the names of the hidden causes in the catalogue."""

    names: tuple[str, ...] = ()
    """Other names of a hidden cause; an answer that names one of them first is right."""
    alike: tuple[str, ...] = ()
    """Names that describe only a part of the hidden cause; they count as neither right nor
    false."""
    verdicts: tuple[str, ...] = ()
    """Verdicts that are right for this design, independent of the oracle's result."""


@dataclass
class Scene:
    """Description of one experiment: its design, its instruments, its noise, and the hidden
    causes."""

    disc: Disc
    causes: Sequence[Cause] = ()
    runs: Sequence[Sweep] = ()
    """Runs of the capture; empty: no capture."""
    stations: Stations | None = None
    """Stations of a reference at standstill."""
    passes: Sequence[Sweep] = ()
    """Passes of a moving reference, in place of stations."""
    head_noise: NoiseProcess = field(default_factory=lambda: StateNoise(0.1))
    """Noise of each head."""
    reference_noise: NoiseProcess = field(default_factory=lambda: StateNoise(0.15))
    index_counts: int = 0
    """Largest random shift of a head's index mark in a run, in whole counts."""
    display_arcsec: float = 0.0
    """Resolution of the reference's display; 0: continuous."""
    table: dict[str, Any] = field(default_factory=dict)
    """Further keys of the table's description."""
    reference: dict[str, Any] = field(default_factory=dict)
    """Instrument, faces, and standard uncertainty of the reference."""
    temperature: bool = True
    columns: tuple[str, ...] = ("run", "time_s", "cycle", "direction")
    """Optional columns of the reference file."""
    lost: float = 0.0
    """Share of the rows that are missing; they are chosen at random."""
    accepted: Accepted = Accepted()
    adverse_conditions: tuple[str, ...] = ()
    """Names of the properties that make this set difficult, for example a display with a coarse
    step.
    """

    def channels(self, causes: Sequence[Cause]) -> dict[str, Float]:
        """Return the signal of each channel without noise and rounding, arcseconds."""
        found: dict[str, Float] = {}
        if self.runs:
            first, second = (self._heads_rad(head, causes) for head in (1, 2))
            found["capture"] = (second - first) / ARCSEC
        if self.stations is not None or self.passes:
            found["reference"] = self._reference_rad(causes) / ARCSEC
        return found

    def _heads_rad(self, head: int, causes: Sequence[Cause]) -> Float:
        return np.concatenate(
            [swept_reading_rad(self.disc, run, head, causes) for run in self.runs]
        )

    def _reference_rad(self, causes: Sequence[Cause]) -> Float:
        """Return the error of indication: reading of head 1 minus the reference angle."""
        at = self.reference_at()
        if self.stations is not None:
            error = servo_error_rad(self.disc, at, causes)
        else:
            reading = [swept_reading_rad(self.disc, run, 1, causes) for run in self.passes]
            error = np.concatenate(reading) - at.turned_rad
        found: Float = error + sum(
            (cause.reference_rad(at, error) for cause in causes), np.zeros(at.rows)
        )
        return found

    def reference_at(self) -> Conditions:
        """Return the conditions of the reference rows; at a station ``turned_rad`` is head 1's
        reading.
        """
        return self.stations.at if self.stations is not None else _joined(self.passes)


def made(scene: Scene, random: Random) -> tuple[MeasurementSet, dict[str, Any]]:
    """Make the measurement set of a scene and its truth: causes with oracle results, accepted
    answers, noise floor."""
    shown = scene.channels(scene.causes)
    alone = [_alone(scene, number, shown) for number in range(len(scene.causes))]
    channels: list[Channel] = []
    capture = reference = None
    index_arcsec = 0.0
    if scene.runs:
        capture, kept, angle_rad = _capture(scene, random)
        at = _joined(scene.runs)
        step = scene.disc.arcsec_per_count
        index_arcsec = step * float(np.sqrt(2 * scene.index_counts * (scene.index_counts + 1) / 3))
        noise = scene.head_noise.scaled(float(np.sqrt(2))).with_white(step / np.sqrt(6))
        channels.append(
            Channel(
                "capture", angle_rad, at.time_s[kept], noise, at.run[kept], kept,
                scene.disc.separation_rad,
            )
        )  # fmt: skip
    if scene.stations is not None or scene.passes:
        reference, kept = _reference(scene, shown["reference"], random)
        at = scene.reference_at()
        noise = scene.reference_noise.with_white(scene.display_arcsec / np.sqrt(12))
        channels.append(
            Channel("reference", at.turned_rad[kept], at.time_s[kept], noise, None, kept)
        )
    sights = look(channels, alone, scene.causes, index_arcsec)
    stated = {
        "counts_per_rev": scene.disc.counts_per_rev,
        "head_separation_deg": float(np.degrees(scene.disc.separation_rad)),
        "grating_lines": scene.disc.lines,
        "disc_diameter_mm": 2000 * scene.disc.radius_m,
    }
    if capture is None:
        # If the set has only a reference, only the keys in ``scene.table`` describe the disc.
        stated = {}
    table = Table(**{**stated, **scene.table})
    measurement = MeasurementSet(table, capture, reference, title="benchmark")
    return measurement, _truth(scene, sights, channels)


def _alone(scene: Scene, number: int, shown: dict[str, Float]) -> dict[str, Float]:
    """Return the signal with all causes minus the signal without cause ``number``, by channel."""
    others = [cause for place, cause in enumerate(scene.causes) if place != number]
    without = scene.channels(others)
    return {channel: whole - without[channel] for channel, whole in shown.items()}


def _capture(scene: Scene, random: Random) -> tuple[Capture, NDArray[np.int64], Float]:
    at = _joined(scene.runs)
    step_rad = 2 * np.pi / scene.disc.counts_per_rev
    counts = []
    for head in (1, 2):
        noise = scene.head_noise.draw(random, at.time_s) * ARCSEC
        moved = random.integers(-scene.index_counts, scene.index_counts + 1, len(scene.runs))
        reading = scene._heads_rad(head, scene.causes) + noise
        counts.append(np.round(reading / step_rad).astype(np.int64) + moved[at.run])
    kept = _kept(scene, at.rows, random)
    sensor = ROOM_C + at.warming_k + SENSOR_NOISE_K * random.standard_normal(at.rows)
    capture = Capture(
        run=at.run[kept],
        time_s=at.time_s[kept].astype(np.float64),
        head1_counts=counts[0][kept],
        head2_counts=counts[1][kept],
        temperature_c=sensor[kept] if scene.temperature else None,
        clock_hz=1e8,
    )
    return capture, kept, counts[0][kept] * step_rad


def _reference(
    scene: Scene, error_arcsec: Float, random: Random
) -> tuple[Reference, NDArray[np.int64]]:
    at = scene.reference_at()
    shown = error_arcsec + scene.reference_noise.draw(random, at.time_s)
    if scene.display_arcsec:
        shown = scene.display_arcsec * np.round(shown / scene.display_arcsec)
    kept = _kept(scene, at.rows, random)
    sensor = ROOM_C + at.warming_k + SENSOR_NOISE_K * random.standard_normal(at.rows)
    cycle = scene.stations.cycle if scene.stations is not None else np.zeros(at.rows, np.int64)
    optional: dict[str, NDArray[Any]] = {
        "run": at.run,
        "time_s": at.time_s,
        "cycle": cycle,
        "direction": at.direction.astype(np.int64),
        "head1_counts": np.round(at.turned_rad * scene.disc.counts_per_rev / (2 * np.pi)).astype(
            np.int64
        ),
    }
    chosen: dict[str, Any] = {
        name: values[kept] for name, values in optional.items() if name in scene.columns
    }
    if scene.temperature:
        chosen["temperature_c"] = sensor[kept]
    # The target angles of stations are reduced to one turn; those of a moving table continue over
    # turns.
    target = np.degrees(at.turned_rad)
    if scene.stations is not None:
        target = np.round(np.mod(np.round(target, 9), 360.0), 9)
    reference = Reference(
        target_deg=target[kept], error_arcsec=shown[kept], **chosen, **scene.reference
    )
    return reference, kept


def _kept(scene: Scene, rows: int, random: Random) -> NDArray[np.int64]:
    """Return the indices of the rows that are not lost; the first and the last row are never
    lost."""
    lost = random.random(rows) < scene.lost
    lost[[0, -1]] = False
    return np.flatnonzero(~lost)


def _joined(sweeps: Sequence[Sweep]) -> Conditions:
    parts = [sweep.conditions(sweep.time_s) for sweep in sweeps]
    names = Conditions.__dataclass_fields__
    return Conditions(
        **{name: np.concatenate([getattr(part, name) for part in parts]) for name in names}
    )


def _truth(scene: Scene, sights: Sequence[Sight], channels: Sequence[Channel]) -> dict[str, Any]:
    effects: list[dict[str, Any]] = [
        {
            "effect": cause.name,
            "kind": "catalogue" if cause.known else "stranger",
            "parts": [],
            "size": _seven(cause.size),
            "unit": cause.unit,
            "values": {key: [_seven(item) for item in of] for key, of in cause.values().items()},
            "noncentrality": _seven(sight.noncentrality),
            "needed": _seven(sight.needed),
            "rms_arcsec": _seven(sight.rms_arcsec),
        }
        for cause, sight in zip(scene.causes, sights, strict=True)
    ]
    effects += [item for channel in channels for item in _oscillations(channel)]
    effects.sort(key=lambda item: -float(item["rms_arcsec"]))
    return {
        "effects": effects,
        "noise": [],
        "adverse_conditions": list(scene.adverse_conditions),
        "accepted": {
            "names": list(scene.accepted.names),
            "alike": list(scene.accepted.alike),
            "verdicts": list(scene.accepted.verdicts),
        },
        "resolution": _resolution(channels),
        "floor_arcsec": {
            channel.name: _seven(channel.noise.rms_arcsec(channel.time_s)) for channel in channels
        },
    }


def _oscillations(channel: Channel) -> list[dict[str, Any]]:
    """Describe the damped oscillators in a channel's noise as causes; the catalogue does not
    contain them."""
    seen = look_at_oscillators(channel)
    if seen is None:
        return []
    return [
        {
            "effect": "driven_oscillation",
            "kind": "oscillation",
            "parts": [],
            "size": _seven(item.sigma_arcsec),
            "unit": "arcsec",
            "oscillation": {"hz": _seven(item.hz), "half_width_hz": _seven(item.half_width_hz)},
            "noncentrality": _seven(seen.noncentrality),
            "needed": _seven(seen.needed),
            "rms_arcsec": _seven(item.sigma_arcsec),
        }
        for item in channel.noise.oscillators
    ]


def _resolution(channels: Sequence[Channel]) -> dict[str, float]:
    """Return the smallest distance at which two lines can be resolved, in order and in frequency.

    The distance is the reciprocal of the length of the longest run or log, in turns and in seconds.
    """
    turned, lasted = 0.0, 0.0
    for channel in channels:
        runs = np.zeros(channel.time_s.size, np.int64) if channel.run is None else channel.run
        for run in np.unique(runs):
            rows = runs == run
            turned = max(turned, float(np.ptp(channel.angle_rad[rows])) / (2 * np.pi))
            lasted = max(lasted, float(np.ptp(channel.time_s[rows])))
    return {"order": _seven(1 / turned), "hz": _seven(1 / lasted)}


def _seven(value: float) -> float:
    return float(f"{value:.7g}")
