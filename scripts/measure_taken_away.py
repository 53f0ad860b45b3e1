"""Measures on simulated tables which part of the system corrects each effect, and which error
remains.

Each effect is simulated alone on a table with an eccentric disc, recorded as a measurement set with
noise, and fitted with and without the effect in the model. Both models are exported. The lanes are
compared with the true error of head 1 on two other turns ("judged turns"), one up and one down, at
a temperature that was never measured. The true error comes from the table's geometry and not from
any model. An effect whose file declares ``modulators`` is exported for a gateware with MODULATORS.
Direction and speed are constant in each judged turn; the Python model of ``amplitude_sweep``
multiplies each lane's amplitude by the direction or by the speed. The harmonic that the effect
periodic_error finds is exported for a gateware with REAL_ORDERS. The effects of OF_THE_MEAN are
also simulated on a table with four heads, whose weighted mean is calibrated from the same runs.

Run ``python -m scripts.measure_taken_away``, which takes some minutes. The script writes
docs/data/taken_away.json, from which ``python -m scripts.make_effects_page`` makes docs/effects.md.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from arctrue.base.units import ARCSEC_PER_RAD
from arctrue.base.whole_file import write_whole_text
from arctrue.calibration.heads_calibration import calibrate_mean
from arctrue.gateware.amplitude_sweep import Modulators, modulated
from arctrue.gateware.coefficients import Coefficients
from arctrue.gateware.mean_set import OFFSET_ONE, WEIGHT_ONE
from arctrue.gateware.table_conditions import MODULATOR_ONE
from arctrue.generated.number_formats import LANES_DEFAULT
from arctrue.report.taken_away_table import STORED, stored
from arctrue.studies.revolution import FOUR_PLACES_DEG
from arctrue.studies.simulate.experiment import (
    SLOW_RAD_S,
    Experiment,
    MovingReference,
    short,
)
from arctrue.studies.simulate.simulated_set import SimulatedSet, Wanted, simulate_set
from arctrue.table.conditions import USUAL_TEMPERATURE_C, Conditions
from arctrue.table.registry import REGISTRY
from arctrue.table.rotary_table import RotaryTable
from arctrue.workbench.effects.registry import built_in
from arctrue.workbench.model.export import export_model
from arctrue.workbench.model.followed_lanes import ConditionSettings
from arctrue.workbench.model.growth import fitted
from arctrue.workbench.model.local_errors import taken_off_arcsec
from arctrue.workbench.model.model import Model, ModelEffect, default_model
from arctrue.workbench.model.taken_away import outcome
from arctrue.workbench.observations.build import observations_of

Float = NDArray[np.float64]

SEED = 13
FRESH_C = USUAL_TEMPERATURE_C + 2.2
"""Temperature of the two judged turns, on which the lanes are compared with the true error; it lies
between the temperatures of the set's runs."""
ROWS = 20_000
"""Number of rows of the judged turns; their angles are random, so that no order is an alias of
another order."""
DENSE_STATIONS = 4096
"""Number of stations per turn of a reference that is read while the table moves."""
SIMULATED_BY = {"graduation_harmonics": None, "periodic_error": "drive_gear_error"}
"""Name of the recipe that simulates an effect, if it differs from the effect's name; None: every
table has the effect."""

SETTINGS: dict[str, dict[str, object]] = {
    "drive_gear_error": {"multiples": [1], "below": [1], "above": [1]}
}
"""Settings of an effect in the model: the simulated gear is eccentric, which causes the orders next
to the tooth count."""

OF_THE_MEAN = ("radial_error_motion", "bearing_ball_pass", "thermal_eccentricity")
"""Effects that move the axis or the disc's centre: the weighted mean of the heads does not contain
them."""


def measured_effects() -> list[str]:
    """Return the names of the effects that a simulated table can have; an effect of a mount's
    second axis is not among them."""
    return [name for name in built_in() if name in SIMULATED_BY or name in REGISTRY]


