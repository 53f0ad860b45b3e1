"""Measures how the heads of a device are connected, and then their places, radii and skew.

Each of three steps needs a movement of the table: two turns in the positive direction (by hand or
by the drive), one turn forward at constant speed, and one turn backward at the same speed. The
caller asks the operator for the movement; each function reads the device while the table moves.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from arctrue.calibration import whole_turns
from arctrue.calibration.commissioning import Connection, Skew, judge_connection, skew_of
from arctrue.calibration.heads_on_device import OnDevice, heads_on_device
from arctrue.device.console import Console, ConsoleError
from arctrue.device.heads_readings import read_heads

ORDERS = 32
"""Number of orders of the fit; the device fits the same number."""
PLACE_PARAMETERS = ("separation_deg", "head3_deg", "head4_deg")
STEPS = (
    "Turn the table twice in its positive direction, by hand or by its drive.",
    "Let the table turn forward at constant speed until the capture has ended.",
    "Let the table turn backward at the same speed until the capture has ended.",
)
"""Movement that each step needs, as an instruction to the operator."""
CONNECTION_COLUMNS = ("cable", "moved turns", "index", "place °", "is at head")
TURNED_COLUMNS = ("head", "place °", "u ″", "radius/nominal", "u", "late ns", "u ns", "delay")

TABLE_COLUMNS = (
    ("head", "head"),
    ("sense", "counts"),
    ("index", "index"),
    ("place_deg", "place °"),
    ("u_arcsec", "u ″"),
    ("from", "from"),
    ("at_head", "is at head"),
    ("late_ns", "late ns"),
    ("u_ns", "u ns"),
    ("radius", "radius/nominal"),
    ("u", "u"),
)
"""Columns of the console's ``show heads``, and their titles on the page."""

Parameters = dict[str, float]


@dataclass(frozen=True)
class MeasuredTurn:
    """Fit of all heads over one turn, with the speed and the number of samples of the turn."""

    fit: OnDevice
    speed_rad_s: float
    samples: int


@dataclass(frozen=True)
class Turned:
    """Results of one turn in each direction; ``places_deg`` (heads,) are relative to head 1."""

    skew: Skew
    turns: tuple[OnDevice, OnDevice]
    places_deg: NDArray[np.float64]

    @property
    def noise_name(self) -> str:
        """Name of the combination of readings from which :attr:`noise_arcsec` is computed."""
        return "parity" if self.places_deg.size == 4 else "differences of the heads"

    @property
    def noise_arcsec(self) -> float:
        """Standard deviation of the combination :attr:`noise_name`, scaled to the noise of one
        reading."""
        return float(np.sqrt(np.mean([fit.noise_arcsec**2 for fit in self.turns])))


def read_parameters(console: Console) -> Parameters:
    """Return the device's numeric parameters and its ``clock_hz``. Raises ConsoleError."""
    words = [line.split() for line in console.command("show parameters")]
    version = [line.split() for line in console.command("version")]
    return {
        one[0]: _number(one[0], one[1])
        for one in (*words, *(one for one in version if one[0] == "clock_hz"))
        if len(one) == 2
    }


def _number(name: str, text: str) -> float:
    try:
        return float(text)
    except ValueError as error:
        raise ConsoleError(f"the device's {name}: expected a number, found {text[:40]}") from error


def planned_places(device: Parameters) -> tuple[float, ...]:
    """Return the places of the heads in the device's parameters, up to the first head without a
    place."""
    places = [0.0]
    for name in PLACE_PARAMETERS:
        if not device.get(name):
            break
        places.append(device[name])
    return tuple(places)


def read_heads_table(console: Console) -> list[tuple[str, ...]]:
    """Return the cells of the console's table of the heads, one row per head; "–" for a value that
    the device does not have. Raises ConsoleError if the device has no such table."""
    lines = [tuple(line.split()) for line in console.command("show heads")]
    names = tuple(name for name, _ in TABLE_COLUMNS)
    if not lines or lines[0] != names or any(len(line) != len(names) for line in lines):
        raise ConsoleError(f"{console.port}: the answer to show heads is not understood: {lines}")
    return [tuple("–" if cell == "-" else cell for cell in line) for line in lines[1:]]


