"""Draws the properties of benchmark sets: the world determines the disturbances, the content
determines the hidden causes."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np

from arctrue.measurement import MeasurementSet
from arctrue.studies.simulate.experiment import Experiment, full, lean, one_pass, one_speed
from arctrue.studies.simulate.simulated_set import Wanted
from arctrue.table.registry import RECIPES, REGISTRY, STRANGERS
from arctrue.table.rotary_table import HEAD_PLACES_DEG

Random = np.random.Generator
SAMPLES_A_RUN = 6_000
"""Number of samples in a run; a set of four runs has 24,000 rows."""
CYCLES = 10
FEW_SAMPLES_A_RUN = 600
INDEX_COUNTS = (0, 1)
UNSTATED_INDEX_COUNTS = 3
HEAD_ANGLE_ARCSEC = (3.0, 30.0)
UNDERSTATED = 3.0
"""Factor by which the stated uncertainty of the reference is too small."""
WRONG = ("head_angle", "index", "sensor_lag", "uncertainty")
COLOURS = ("pink", "power_law", "ornstein_uhlenbeck", "autoregressive", "by_angle")

FOUR_HEADS = "four_heads"
FOUR_HEADS_SAMPLES_A_RUN = 3_000
"""Number of samples in a run of four heads; the three differences in four runs have 36,000 rows."""
PLACES_OFF_DEG = 8.0
"""Largest distance of heads 2 to 4 from their usual places; the set states the true places."""
SHARE_WITH_REFERENCE = 0.75
SHARE_COLOURED = 0.25
HEADS_SHOW = (
    "high_order_graduation",
    "head_angle_error",
    "subdivision_error",
    "radial_error_motion",
    "bearing_ball_pass",
    "vibration",
    "timing_skew",
    "thermal_head_drift",
    "thermal_eccentricity",
    "count_slip",
    "graduation_defect",
)
"""Causes of the catalogue that the differences of the heads show."""


@dataclass
class Surroundings:
    """Disturbances of a set, as its world draws them; they are drawn before the content."""

    experiment: Experiment
    noise: list[Wanted] = field(default_factory=list)
    index_scatter_counts: int = 1
    extra: list[Wanted] = field(default_factory=list)
    """Causes of the catalogue that have the same effect as a wrong statement of the set."""
    understated: float = 1.0
    """Factor by which the stated uncertainty of the reference is too small."""
    adverse_conditions: list[str] = field(default_factory=list)
    """Names of the properties that make this set difficult: wrong statements, coloured noise, few
    or bad data.
    """
    head_places_deg: tuple[float, ...] | None = None
    """Places of the heads, relative to head 1; None: the two heads of the paper."""
    catalogue: tuple[str, ...] = ()
    """Causes of the catalogue that may be hidden; empty: all."""

    def thin(self, samples: int) -> None:
        """Limit the number of samples in a run."""
        reference = self.experiment.reference
        most = min([samples, *(run.samples for run in self.experiment.runs)])
        self.experiment = self.experiment.smaller(most, reference.cycles if reference else 0)

    def stated(self, measurement: MeasurementSet) -> MeasurementSet:
        """Return the set with the wrong statements of its world."""
        reference = measurement.reference
        if self.understated == 1.0 or reference is None:
            return measurement
        uncertainty = (reference.standard_uncertainty_arcsec or 0.0) / self.understated
        return replace(
            measurement, reference=replace(reference, standard_uncertainty_arcsec=uncertainty)
        )


def _usual(random: Random) -> Surroundings:
    return Surroundings(
        full().smaller(SAMPLES_A_RUN, CYCLES),
        index_scatter_counts=int(random.choice(INDEX_COUNTS)),
    )


def white(random: Random) -> Surroundings:
    """Draw disturbances in which the noise is white and all statements of the set are true."""
    return _usual(random)


def coloured(random: Random) -> Surroundings:
    """Draw disturbances in which the noise of the heads is coloured and, in half of the sets, the
    reference wanders."""
    found = _usual(random)
    found.noise = [Wanted(str(random.choice(COLOURS)))]
    if random.random() < 0.5:
        found.noise.append(Wanted("wandering_reference"))
    found.adverse_conditions = [item.name for item in found.noise]
    return found


def wrong_statements(random: Random) -> Surroundings:
    """Draw disturbances in which one or two statements are wrong: the separation α, an index that
    shifts by ±3 counts, a temperature sensor that lags, or a stated uncertainty that is too small.
    """
    found = _usual(random)
    number = 1 + int(random.random() < 0.3)
    found.adverse_conditions = [str(name) for name in random.choice(WRONG, number, replace=False)]
    if "index" in found.adverse_conditions:
        found.index_scatter_counts = UNSTATED_INDEX_COUNTS
    if "sensor_lag" in found.adverse_conditions:
        found.noise.append(Wanted("sensor_lag"))
    if "uncertainty" in found.adverse_conditions:
        found.understated = UNDERSTATED
    if "head_angle" in found.adverse_conditions:
        low, high = np.log(HEAD_ANGLE_ARCSEC)
        # A wrong statement of the separation has the same effect as a head at another place, so
        # that both count as one cause.
        found.extra = [Wanted("head_angle_error", float(np.exp(random.uniform(low, high))))]
    return found


def few_data(random: Random) -> Surroundings:
    """Draw disturbances in which the set has one run, one pass over the faces, one speed, or few
    samples."""
    found = _usual(random)
    kind = int(random.integers(4))
    planned = (lean, one_pass, one_speed, full)[kind]()
    samples = FEW_SAMPLES_A_RUN if kind == 3 else SAMPLES_A_RUN
    cycles = planned.reference.cycles if planned.reference else CYCLES
    found.experiment = planned.smaller(samples, min(cycles, CYCLES))
    found.adverse_conditions = [("lean", "one pass", "one speed", "few samples")[kind]]
    return found


def outliers_and_gaps(random: Random) -> Surroundings:
    """Draw disturbances in which the set has outliers, missing rows, or both."""
    found = _usual(random)
    chosen = (("outliers",), ("gaps",), ("outliers", "gaps"))[int(random.integers(3))]
    found.noise = [Wanted(name) for name in chosen]
    found.adverse_conditions = list(chosen)
    return found


def swinging_speed(random: Random) -> Surroundings:
    """Draw disturbances in which the speed of the drive oscillates during a run."""
    found = _usual(random)
    found.noise = [Wanted("swinging_speed")]
    found.adverse_conditions = ["swinging_speed"]
    return found


def four_heads(random: Random) -> Surroundings:
    """Draw disturbances in which four heads are at drawn places, which the set states; a run has
    3,000 rows. A quarter of the sets has no reference; in a quarter the noise of the heads is
    coloured. Only causes that the heads show are hidden; a fault of one head is at any of them.
    """
    found = _usual(random)
    off = random.uniform(-PLACES_OFF_DEG, PLACES_OFF_DEG, len(HEAD_PLACES_DEG[4]) - 1)
    others = np.round(np.array(HEAD_PLACES_DEG[4][1:]) + off, 2)
    found.head_places_deg = (0.0, *(float(place) for place in others))
    found.catalogue = HEADS_SHOW
    found.thin(FOUR_HEADS_SAMPLES_A_RUN)
    if random.random() >= SHARE_WITH_REFERENCE:
        found.experiment = replace(found.experiment, reference=None)
    if random.random() < SHARE_COLOURED:
        # The noise by angle depends on the head; the oracle assumes equal noise of all heads.
        colours = [name for name in COLOURS if name != "by_angle"]
        found.noise = [Wanted(str(random.choice(colours)))]
    found.adverse_conditions = [item.name for item in found.noise]
    return found


WORLDS: dict[str, Callable[[Random], Surroundings]] = {
    "white": white,
    "coloured": coloured,
    "wrong_statements": wrong_statements,
    "few_data": few_data,
    "outliers_and_gaps": outliers_and_gaps,
    "swinging_speed": swinging_speed,
    FOUR_HEADS: four_heads,
}
CONTENTS = ("nothing", "one", "parts", "stranger", "several")
CATALOGUE = tuple(name for name, item in RECIPES.items() if item.kind == "catalogue")
PARTS = tuple(name for name, item in RECIPES.items() if item.kind == "parts")
SHARE_OF_THREE = 0.25
"""Share of the sets with three causes among the sets with more than one cause."""


def hidden(content: str, random: Random, catalogue: tuple[str, ...] = ()) -> list[Wanted]:
    """Draw the causes of a set, with their sizes from their ranges.

    ``catalogue``: causes of the catalogue that may be drawn, if not all of them.
    """
    known = catalogue or CATALOGUE
    if content == "nothing":
        return []
    if content == "several":
        number = 3 if random.random() < SHARE_OF_THREE else 2
        names = [str(name) for name in random.choice(known, number, replace=False)]
    else:
        pool = {"one": known, "parts": PARTS, "stranger": tuple(STRANGERS)}[content]
        names = [str(random.choice(pool))]
    return [Wanted(name, REGISTRY[name].draw_size(random)) for name in names]