@dataclass(frozen=True, slots=True)
class Measured:
    """Result for one effect: RMS errors about the mean at the output in the judged turns, in
    arcseconds."""

    effect: str
    simulated: str
    """Size and unit of the cause."""
    part_arcsec: float
    """RMS of the error that the cause adds to head 1; for the effect of the disc itself, RMS of the
    whole error."""
    left_without_arcsec: float
    """Error that remains after the lanes of a model without the effect."""
    left_with_arcsec: float
    """Error that remains after the lanes of a model with the effect."""
    taken_away_by: str
    """Part of the system that corrects the effect, as the export states."""
    left_in_mean_arcsec: float | None = None
    """Error that remains in the calibrated weighted mean of four heads; None: not measured."""

    def data(self) -> dict[str, Any]:
        """Return the measured results as values for JSON, rounded to a thousandth of an
        arcsecond."""
        return {
            key: round(value, 3) if isinstance(value, float) else value
            for key, value in asdict(self).items()
            if value is not None
        }


def measure(name: str, seed: int = SEED) -> Measured:
    """Measure one effect of the catalogue. Raises KeyError for a name that is not in the
    catalogue."""
    cause = SIMULATED_BY.get(name, name)
    experiment = _experiment(name)
    plain = simulate_set([], experiment, seed)
    if cause is None:
        made, simulated = plain, "eccentric disc, orders 2 to 8"
    else:
        recipe = REGISTRY[cause]
        made = simulate_set([Wanted(cause, recipe.high)], experiment, seed)
        simulated = f"{recipe.high:g} {recipe.unit}"
    fresh = _fresh_turns(seed)
    error = _error_arcsec(made.table, fresh)
    part = error if cause is None else error - _error_arcsec(plain.table, fresh)
    base = default_model()
    grown = base
    if name not in {entry.name for entry in base.effects}:
        added = ModelEffect(name, SETTINGS.get(name, {}))
        grown = replace(base, effects=[*base.effects, added])
    else:
        base = replace(base, effects=[entry for entry in base.effects if entry.name != name])
    without, _ = _left(base, made, fresh, error, name)
    left, by = _left(grown, made, fresh, error, name)
    in_mean = left_in_mean_arcsec(name, fresh, seed) if name in OF_THE_MEAN else None
    return Measured(name, simulated, float(part.std()), without, left, by, in_mean)


def left_in_mean_arcsec(name: str, fresh: Conditions, seed: int = SEED) -> float:
    """Calibrate the weighted mean of a table with four heads and the effect ``name``; return the
    RMS error of this mean in the judged turns."""
    wanted = Wanted(name, REGISTRY[name].high)
    made = simulate_set([wanted], _experiment(name), seed, head_places_deg=FOUR_PLACES_DEG)
    coefficients = calibrate_mean(made.measurement).coefficients
    assert coefficients.extension is not None
    mean = coefficients.extension.mean
    assert mean is not None
    readings = np.stack([made.table.reading_rad(head, fresh) for head in range(mean.heads)])
    after_index = readings / made.table.count_rad - np.array(mean.offsets)[:, None] / OFFSET_ONE
    output = np.array(mean.weights) / WEIGHT_ONE @ after_index
    output -= coefficients.error_counts(after_index[mean.carrier - 1])
    return float(((output * made.table.count_rad - fresh.angle_rad) * ARCSEC_PER_RAD).std())


def _experiment(name: str) -> Experiment:
    """Return an experiment with runs up, down, fast and warm, and a polygon; for periodic_error,
    the reference is read while the table moves, at 4096 stations per turn, because the order is
    high."""
    experiment = short()
    if name != "periodic_error":
        return experiment
    assert experiment.reference is not None
    moving = MovingReference((SLOW_RAD_S, -SLOW_RAD_S), DENSE_STATIONS)
    return replace(experiment, reference=replace(experiment.reference, moving=moving))


