"""``arctrue commission PORT``: checks how the heads are connected, then places, radii and skew."""

from __future__ import annotations

import sys

import click
import numpy as np

from arctrue.calibration import CaptureRefusedError, whole_turns
from arctrue.calibration.commissioning import Connection, Skew, judge_connection, skew_of
from arctrue.calibration.heads_on_device import OnDevice, heads_on_device
from arctrue.cli._device import console_at
from arctrue.cli._numbers import Finite
from arctrue.cli._places import Places
from arctrue.cli._tables import live_head, live_row
from arctrue.cli._terminal import note, say, tell_error
from arctrue.device.console import Console, ConsoleError
from arctrue.device.heads_readings import read_heads

WRONG = 1
NO_DEVICE = 2
ORDERS = 32
"""Number of orders that the fit has, as in the device."""
PLACE_PARAMETERS = ("separation_deg", "head3_deg", "head4_deg")
CONNECTION = (("cable", 6), ("moved turns", 12), ("index", 7), ("place °", 10), ("is at head", 11))
TURNED = (
    *(("head", 5), ("place °", 11), ("u ″", 6), ("radius/nominal", 15), ("u", 8)),
    *(("late ns", 9), ("u ns", 7), ("delay", 6)),
)


@click.command(short_help="Check how the heads are connected; measure places, radii and skew.")
@click.argument("port")
@click.option(
    "--places",
    "places_deg",
    type=Places(),
    help="Places of all heads as planned, after head 1: 0,64.3,177,257.9. Without it those that "
    "the device holds.",
)
@click.option(
    "--connection",
    "only",
    is_flag=True,
    help="End after the first step: order, sense and indices of the heads.",
)
@click.option("--write", is_flag=True, help="Set the places and head_delays of the device.")
@click.option(
    "--timeout",
    type=Finite(min=1.0),
    default=120.0,
    show_default=True,
    help="Seconds to wait for the turns of a step.",
)
def commission(
    port: str, places_deg: tuple[float, ...] | None, only: bool, write: bool, timeout: float
) -> None:
    """Walk through the first operation of the heads at PORT, and say what is wrong.

    Step 1: the table turns twice in its positive direction, by hand or by its drive. The command
    names a head that counts the wrong way, stands, has no index, or has the cable of another head.
    Steps 2 and 3: a turn at constant speed forward, and one backward. The command gives the places
    with their uncertainties, the radii, the noise of the parity, and the skew of the heads'
    electronics with the delays that remove it. A bearing that runs differently backward looks like
    skew; a second pair of turns at another speed tells them apart.

    Exit code 1: a head is connected wrongly, or a turn is refused. 2: no answer.
    """
    try:
        console = console_at(port)
        device = _parameters(console)
        plan = places_deg or _planned(device)
        counts = int(device["counts_per_rev"])
        found = _connection(console, counts, plan, timeout)
        _show_connection(found)
        if found.faults or only:
            if write and not found.faults:
                _write(console, device, plan, None)
            sys.exit(WRONG if found.faults else 0)
        skew, turns, places = _turns(console, device, plan, timeout)
        _show_turns(skew, turns, places)
        if write:
            _write(console, device, tuple(places.tolist()), skew)
    except (CaptureRefusedError, ValueError) as error:
        tell_error(str(error))
        sys.exit(WRONG)
    except (ConsoleError, OSError) as error:
        tell_error(str(error))
        sys.exit(NO_DEVICE)


def _ask(instruction: str) -> None:
    note(instruction)
    if sys.stdin.isatty():
        click.prompt("Enter when it turns so", default="", show_default=False, err=True)


def _parameters(console: Console) -> dict[str, float]:
    words = [line.split() for line in console.command("show parameters")]
    version = [line.split() for line in console.command("version")]
    return {
        one[0]: float(one[1])
        for one in (*words, *(one for one in version if one[0] == "clock_hz"))
        if len(one) == 2
    }


def _planned(device: dict[str, float]) -> tuple[float, ...]:
    """Return the places in the device's parameters; a head without a place ends the list."""
    places = [0.0]
    for name in PLACE_PARAMETERS:
        if not device.get(name):
            break
        places.append(device[name])
    return tuple(places)