def read_connection(
    console: Console, device: Parameters, plan_deg: tuple[float, ...], seconds: float
) -> Connection:
    """Read the heads during the first movement, and report how they are connected.

    Raises ValueError for too little motion, and ConsoleError.
    """
    counts = int(device["counts_per_rev"])
    read = read_heads(console, counts, seconds)
    return judge_connection(read.positions, read.angles, read.indexed, counts, plan_deg)


def measure_turn(
    console: Console, device: Parameters, plan_deg: tuple[float, ...], seconds: float
) -> MeasuredTurn:
    """Capture a turn and fit all heads. Raises CaptureRefusedError, ValueError, ConsoleError."""
    counts = int(device["counts_per_rev"])
    taken = console.dump(seconds)
    assert taken.capture is not None
    (turn,) = whole_turns(taken.capture, counts, most_order=ORDERS)
    index = device.get("index_detection_arcsec")
    options = {} if index is None else {"u_index_arcsec": index}
    fit = heads_on_device(turn, counts, np.radians(np.asarray(plan_deg)), ORDERS, **options)
    period = float(np.median(np.diff(taken.capture.time_s)))
    return MeasuredTurn(fit, turn.step_counts / counts * 2.0 * np.pi / period, turn.samples)


def both_directions(device: Parameters, forward: MeasuredTurn, backward: MeasuredTurn) -> Turned:
    """Compute skew and places from a turn in each direction. Raises ValueError for turns in one
    direction and for a skew that the device cannot remove."""
    word, heads = int(device.get("head_delays", 0.0)), forward.fit.offsets_rad.size
    skew = skew_of(
        forward.fit,
        backward.fit,
        (forward.speed_rad_s, backward.speed_rad_s),
        (forward.samples, backward.samples),
        device["clock_hz"],
        tuple(word >> 8 * head & 0xFF for head in range(heads)),
    )
    fits = (forward.fit, backward.fit)
    both = [fit.offsets_rad + fit.late_rad for fit in fits]
    return Turned(skew, fits, np.degrees(np.mean(both, axis=0)) % 360.0)


def write_places(console: Console, places_deg: tuple[float, ...]) -> None:
    """Write the places to the device. Raises ConsoleError."""
    for name, place in zip(PLACE_PARAMETERS, places_deg[1:], strict=False):
        console.command(f"set {name} {place:.6f}")


def write_delays(console: Console, skew: Skew) -> None:
    """Write the delays to the device; the table must stand still. Raises ConsoleError."""
    console.command(f"set head_delays {skew.head_delays}")


def connection_rows(found: Connection) -> list[tuple[str, ...]]:
    """Return the cells of a table with :data:`CONNECTION_COLUMNS`, one row per cable."""
    most = max(abs(travel) for travel in found.travels)
    return [
        (
            str(cable + 1),
            f"{travel / most:+.3f}",
            "seen" if found.indexed[cable] else "none",
            "–" if np.isnan(found.places_deg[cable]) else f"{found.places_deg[cable]:.3f}",
            str(found.at_head[cable] or "?"),
        )
        for cable, travel in enumerate(found.travels)
    ]


def turned_rows(found: Turned) -> list[tuple[str, ...]]:
    """Return the cells of a table with :data:`TURNED_COLUMNS`, one row per head."""
    ratio = np.mean([fit.ratios for fit in found.turns], axis=0)
    u_ratio = np.mean([fit.u_ratios for fit in found.turns], axis=0)
    u_place = np.mean([fit.u_late_arcsec for fit in found.turns], axis=0)
    skew = found.skew
    return [
        (
            *(str(head + 1), f"{place:.4f}", f"{u_place[head]:.1f}"),
            # ρ is the disc's radius divided by the head's radius.
            *(f"{1.0 / ratio[head]:.6f}", f"{u_ratio[head]:.6f}"),
            *(f"{round(skew.late_ns[head]):+d}", f"{skew.u_ns[head]:.0f}"),
            str(skew.delays_clocks[head]),
        )
        for head, place in enumerate(found.places_deg.tolist())
    ]