def _fresh_turns(seed: int) -> Conditions:
    """Return the conditions of the two judged turns, one up and one down."""
    random = np.random.default_rng([seed, ROWS])
    angle = np.sort(random.uniform(0.0, 2.0 * np.pi, (2, ROWS // 2)), axis=1)
    angle[1] = angle[1][::-1]
    direction = np.repeat([1.0, -1.0], ROWS // 2)
    travelled = np.concatenate([angle[0], 4.0 * np.pi - angle[1]])
    return Conditions(
        time_s=travelled / SLOW_RAD_S,
        angle_rad=angle.ravel(),
        speed_rad_s=direction * SLOW_RAD_S,
        temperature_c=np.full(ROWS, FRESH_C),
        direction=direction,
        run=np.zeros(ROWS, dtype=np.int64),
        since_run_start_s=travelled / SLOW_RAD_S,
        travelled_rad=travelled,
    )


def _error_arcsec(table: RotaryTable, fresh: Conditions) -> Float:
    """Return the error of head 1 in the judged turns, minus its mean, because the mean depends on
    the place of the zero."""
    error = (table.reading_rad(0, fresh) - fresh.angle_rad) * ARCSEC_PER_RAD
    return np.asarray(error - error.mean())


def _left(
    model: Model, made: SimulatedSet, fresh: Conditions, error_arcsec: Float, name: str
) -> tuple[float, str]:
    """Return the RMS error after the correction by the exported model, and the part that corrects
    ``name``."""
    if not model.effects:
        return float(error_arcsec.std()), ""
    observations, effects = observations_of(made.measurement), built_in()
    model, _ = fitted(model, observations, effects)
    follows = effects[name].compensation == "modulators"
    export = export_model(
        model,
        observations,
        effects,
        lanes=LANES_DEFAULT,
        temperature_c=None,
        conditions=ConditionSettings() if follows else None,
        with_local_table=effects[name].compensation == "local_table",
        with_real_orders=name == "periodic_error",
    ).coefficients
    counts = made.table.reading_rad(0, fresh) / made.table.count_rad
    correction = _correction_counts(export, counts, fresh)
    left = error_arcsec - correction * made.table.count_rad * ARCSEC_PER_RAD
    if export.extension is not None and export.extension.local_table is not None:
        reading_rad = counts * made.table.count_rad
        left -= taken_off_arcsec(export.extension.local_table, export.counts_per_rev, reading_rad)
    became = outcome(model, observations, effects, export, temperature_c=None)
    by = next((item.by for item in became.effects if item.effect == name), "")
    return float(left.std()), by


def _correction_counts(export: Coefficients, counts: Float, fresh: Conditions) -> Float:
    """Return the correction in counts for each row of ``fresh``; the amplitudes are those for the
    direction and speed of this row."""
    warm = export.at(FRESH_C)
    if export.extension is None or export.extension.conditions is None:
        return warm.error_counts(counts)
    nominal_rad_s = np.radians(export.extension.conditions.nominal_deg_per_s)
    total = np.zeros(counts.size)
    for speed_rad_s in np.unique(fresh.speed_rad_s):
        share = float(np.clip(speed_rad_s / nominal_rad_s, -1.0, 1.0))
        bank = modulated(
            warm,
            Modulators(int(np.sign(share)) * MODULATOR_ONE, round(share * MODULATOR_ONE)),
        )
        rows = fresh.speed_rad_s == speed_rad_s
        total[rows] = bank.error_counts(counts[rows])
    return total


def main(arguments: Sequence[str] | None = None) -> int:
    """Measure the effects that the command line names, or all effects; return the exit code."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("effects", nargs="*", help="measure these alone", metavar="EFFECT")
    chosen = parser.parse_args(arguments).effects
    unknown = sorted(set(chosen) - set(measured_effects()))
    if unknown:
        parser.error(
            f"no simulated table has the effect {unknown[0]}; possible effects: "
            f"{', '.join(measured_effects())}"
        )
    rows = stored()["effects"] if chosen and STORED.exists() else {}
    for name in chosen or measured_effects():
        row = measure(name).data()
        del row["effect"]
        rows[name] = row
        print(name, row, flush=True)
    ordered = {name: rows[name] for name in measured_effects() if name in rows}
    found = {"schema": 1, "seed": SEED, "temperature_c": FRESH_C, "effects": ordered}
    write_whole_text(STORED, json.dumps(found, indent=1, ensure_ascii=False) + "\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
