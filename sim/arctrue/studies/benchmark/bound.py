"""Injects effects of the size that a diagnosis states as detectable, and tests whether the
diagnosis then finds them.

First a set without any effect is diagnosed; for each effect the diagnosis states its bound, which
is the smallest size that it would find in 95 % of such sets. Then a cause with at least this RMS in
every channel is added to the same experiment, new noise is drawn, and the set is diagnosed again.
"""

from __future__ import annotations

import tempfile
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from arctrue.measurement import MeasurementSet, read_measurement_set, write_measurement_set
from arctrue.studies.benchmark.diagnosis import diagnosed
from arctrue.studies.benchmark.independent.injection import INJECTIONS, rms_arcsec
from arctrue.studies.benchmark.independent.scene import made
from arctrue.studies.benchmark.intervals import Rate, rate
from arctrue.studies.campaign import Campaign, Task
from arctrue.workbench.diagnose.report_json import diagnosis_data
from arctrue.workbench.model.model import default_model

WORK = "arctrue.studies.benchmark.bound:run_bound"
PROMISED = 0.95
"""Share of sets in which the diagnosis promises to find an effect of the stated size."""
QUIET = ("adequate", "cannot_tell")
SAYS_MORE = ("named", "ambiguous", "unknown")
"""Verdicts that report an error in addition to the model; ``bad_data`` reports the rows only."""


def bound_campaign(
    folder: Path, effects: Sequence[str], times: int, samples: int, seed: int
) -> Campaign:
    """Make a campaign of ``times`` injections of each effect; consecutive tasks inject different
    effects."""
    tasks: list[Task] = [
        {
            "effect": effect,
            "seed": int(np.random.SeedSequence([seed, number]).generate_state(1)[0]),
            "samples": samples,
        }
        for number in range(times)
        for effect in effects
    ]
    facts = {"bound": {"times": times, "samples": samples, "seed": seed}}
    return Campaign(WORK, tasks, folder, facts)


def run_bound(task: Mapping[str, Any]) -> dict[str, Any]:
    """Inject the task's ``effect`` once; return the stated bound, the injected size and the answer.

    ``bound_rms_arcsec`` is None if the diagnosis of the set without any effect states no bound of
    the effect, because the diagnosis cannot test the effect or reports that an effect is present.
    """
    effect = str(task["effect"])
    injection = INJECTIONS[effect]
    random = np.random.default_rng([task["seed"], 3])
    scene = injection.scene(random, task["samples"])
    before = _said(made(scene, random)[0])
    stated = (before["covers"] or {}).get("smallest", {}).get(effect)
    if before["verdict"] not in QUIET or stated is None:
        return {"bound_rms_arcsec": None, "verdict": before["verdict"]}
    cause = injection.cause(random, scene)
    bound = {name: float(value) for name, value in stated["rms_arcsec"].items()}
    cause = cause.scaled(factor_to_bound(bound, rms_arcsec(scene, cause)))
    after = _said(made(replace(scene, causes=[cause]), random)[0])
    names = [after.get("named"), *(after.get("class") or []), *(after.get("negligible") or [])]
    return {
        "bound_rms_arcsec": bound,
        "size": float(f"{cause.size:.7g}"),
        "verdict": after["verdict"],
        "named": after.get("named"),
        "class": list(after.get("class") or []),
        "found": after["verdict"] in SAYS_MORE or effect in names,
        "by_name": effect in names,
    }


def factor_to_bound(bound: Mapping[str, float], own: Mapping[str, float]) -> float:
    """Return the smallest factor that scales a cause to at least the bound in every channel.

    A channel counts if the RMS of the cause in this channel exceeds a thousandth of its largest
    RMS, and if the bound has a value for the channel. Raises ValueError if no channel counts.
    """
    shown = {name: value for name, value in own.items() if value > 1e-3 * max(own.values())}
    factors = [bound[name] / value for name, value in shown.items() if bound.get(name)]
    if not factors:
        raise ValueError(
            f"the bound has channels {sorted(bound)}, the cause appears in {sorted(shown)}"
        )
    return max(factors)


def _said(measurement: MeasurementSet) -> dict[str, Any]:
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place) / "set"
        write_measurement_set(folder, measurement)
        _, found = diagnosed(read_measurement_set(folder))
    return diagnosis_data(found, default_model().names())


@dataclass(frozen=True, slots=True)
class BoundScore:
    """Rates at which the diagnosis found one effect that was injected at the stated bound."""

    effect: str
    found: Rate
    """Rate at which the verdict is neither ``adequate`` nor ``cannot_tell``, or the diagnosis lists
    the injected effect as negligible."""
    by_name: Rate
    """Rate at which the diagnosis names the injected effect, puts it into the class of possible
    names, or lists it as negligible."""

    @property
    def kept(self) -> bool:
        """Tell whether the upper end of the 95 % interval is at least the promised share."""
        return self.found.interval[1] >= PROMISED


def bound_scores(results: Iterable[tuple[Task, Mapping[str, Any]]]) -> list[BoundScore]:
    """Return each effect's rates over the sets for which the diagnosis states a bound of this
    effect, in the order of INJECTIONS."""
    by_effect: dict[str, list[Mapping[str, Any]]] = {}
    for task, result in results:
        stated = by_effect.setdefault(task["effect"], [])
        if result["bound_rms_arcsec"] is not None:
            stated.append(result)
    return [
        BoundScore(
            effect,
            rate([item["found"] for item in by_effect[effect]]),
            rate([item["by_name"] for item in by_effect[effect]]),
        )
        for effect in INJECTIONS
        if effect in by_effect
    ]
