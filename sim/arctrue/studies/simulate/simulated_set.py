"""Makes one measurement set with chosen causes, and its truth."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from arctrue.base.similar import did_you_mean
from arctrue.base.units import RAD_PER_ARCSEC
from arctrue.measurement import MeasurementSet
from arctrue.studies.simulate.experiment import Experiment, MovingReference, with_further
from arctrue.studies.simulate.measured_table import MeasuredTable, TrueNoise
from arctrue.table.cause import Cause
from arctrue.table.causes.belt_half_order import BeltPull
from arctrue.table.causes.disc_eccentricity import DiscEccentricity
from arctrue.table.causes.gear_mesh import GearMesh
from arctrue.table.causes.graduation_harmonics import GraduationHarmonics
from arctrue.table.head import Head
from arctrue.table.registry import NOISES, REGISTRY
from arctrue.table.rotary_table import HEAD_PLACES_DEG, RotaryTable, heads_at, two_heads
from arctrue.table.turned_head import TurnedHead

ECCENTRICITY_UM = (20.0, 30.0)
"""Range of the eccentricity in µm: it causes 76″ to 115″ in order 1."""
GRADUATION_ORDERS = (2, 3, 4, 5, 6, 8)
GRADUATION_ARCSEC = (0.15, 1.0)
NOISE_ARCSEC = 0.1
REFERENCE_NOISE_ARCSEC = 0.15
INDEX_SCATTER_COUNTS = 1
LARGEST_SIZE = 1000.0
"""Largest permitted size of a cause, divided by the largest size that is drawn; with a larger size,
turn numbers and counts would overflow."""


@dataclass(frozen=True)
class Wanted:
    """Wanted cause, given by its name; if ``size`` is None, the size is drawn."""

    name: str
    size: float | None = None


@dataclass(frozen=True)
class SimulatedSet:
    """Measurement set, which a user may see, and its truth, which a user may not see."""

    measurement: MeasurementSet
    truth: dict[str, Any]
    exact_arcsec: dict[str, NDArray[np.float64]]
    """Signal of each channel without noise and rounding; these signals belong to the truth."""
    noise: dict[str, TrueNoise]
    index_variance_arcsec2: float
    table: RotaryTable
    """Simulated table with all its causes."""


def simulate_set(
    wanted: Sequence[Wanted],
    experiment: Experiment,
    seed: int,
    *,
    title: str = "simulated rotary table",
    noise_arcsec: float = NOISE_ARCSEC,
    reference_noise_arcsec: float = REFERENCE_NOISE_ARCSEC,
    index_scatter_counts: int = INDEX_SCATTER_COUNTS,
    again: int = 0,
    further: Sequence[str] = (),
    noise: Sequence[Wanted] = (),
    heads: int = 2,
    head_places_deg: Sequence[float] | None = None,
) -> SimulatedSet:
    """Draw a table by ``seed`` with all wanted causes, and make the measurements of the experiment.

    ``again`` is the number of a repetition with the same table: only the noise, the detection of
    the index and the angle at which each run begins differ from the first measurement, number 0.

    ``further`` names measurements that are made after those of the experiment, on the same table;
    the capture runs of the experiment stay identical except for the draws of noise causes.

    ``noise`` are noise causes of the registry in addition to the white noise of both heads and the
    reference; they draw from their own streams, so that everything else stays identical.

    ``heads`` is the number of heads at their usual places; a cause of one head then acts on head 1
    or 2. ``head_places_deg`` gives two to four heads at other places; a cause of one head then acts
    on any of them.

    A latency needs a reference that is read while the table moves; it is added to the experiment if
    the experiment has a reference run. Raises ValueError for a name that no recipe has, and for a
    size that is not positive or too large for the simulation.
    """
    effects = {name: item for name, item in REGISTRY.items() if name not in NOISES}
    for item, known in [(x, effects) for x in wanted] + [(x, NOISES) for x in noise]:
        if item.name not in known:
            raise ValueError(
                f"no cause is called {item.name}.{did_you_mean(item.name, known)} "
                f"There are: {', '.join(known)}"
            )
        if item.size is not None and not item.size > 0:
            raise ValueError(f"the size of {item.name} must be positive, found {item.size}")
        most = LARGEST_SIZE * known[item.name].high
        if item.size is not None and item.size > most:
            raise ValueError(
                f"the size of {item.name} must be at most {most:g} {known[item.name].unit}, found "
                f"{item.size:g}; a table has up to {known[item.name].high:g}"
            )
    table_random, cause_random, noise_random = (
        np.random.default_rng(child) for child in np.random.SeedSequence(seed).spawn(3)
    )
    if again:
        noise_random = np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(3, again)))
    if any(item.name == "latency" for item in wanted) and experiment.reference is not None:
        speeds = tuple(run.speed_rad_s for run in experiment.runs[:3]) or (0.5, -0.5)
        moving = MovingReference(speeds)
        experiment = replace(experiment, reference=replace(experiment.reference, moving=moving))
    occasion = experiment.occasion
    stand = _heads(heads)
    if head_places_deg is not None:
        stand = heads_at(np.deg2rad(head_places_deg).tolist())
        occasion = replace(occasion, heads=stand)
    causes: list[Cause] = []
    hidden: list[dict[str, Any]] = []
    for item in wanted:
        recipe = effects[item.name]
        size = recipe.draw_size(cause_random) if item.size is None else item.size
        built = recipe.draw(size, cause_random, occasion)
        causes += built
        hidden.append(
            {
                "effect": recipe.name,
                "in_catalogue": recipe.in_catalogue,
                "kind": recipe.kind,
                "parts": [_drawn_part(part, built[0]) for part in recipe.parts],
                "size": size,
                "unit": recipe.unit,
                "causes": [_plain(cause) for cause in built],
            }
        )
    noises: list[Cause] = []
    disturbed: list[dict[str, Any]] = []
    for number, item in enumerate(noise):
        recipe = NOISES[item.name]
        random = np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(4, number)))
        size = recipe.draw_size(random) if item.size is None else item.size
        built = recipe.draw(size, random, occasion)
        noises += built
        disturbed.append(
            {
                "noise": recipe.name,
                "size": size,
                "unit": recipe.unit,
                "causes": [_plain(cause) for cause in built],
            }
        )
    base = _base_effects(table_random)
    table = RotaryTable(stand, (*base, *noises, *causes), noise_rad=noise_arcsec * RAD_PER_ARCSEC)
    for kind in further:
        # The further measurements are drawn after the causes, so that the causes depend on the
        # experiment alone.
        experiment = with_further(experiment, kind)
    teeth = next((cause.teeth for cause in causes if isinstance(cause, GearMesh)), None)
    measured_table = MeasuredTable(
        table,
        reference_noise_arcsec=reference_noise_arcsec,
        index_scatter_counts=index_scatter_counts,
        random=noise_random,
    )
    measured = measured_table.measure(experiment, title=title, drive_gear_teeth=teeth)
    truth = {
        "schema": 1,
        "hidden": "+".join(item.name for item in wanted) or "none",
        "seed": seed,
        "again": again,
        "experiment": experiment.name,
        **({} if len(stand) == 2 else {"heads": len(stand)}),
        "effects": hidden,
        "table": [_plain(effect) for effect in base],
        "noise": disturbed,
        "noise_arcsec": noise_arcsec,
        "reference_noise_arcsec": reference_noise_arcsec,
        "index_scatter_counts": index_scatter_counts,
        "floor_arcsec": measured.floor_arcsec,
    }
    return SimulatedSet(
        measured.measurement,
        truth,
        measured.exact_arcsec,
        measured.noise,
        measured.index_variance_arcsec2,
        table,
    )


def _heads(number: int) -> tuple[Head, ...]:
    """Return the paper's two heads, or three or four heads. Raises ValueError for another
    number."""
    if number not in HEAD_PLACES_DEG:
        raise ValueError(f"heads: expected {min(HEAD_PLACES_DEG)} to {max(HEAD_PLACES_DEG)}")
    return two_heads() if number == 2 else heads_at(np.deg2rad(HEAD_PLACES_DEG[number]).tolist())


def _base_effects(random: np.random.Generator) -> list[Cause]:
    amplitudes = random.uniform(*GRADUATION_ARCSEC, len(GRADUATION_ORDERS)) * RAD_PER_ARCSEC
    phases = random.uniform(0.0, 2 * np.pi, len(GRADUATION_ORDERS))
    return [
        DiscEccentricity(
            float(random.uniform(*ECCENTRICITY_UM)) * 1e-6, float(random.uniform(0.0, 2 * np.pi))
        ),
        GraduationHarmonics(GRADUATION_ORDERS, tuple(amplitudes.tolist()), tuple(phases.tolist())),
    ]


def _drawn_part(part: str, cause: Cause) -> str:
    """Replace ``order:*`` in the name of a recipe's part by the order that was drawn, and ``head2``
    by the head that was drawn."""
    if part == "order:*":
        assert isinstance(cause, BeltPull)
        return f"order:{cause.order:g}"
    if part == "head2":
        assert isinstance(cause, TurnedHead)
        return f"head{cause.head + 1}"
    return part


def _plain(effect: Cause) -> dict[str, Any]:
    """Return the class and the fields of a cause as values for JSON; a complex number becomes two
    numbers."""
    fields = {
        key: [value.real, value.imag] if isinstance(value, complex) else value
        for key, value in asdict(effect).items()  # type: ignore[call-overload]
    }
    fields.pop("at", None)
    return {"cause": type(effect).__name__, **fields}
