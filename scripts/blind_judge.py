"""Hides a cause, lets the diagnosis see the folder only, and compares with the truth."""

from __future__ import annotations

import tempfile
import time
from collections.abc import Sequence
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from arctrue.measurement import MeasurementSet, read_measurement_set, write_measurement_set
from arctrue.studies.simulate.experiment import FURTHER
from arctrue.studies.simulate.simulated_set import Wanted, simulate_set
from arctrue.studies.simulate.truth import read_truth, write_truth
from arctrue.table.causes.registry import RECIPES
from arctrue.workbench.diagnose.diagnosis import Diagnosis, diagnose
from arctrue.workbench.effects.registry import catalogue
from arctrue.workbench.inference.normal import capture_sums, reference_sums
from arctrue.workbench.inference.residuals import Residuals
from arctrue.workbench.inference.solution import fit, solve
from arctrue.workbench.model.growth import settle
from arctrue.workbench.model.model import default_model
from arctrue.workbench.observations import Observations
from arctrue.workbench.observations.build import observations_of
from scripts.blind_cases import Case

VISIBLE_CHI_SQUARE = 30.0
"""χ² of the cause over what the base model can absorb: below it even its exact form, known
beforehand, would hardly stand out of 20 candidates at the 1 % level (5.2 σ, χ² = 27)."""
MATTERS_COUNTS = 0.5
NOTHING = 1e-9
"""Size of a cause that is there without effect, so that the experiment stays the same."""
OUTCOMES = (
    "right",
    "first in class",
    "in class",
    "adequate, rightly",
    "unknown, rightly",
    "unknown, wrong parts",
    "unknown, wrongly",
    "class without it",
    "falsely adequate",
    "false name",
    "bad data",
)
GOOD = ("right", "first in class", "in class", "adequate, rightly", "unknown, rightly")


@dataclass
class Outcome:
    """One set: what was hidden, what was said."""

    case: Case
    hidden: str
    size: str
    visible: bool
    chi_square: float
    """Of the hidden cause over what the base model leaves of it."""
    outcome: str
    verdict: str
    named: str | None
    effect_class: list[str]
    parts: list[str]
    candidates: list[tuple[str, float, float]]
    """Name, corrected p, ΔBIC of the first three."""
    lack_of_fit: dict[str, float]
    seconds: float
    held_out_over_floor: dict[str, tuple[float, float]] = field(default_factory=dict)
    """By channel: held-out RMS over the floor, before and after what was named was added."""
    next_kind: str | None = None
    """The next measurement that an ambiguous set asks for."""
    after_next: str | None = None
    """Outcome once that measurement was simulated and added."""
    second: str | None = None
    """Of two causes at once: what the second diagnosis says, the first one's name in the model."""

    def data(self) -> dict[str, Any]:
        """As JSON."""
        return asdict(self)

    @classmethod
    def of(cls, data: dict[str, Any]) -> Outcome:
        """From JSON."""
        case = {**data["case"], "names": tuple(data["case"]["names"])}
        return cls(**{**data, "case": Case(**case)})


def run_case(case: Case) -> Outcome:
    """Simulate, seal, diagnose, unseal, compare."""
    wanted = [Wanted(name, size) for name, size in zip(case.names, case.sizes(), strict=True)]
    experiment = case.planned()
    # Sets with and without the usual scatter of the index, as both are met.
    scatter = case.seed % 2
    made = simulate_set(wanted, experiment, case.seed, index_scatter_counts=scatter)
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place) / "set"
        write_measurement_set(folder, made.measurement)
        write_truth(folder, made.truth)
        begin = time.perf_counter()
        observations, found = diagnosed(read_measurement_set(folder))
        assert found is not None
        seconds = time.perf_counter() - begin
        second = _second(observations, found) if len(case.names) > 1 else None
        after_next = _after_next(case, wanted, made.truth, found)
        truth = read_truth(folder)
    nothing = [Wanted(name, NOTHING) for name in case.names]
    without = simulate_set(nothing, experiment, case.seed, index_scatter_counts=scatter)
    chi_square, largest = 0.0, 0.0
    if case.names:
        shown = {
            key: made.exact_arcsec[key] - without.exact_arcsec[key] for key in made.exact_arcsec
        }
        chi_square, largest = visibility(observations, shown, truth["floor_arcsec"])
    matters = MATTERS_COUNTS * (observations.count_arcsec or 0.0)
    visible = chi_square > VISIBLE_CHI_SQUARE and largest > matters
    return Outcome(
        case=case,
        hidden=truth["hidden"],
        size=", ".join(f"{item['size']:.3g} {item['unit']}" for item in truth["effects"]),
        visible=visible,
        chi_square=chi_square,
        outcome=judged(truth, found, visible),
        verdict=found.verdict,
        named=None if found.named is None else found.named.name,
        effect_class=list(found.effect_class),
        parts=_parts(found),
        candidates=[(item.name, item.p_corrected, item.delta_bic) for item in found.candidates[:3]],
        lack_of_fit=dict(found.lack_of_fit),
        seconds=seconds,
        next_kind=found.next_measurement_kind if found.verdict == "ambiguous" else None,
        after_next=after_next,
        held_out_over_floor=_held_out(case.names, found, truth["floor_arcsec"]),
        second=second,
    )


