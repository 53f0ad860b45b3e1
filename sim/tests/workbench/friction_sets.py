"""Simulates sets of a table with dry friction: Dahl's model is followed along the way of the
table."""

from __future__ import annotations

from typing import Literal

import numpy as np

from arctrue.measurement import MeasurementSet, Reference, Table

Form = Literal["linear", "exponential"]
HALF_ARCSEC = 38.0


def friction_set(
    seed: int,
    *,
    stations: int,
    cycles: int,
    width_deg: float,
    form: Form = "linear",
    half_arcsec: float = HALF_ARCSEC,
    noise: float = 0.5,
    beyond_deg: float = 0.0,
    start: float = 1.0,
) -> MeasurementSet:
    """Return a set up and down over the whole turn, read at the stations of both ways.

    The error ± ``half_arcsec`` follows dx/dR = 2/width·(1 − d·x)^i from ``start``, with i = 0
    (Prandtl's stop operator) or 1; with a width of 0 it follows the direction of the motion. The
    table goes ``beyond_deg`` beyond the last station before it reverses.
    """
    random = np.random.default_rng(seed)
    up = np.arange(stations) * 360.0 / stations
    target, direction, state = [], [], []
    place, here = start, 0.0
    for leg in range(2 * cycles):
        way = 1.0 - 2.0 * (leg % 2)
        ends = up if way > 0.0 else up[::-1]
        for station in (*ends, float(ends[-1]) + way * beyond_deg):
            moved = station - here
            if moved != 0.0 and width_deg == 0.0:
                place = np.sign(moved)
            elif form == "linear" and width_deg > 0.0:
                place = np.clip(place + 2.0 * moved / width_deg, -1.0, 1.0)
            elif width_deg > 0.0:
                end = np.sign(moved)
                place = end - (end - place) * np.exp(-2.0 * abs(moved) / width_deg)
            here = station
            target.append(station)
            direction.append(way)
            state.append(place)
    # The last entry of each way is the turning point, which is no station.
    read = np.arange(len(target)) % (stations + 1) < stations
    at = np.array(target)[read]
    angle = np.radians(at)
    error = 40.0 * np.cos(angle + 0.4) + 8.0 * np.cos(2.0 * angle - 1.0)
    error = error + half_arcsec * np.array(state)[read]
    return MeasurementSet(
        Table(counts_per_rev=1 << 20),
        None,
        Reference(
            at,
            error + random.normal(0.0, noise, at.size),
            run=np.zeros(at.size, dtype=np.int64),
            time_s=np.arange(at.size) * 5.0,
            cycle=np.arange(at.size) // (2 * stations),
            direction=np.array(direction)[read].astype(np.int64),
        ),
        title="friction",
    )
