"""Makes one set of the benchmark; world, content and seed determine the set."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from arctrue.measurement import MeasurementSet
from arctrue.studies.benchmark.independent.sets import independent_set
from arctrue.studies.benchmark.independent.world import independent_worlds
from arctrue.studies.benchmark.oracle import look
from arctrue.studies.benchmark.worlds import WORLDS, Surroundings, hidden
from arctrue.studies.simulate.simulated_set import SimulatedSet, Wanted, simulate_set
from arctrue.table.registry import REGISTRY

NOTHING = 1e-9
"""Factor that reduces a cause so far that it has no effect while all random draws stay the same."""


@dataclass(frozen=True)
class BenchmarkSet:
    """Measurement set, which the tested program (subject) may read, and truth, which it may not
    read."""

    measurement: MeasurementSet
    truth: dict[str, Any]


def make_set(task: Mapping[str, Any]) -> BenchmarkSet:
    """Make the set of a task: ``world``, ``content``, ``seed``, ``samples`` (per run, at most).

    The world determines the generator. The truth contains each cause with its size and the oracle's
    result for it, the noise, and, by channel, the RMS that no model can explain. Raises KeyError
    for an unknown world.
    """
    if task["world"] in independent_worlds():
        return BenchmarkSet(
            *independent_set(task["world"], task["content"], task["seed"], task["samples"])
        )
    random = np.random.default_rng([task["seed"], 0])
    surroundings = WORLDS[task["world"]](random)
    surroundings.thin(task["samples"])
    if task["content"] == "nothing":
        # Set the true separation to the stated one, because a difference would count as a cause.
        surroundings.extra = []
        surroundings.adverse_conditions = [
            name for name in surroundings.adverse_conditions if name != "head_angle"
        ]
    wanted = hidden(task["content"], random, surroundings.catalogue)
    wanted += [item for item in surroundings.extra if item.name not in {w.name for w in wanted}]
    # Drop causes that act only on a channel that the set does not have.
    wanted = [item for item in wanted if surroundings.experiment.can_honour(REGISTRY[item.name])]
    made = _simulated(wanted, surroundings, task["seed"])
    effects = []
    for number, item in enumerate(made.truth["effects"]):
        faint = list(wanted)
        faint[number] = Wanted(item["effect"], item["size"] * NOTHING)
        without = _simulated(faint, surroundings, task["seed"])
        signal = {
            channel: exact - without.exact_arcsec[channel]
            for channel, exact in made.exact_arcsec.items()
        }
        sight = look(
            item["effect"],
            made.measurement,
            signal,
            made.noise,
            made.index_variance_arcsec2,
            any("head" in cause for cause in item["causes"]),
        )
        effects.append(
            {
                **{key: item[key] for key in ("effect", "kind", "parts", "size", "unit")},
                "noncentrality": _seven(sight.noncentrality),
                "needed": _seven(sight.needed),
                "rms_arcsec": _seven(sight.rms_arcsec),
            }
        )
    truth = {
        "effects": effects,
        "noise": [
            {key: item[key] for key in ("noise", "size", "unit")} for item in made.truth["noise"]
        ],
        "adverse_conditions": surroundings.adverse_conditions,
        "floor_arcsec": {key: _seven(value) for key, value in made.truth["floor_arcsec"].items()},
    }
    return BenchmarkSet(surroundings.stated(made.measurement), truth)


def _simulated(wanted: list[Wanted], surroundings: Surroundings, seed: int) -> SimulatedSet:
    return simulate_set(
        wanted,
        surroundings.experiment,
        seed,
        title="benchmark",
        index_scatter_counts=surroundings.index_scatter_counts,
        noise=surroundings.noise,
        head_places_deg=surroundings.head_places_deg,
    )


def _seven(value: float) -> float:
    return float(f"{value:.7g}")
