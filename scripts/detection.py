"""How small an effect can be and still be found, beside what an ideal test could do.

``python -m scripts.detection [--only NAME,…] [--sets N] [--first-seed N]``. Writes
build/blind/detection.json after every effect; :mod:`scripts.make_blind_page` makes table and
picture of it.

For each set the limit of the ideal test is computed: the generalised likelihood ratio that knows
the true form, searches only what the truth leaves open (an order, a frequency), needs no
correction for other candidates, and finds the effect in 95 % of the sets at a false alarm of 1 %.
The effect is then made so many times larger than that limit, in all sets alike, and the whole
diagnosis must find it among all candidates: by name, in the class, or by the right condition and
order where it has no name. ``matters`` is 0 here: what is smaller than half a
count is found too, though not worth a name.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path

import numpy as np
from scipy.optimize import brentq
from scipy.stats import chi2, ncx2

from arctrue.studies.simulate.experiment import Experiment, full
from arctrue.studies.simulate.simulated_set import Wanted, simulate_set
from arctrue.table.causes.registry import RECIPES
from scripts.blind_judge import NOTHING, diagnosed, visibility

OUT = Path(__file__).resolve().parents[1] / "build" / "blind" / "detection.json"
FALSE_ALARM, POWER = 0.01, 0.95
LADDER = (1.0, 1.25, 1.5, 2.0, 3.0, 5.0)
"""Sizes that are tried, in limits of the ideal test."""
START = 2
FRAMES = ("disc", "stator", "head1", "head2", "reference")
FIRST_SEED = 905_000
"""Of sets that nothing was mended on; after a change that they led to, take others."""
SAMPLES, FINE_SAMPLES = 2_000, 9_000
"""A run. What is narrow or fast needs the finer ones, else it would not be in the set at all."""
FINE = ("vibration", "graduation_defect")
TURNS = 12
NYQUIST_HZ = 125.0

FORMS = {
    "high_order_graduation": (2, 220),
    "head_angle_error": (1, 1),
    "subdivision_error": (8, 1),
    "radial_error_motion": (2, 7),
    "bearing_ball_pass": (4, 2 * TURNS * 14),
    "vibration": (8, 36 * NYQUIST_HZ),
    "hysteresis": (1, 1),
    "timing_skew": (1, 1),
    "latency": (1, 1),
    "thermal_head_drift": (1, 1),
    "thermal_eccentricity": (2, 1),
    "count_slip": (1, 4 * 4 * np.log(SAMPLES)),
    "graduation_defect": (1, 360 / 0.1),
    "drive_gear_error": (2, 1),
    "polygon_face_error": (23, 1),
    "polygon_eccentricity": (2, 1),
    "autocollimator_gain": (1, 1),
    "reference_drift": (1, 1),
    "warm_ovality": (2, 1),
    "centrifugal_lobes": (2, 1),
    "half_order": (2, 1),
    "settling_bracket": (1, 6),
}
"""Coefficients of the true form, and places that it leaves open: orders, frequencies, instants,
places on the disc (as many as a turn has widths), time constants."""


@dataclass
class Detection:
    """One effect: limits of its sets, and how many were found at each size tried."""

    name: str
    unit: str
    limits: list[float]
    """Size at the limit of the ideal test, of each set."""
    found: dict[str, tuple[int, int]] = field(default_factory=dict)
    """By size in limits: sets in which it was found, sets tried (fewer once it is lost)."""
    smallest: float | None = None
    """In limits: the smallest size of the ladder that was found in 95 % of the sets."""


def planned(name: str) -> Experiment:
    """Four runs and ten cycles, small enough for many sets."""
    return full().smaller(FINE_SAMPLES if name in FINE else SAMPLES, 10)


def ideal_chi_square(name: str) -> float:
    """Noncentrality at which the ideal test finds the effect with POWER."""
    rank, places = FORMS[name]
    threshold = chi2.isf(FALSE_ALARM / places, rank)
    return float(brentq(lambda value: ncx2.sf(threshold, rank, value) - POWER, 1e-3, 1e4))


def limit_size(name: str, seed: int) -> float:
    """Size that gives the set of this seed the ideal test's noncentrality."""
    recipe = RECIPES[name]
    usual = float(np.sqrt(recipe.low * recipe.high))
    made = simulate_set([Wanted(name, usual)], planned(name), seed)
    without = simulate_set([Wanted(name, NOTHING)], planned(name), seed)
    observations, _ = diagnosed(made.measurement, None)
    shown = {key: made.exact_arcsec[key] - without.exact_arcsec[key] for key in made.exact_arcsec}
    chi_square, _ = visibility(observations, shown, made.truth["floor_arcsec"])
    return usual * float(np.sqrt(ideal_chi_square(name) / max(chi_square, 1e-12)))


def is_found(name: str, size: float, seed: int) -> bool:
    """The whole diagnosis, on one set."""
    made = simulate_set([Wanted(name, size)], planned(name), seed)
    _, found = diagnosed(made.measurement, 0.0)
    assert found is not None
    truth = made.truth["effects"][0]
    if truth["in_catalogue"]:
        return name in found.effect_class
    # Which frame a wave is fixed to shows only when it is larger.
    said = set() if found.described is None else set(found.described.effect.parts)  # type: ignore[attr-defined]
    return said - set(FRAMES) == set(truth["parts"]) - set(FRAMES)


def detect(name: str, sets: int, fine: bool, first_seed: int = FIRST_SEED) -> Detection:
    """Up the ladder from START until the effect is found; ``fine``: down too."""
    seeds = [first_seed + number for number in range(sets)]
    limits = [limit_size(name, seed) for seed in seeds]
    result = Detection(name, RECIPES[name].unit, limits)
    misses_allowed = int(np.floor((1.0 - POWER) * sets + 1e-9))
    step, passed = START, {}
    while 0 <= step < len(LADDER) and step not in passed:
        hits = misses = 0
        for seed, limit in zip(seeds, limits, strict=True):
            if is_found(name, LADDER[step] * limit, seed):
                hits += 1
            else:
                misses += 1
            if misses > misses_allowed:
                break
        result.found[f"{LADDER[step]:g}"] = (hits, hits + misses)
        passed[step] = misses <= misses_allowed
        if passed[step] and not fine:
            break
        step += -1 if passed[step] else 1
    good = [LADDER[index] for index, value in passed.items() if value]
    result.smallest = min(good) if good else None
    return result


def main(arguments: Sequence[str] | None = None) -> int:
    """All effects, or those asked for; keeps what the file has of the others."""
    parser = argparse.ArgumentParser(description="Detection against size.")
    parser.add_argument("--only", default="", help="effects with such texts in their name")
    parser.add_argument("--fine", action="store_true", help="sizes below the goal too")
    parser.add_argument("--sets", type=int, default=20, help="sets of each size")
    parser.add_argument("--first-seed", type=int, default=FIRST_SEED)
    options = parser.parse_args(arguments)
    OUT.parent.mkdir(parents=True, exist_ok=True)
    kept = json.loads(OUT.read_text(encoding="utf-8")) if OUT.exists() else {}
    for name in RECIPES:
        if not any(text in name for text in options.only.split(",")):
            continue
        result = detect(name, options.sets, options.fine, options.first_seed)
        kept[name] = asdict(result)
        OUT.write_text(json.dumps(kept, indent=1) + "\n", encoding="utf-8")
        print(
            f"{name}: limit {np.median(result.limits):.3g} {result.unit}, found in 95 % at "
            f"{result.smallest} limits; {result.found}",
            flush=True,
        )
    return 0


if __name__ == "__main__":
    sys.exit(main())