def diagnosed(
    measurement: MeasurementSet, matters_counts: float | None = MATTERS_COUNTS
) -> tuple[Observations, Diagnosis | None]:
    """Rows of a set and what the diagnosis says of them; None: nothing is asked."""
    observations = observations_of(measurement)
    if matters_counts is None:
        return observations, None
    effects = catalogue([])
    terms = settle(default_model(), observations, effects)
    found = diagnose(observations, terms, effects, matters_counts=matters_counts)
    return observations, found


def _after_next(
    case: Case, wanted: Sequence[Wanted], truth: dict[str, Any], found: Diagnosis
) -> str | None:
    """The outcome once the measurement that an ambiguous set asks for is made and added."""
    kind = found.next_measurement_kind
    if found.verdict != "ambiguous" or kind not in FURTHER or kind == "polygon_reindexed":
        return None
    made = simulate_set(
        wanted,
        case.planned(),
        case.seed,
        index_scatter_counts=truth["index_scatter_counts"],
        further=[kind],
    )
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place) / "set"
        write_measurement_set(folder, made.measurement)
        _, again = diagnosed(read_measurement_set(folder))
    assert again is not None
    return judged(truth, again, True)


def _second(observations: Observations, found: Diagnosis) -> str | None:
    """What is named once the first name is in the model; the verdict where nothing is."""
    if found.named is None:
        return None
    again = diagnose(observations, found.named.solution.terms, catalogue([]))
    return again.verdict if again.named is None else again.named.name


def _parts(found: Diagnosis) -> list[str]:
    return [] if found.described is None else list(found.described.effect.parts)  # type: ignore[attr-defined]


def visibility(
    observations: Observations,
    shown_arcsec: dict[str, NDArray[np.float64]],
    noise_arcsec: dict[str, float],
) -> tuple[float, float]:
    """χ² of what the base model cannot absorb of a cause; its largest channel RMS, arcsec.

    ``shown_arcsec`` is what the cause alone shows in each channel, without noise.
    """
    terms = settle(default_model(), observations, catalogue([]))
    base = fit(terms, observations)
    alone = observations
    if observations.capture is not None:
        shown = shown_arcsec["capture"]
        if observations.used_capture_rows is not None:
            shown = shown[observations.used_capture_rows]
        rows = replace(observations.capture, difference_arcsec=shown)
        alone = replace(alone, capture=rows)
    if observations.reference is not None:
        compared = shown_arcsec["reference"]
        if observations.used_reference_rows is not None:
            compared = compared[observations.used_reference_rows]
        compared = compared - compared.mean()
        alone = replace(alone, reference=replace(observations.reference, error_arcsec=compared))
    sigma = (noise_arcsec.get("capture"), noise_arcsec.get("reference"))
    absorbed = solve(
        terms,
        alone,
        base.context,
        capture=capture_sums(terms, alone, base.context),
        reference=reference_sums(terms, alone, base.context),
        fixed_sigma=sigma,
    )
    left = Residuals(absorbed)
    # Offsets of the runs absorb too, but at the price of the index's own scatter.
    offsets = absorbed.run_offsets_arcsec
    total = float(np.sum(offsets**2)) / observations.index_sigma_arcsec**2
    largest = float(np.sqrt(np.mean(offsets**2))) if offsets.size else 0.0
    for values, error in ((left.capture_arcsec, sigma[0]), (left.reference_arcsec, sigma[1])):
        if values is not None and error is not None:
            total += float(np.sum(values**2)) / error**2
            largest = max(largest, float(np.sqrt(np.mean(values**2))))
    return total, largest


def judged(truth: dict[str, Any], found: Diagnosis, visible: bool) -> str:
    """One of OUTCOMES."""
    parts = _parts(found)
    hidden = [item["effect"] for item in truth["effects"]]
    if found.verdict == "bad_data":
        return "bad data"
    if found.verdict == "adequate":
        return "falsely adequate" if visible else "adequate, rightly"
    if found.verdict == "named":
        assert found.named is not None
        return "right" if found.named.name in hidden else "false name"
    if found.verdict == "ambiguous":
        if any(name in found.effect_class for name in hidden):
            return "first in class" if found.effect_class[0] in hidden else "in class"
        if any(set(item["parts"]) == set(parts) for item in truth["effects"] if item["parts"]):
            # Said beside the class, as it has no name.
            return "in class"
        return "class without it" if hidden else "false name"
    strangers = [item for item in truth["effects"] if not item["in_catalogue"]]
    if not strangers:
        # Two at once may be neither, to a diagnosis that looks for one.
        return "unknown, wrongly"
    if any(set(item["parts"]) == set(parts) for item in strangers):
        return "unknown, rightly"
    return "unknown, wrong parts"


def _held_out(
    names: Sequence[str], found: Diagnosis, floor_arcsec: dict[str, float]
) -> dict[str, tuple[float, float]]:
    chosen = found.named
    if found.verdict == "unknown":
        chosen = found.described
    before = found.held_out_before
    after = before if chosen is None else chosen.held_out
    if before is None or after is None:
        return {}
    ratios = {}
    for channel, floor in floor_arcsec.items():
        if channel == "reference" and "vibration" in names:
            # A head that shakes while a station is read scatters it: no model can take that.
            continue
        old = getattr(before, f"{channel}_rms_arcsec")
        new = getattr(after, f"{channel}_rms_arcsec")
        if old is not None and new is not None:
            ratios[channel] = (old / floor, new / floor)
    return ratios


def is_stranger(case: Case) -> bool:
    """A cause of it is in no catalogue."""
    return any(not RECIPES[name].in_catalogue for name in case.names)
