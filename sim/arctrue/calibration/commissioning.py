"""Judges how the heads of a table are connected, before any calibration.

The table turns once or more in its positive direction, and the readings of all heads are taken at
the same clocks. They show the sense of each head, its place (angle from head 1), and the cable to
which it is connected. Two turns at one speed, forward and backward, show the delay between the
electronics of two heads. A head with the delay τ reads θ(t − τ), so its offset changes by τ times
the difference of the two speeds.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import permutations

import numpy as np
from numpy.typing import NDArray

from arctrue.base.units import RAD_PER_ARCSEC
from arctrue.calibration.heads_on_device import OnDevice
from arctrue.gateware.mean_set import DELAY_MOST_CLOCKS

Float = NDArray[np.float64]
Integer = NDArray[np.int64]

COUNTED_WRONG = 0.01
"""Largest permitted difference between the travel of a head and the largest travel of all heads, as
a share of this largest travel. Eccentricity changes the travel by less than 10⁻³.
"""
PLACE_TOLERANCE_DEG = 1.0
"""Largest distance from a planned place at which a head counts as the planned head, degrees. The
device accepts 0.25°.
"""


@dataclass(frozen=True)
class Connection:
    """Reports how the heads are connected; lists have one entry per cable, that of head 1 first.

    ``travels``: counts that each head moved; ``places_deg``: angle from head 1 to each head, NaN if
    this head or head 1 has not detected its index; ``at_head``: number of the planned head to which
    each cable is connected, 0 if no plan fits.
    """

    travels: tuple[int, ...]
    indexed: tuple[bool, ...]
    places_deg: tuple[float, ...]
    at_head: tuple[int, ...]
    off_deg: float
    """Largest distance of a place from the plan, with the cables assigned as found."""
    faults: tuple[str, ...]
    """Faults, each with its remedy; empty if the heads are as planned."""


def judge_connection(
    positions: Integer,
    angles: Integer,
    indexed: NDArray[np.bool_],
    counts_per_rev: int,
    places_deg: tuple[float, ...],
) -> Connection:
    """Judge the connection of the heads from readings (n, H).

    ``positions``: counts modulo 2³². ``angles``: counts after the index. ``indexed`` (H,): heads
    that have detected their index. The table must have turned in the positive direction. Raises
    ValueError if no head has moved by a whole turn, or if the numbers of heads and of places
    differ.
    """
    if positions.shape[1] != len(places_deg):
        raise ValueError(
            f"the device has {positions.shape[1]} heads, the number of places is {len(places_deg)}"
        )
    steps = np.diff(positions, axis=0).astype(np.uint32).view(np.int32).astype(np.int64)
    travels = steps.sum(axis=0)
    most = int(np.abs(travels).max(initial=0))
    if most < counts_per_rev:
        raise ValueError("the table must turn at least once; no head has moved by a turn")
    sense = np.where(travels < 0, -1, 1)
    places = _places(angles, sense, indexed, counts_per_rev)
    at_head, off, mirrored = _cables(places, np.asarray(places_deg))
    faults = _sense_faults(travels, most)
    faults += [
        f"head {head}: no index detected in a turn: check Z and its polarity (4 in "
        f"head{head}_input)"
        for head in (np.flatnonzero(~indexed) + 1).tolist()
    ]
    if mirrored:
        faults.append(
            "the places run in the opposite direction: enter them in the positive direction of "
            "the table, or set 8 in the input of every head"
        )
    if 0 in at_head:
        if indexed.all():
            faults.append(
                f"no order of the cables brings the heads to the places of the plan ({off:.2f}° "
                "off at best): measure the places again, or enter the places found"
            )
    elif at_head != tuple(range(1, len(at_head) + 1)):
        swapped = [
            f"cable {cable} is at head {head}"
            for cable, head in enumerate(at_head, 1)
            if head != cable
        ]
        faults.append("heads exchanged: " + ", ".join(swapped) + "; exchange the cables")
    return Connection(
        tuple(travels.tolist()),
        tuple(indexed.tolist()),
        tuple(places.tolist()),
        at_head,
        off,
        tuple(faults),
    )


def _sense_faults(travels: Integer, most: int) -> list[str]:
    faults = []
    back = travels < 0
    still = np.abs(travels) < (1.0 - COUNTED_WRONG) * most
    if back.all():
        faults.append(
            "all heads count down: turn the table in its positive direction, or set 8 in the "
            "input of every head"
        )
    for head, travel in enumerate(travels.tolist(), start=1):
        if still[head - 1]:
            faults.append(
                f"head {head}: moved by {abs(travel) / most:.3f} of the travel of the others: "
                "check the wires of A and B, the light and the disc"
            )
        elif back[head - 1] and not back.all():
            faults.append(
                f"head {head}: counts in the opposite direction: exchange A and B (8 in "
                f"head{head}_input)"
            )
    return faults


def _places(
    angles: Integer, sense: Integer, indexed: NDArray[np.bool_], counts_per_rev: int
) -> Float:
    """Return the angles from head 1 to each head in degrees, as means over the turn after order 1,
    the eccentricity, was fitted and removed."""
    places = np.full(angles.shape[1], np.nan)
    if not indexed[0]:
        return places
    first = sense[0] * angles[:, 0] / counts_per_rev * 2.0 * np.pi
    design = np.column_stack((np.ones(first.size), np.cos(first), np.sin(first)))
    for head in np.flatnonzero(indexed):
        apart = sense[head] * angles[:, head] / counts_per_rev * 2.0 * np.pi - first
        middle = float(np.angle(np.exp(1j * apart).mean()))
        left = np.angle(np.exp(1j * (apart - middle)))
        mean = middle + float(np.linalg.lstsq(design, left)[0][0])
        places[head] = np.degrees(mean) % 360.0
    return places


def _cables(places_deg: Float, plan_deg: Float) -> tuple[tuple[int, ...], float, bool]:
    """Return the number of the head at each cable, the largest distance from the plan, and whether
    the heads fit the mirrored plan."""
    heads = plan_deg.size
    if np.isnan(places_deg).any():
        return (0,) * heads, float("nan"), False
    found: list[tuple[float, bool, tuple[int, ...]]] = []
    for mirrored in (False, True):
        for order in permutations(range(heads)):
            expected = plan_deg[list(order)] - plan_deg[order[0]]
            apart = places_deg - (-expected if mirrored else expected)
            off = float(np.abs((apart + 180.0) % 360.0 - 180.0).max())
            if off <= PLACE_TOLERANCE_DEG:
                # Evenly spaced heads fit several assignments. The first assignment, which exchanges
                # no cables, is returned if it fits.
                return tuple(place + 1 for place in order), off, mirrored
            found.append((off, mirrored, order))
    return (0,) * heads, min(found)[0], False


@dataclass(frozen=True)
class Skew:
    """Delay of each head, and the corrections that make all delays equal.

    ``late_ns`` (H,): delay of each head relative to head 1, including the delays that the device
    applied during the turns; ``u_ns`` (H,): its standard uncertainty; ``delays_clocks`` (H,):
    delays that ``head_delays`` packs into one parameter.
    """

    late_ns: Float
    u_ns: Float
    delays_clocks: tuple[int, ...]

    @property
    def head_delays(self) -> int:
        """Value of the device's parameter ``head_delays``: one byte per head, head 1 in the lowest
        byte."""
        return sum(clocks << 8 * head for head, clocks in enumerate(self.delays_clocks))


def skew_of(
    forward: OnDevice,
    backward: OnDevice,
    speeds_rad_s: tuple[float, float],
    samples: tuple[int, int],
    clock_hz: float,
    delays_clocks: tuple[int, ...],
) -> Skew:
    """Calculate the skew from two turns in opposite directions.

    ``delays_clocks``: delays that the device applied during these turns.

    Raises ValueError for turns in one direction and for a skew beyond 255 clocks.
    """
    if speeds_rad_s[0] * speeds_rad_s[1] >= 0.0:
        raise ValueError("both turns go in the same direction")
    apart = speeds_rad_s[0] - speeds_rad_s[1]
    late_s = -(forward.offsets_rad - backward.offsets_rad) / apart
    # ``noise_arcsec`` is the noise of one reading; an offset contains the noise of two heads.
    u_offset = [
        np.sqrt(2.0 / number) * found.noise_arcsec * RAD_PER_ARCSEC
        for found, number in zip((forward, backward), samples, strict=True)
    ]
    u_s = np.full(late_s.size, float(np.hypot(*u_offset)) / abs(apart))
    u_s[0] = 0.0
    # The measured delay includes the delays that the device applied.
    own = late_s - np.array(delays_clocks, dtype=np.float64) / clock_hz
    own -= own[0]
    needed = np.rint((own.max() - own) * clock_hz).astype(np.int64)
    if needed.max() > DELAY_MOST_CLOCKS:
        raise ValueError(
            f"the delays of the heads differ by {1e9 * float(np.ptp(own)):.0f} ns, and the device "
            f"can remove {DELAY_MOST_CLOCKS} clocks: was the speed the same in both directions?"
        )
    return Skew(1e9 * late_s, 1e9 * u_s, tuple(needed.tolist()))