def _connection(
    console: Console, counts_per_rev: int, plan: tuple[float, ...], seconds: float
) -> Connection:
    _ask("1. Turn the table twice in its positive direction, by hand or by its drive.")
    read = read_heads(console, counts_per_rev, seconds)
    return judge_connection(read.positions, read.angles, read.indexed, counts_per_rev, plan)


def _show_connection(found: Connection) -> None:
    most = max(abs(travel) for travel in found.travels)
    say(live_head(CONNECTION))
    for cable, travel in enumerate(found.travels):
        place, head = found.places_deg[cable], found.at_head[cable]
        cells = (
            str(cable + 1),
            f"{travel / most:+.3f}",
            "seen" if found.indexed[cable] else "none",
            "–" if np.isnan(place) else f"{place:.3f}",
            str(head) if head else "?",
        )
        say(live_row(cells, CONNECTION))
    for fault in found.faults:
        say(fault)
    if not found.faults:
        say(f"All heads are as planned; places within {found.off_deg:.3f}°.")


def _turn(
    console: Console, device: dict[str, float], plan: tuple[float, ...], seconds: float
) -> tuple[OnDevice, float, int]:
    """Capture a turn; return its fit, its speed in rad/s, and its number of samples."""
    counts = int(device["counts_per_rev"])
    taken = console.dump(seconds)
    assert taken.capture is not None
    (turn,) = whole_turns(taken.capture, counts, most_order=ORDERS)
    index = device.get("index_detection_arcsec")
    options = {} if index is None else {"u_index_arcsec": index}
    fit = heads_on_device(turn, counts, np.radians(np.asarray(plan)), ORDERS, **options)
    period = float(np.median(np.diff(taken.capture.time_s)))
    return fit, turn.step_counts / counts * 2.0 * np.pi / period, turn.samples


def _turns(
    console: Console, device: dict[str, float], plan: tuple[float, ...], seconds: float
) -> tuple[Skew, tuple[OnDevice, OnDevice], np.ndarray]:
    _ask("2. Let the table turn forward at constant speed, and keep turning.")
    forward, speed, samples = _turn(console, device, plan, seconds)
    _ask("3. Let it turn backward at the same speed.")
    backward, speed_back, samples_back = _turn(console, device, plan, seconds)
    word = int(device.get("head_delays", 0.0))
    delays = tuple(word >> 8 * head & 0xFF for head in range(len(plan)))
    skew = skew_of(
        forward,
        backward,
        (speed, speed_back),
        (samples, samples_back),
        device["clock_hz"],
        delays,
    )
    both = [fit.offsets_rad + fit.late_rad for fit in (forward, backward)]
    return skew, (forward, backward), np.degrees(np.mean(both, axis=0)) % 360.0


def _show_turns(skew: Skew, turns: tuple[OnDevice, OnDevice], places: np.ndarray) -> None:
    ratio = np.mean([fit.ratios for fit in turns], axis=0)
    u_ratio = np.mean([fit.u_ratios for fit in turns], axis=0)
    u_place = np.mean([fit.u_late_arcsec for fit in turns], axis=0)
    say(live_head(TURNED))
    for head in range(places.size):
        cells = (
            *(str(head + 1), f"{places[head]:.4f}", f"{u_place[head]:.1f}"),
            # ρ is the radius of the disc over that of the head.
            *(f"{1.0 / ratio[head]:.6f}", f"{u_ratio[head]:.6f}"),
            *(f"{skew.late_ns[head]:+.0f}", f"{skew.u_ns[head]:.0f}"),
            str(skew.delays_clocks[head]),
        )
        say(live_row(cells, TURNED))
    name = "parity" if places.size == 4 else "differences of the heads"
    noise = float(np.sqrt(np.mean([fit.noise_arcsec**2 for fit in turns])))
    say(f"Noise of the {name}: {noise:.3f}″.")
    say(f"set head_delays {skew.head_delays}, while the table stands: the zero begins anew.")


def _write(
    console: Console, device: dict[str, float], places: tuple[float, ...], skew: Skew | None
) -> None:
    for name, place in zip(PLACE_PARAMETERS, places[1:], strict=False):
        console.command(f"set {name} {place:.6f}")
    if skew is not None and skew.head_delays != int(device.get("head_delays", 0.0)):
        _ask("Let the table stand: the delays change.")
        console.command(f"set head_delays {skew.head_delays}")
    say("Written; `arctrue save` keeps it over power-off.")
