"""arctrue export: writes a fitted model as coefficients of the gateware or as a table for a
controller."""

from __future__ import annotations

from dataclasses import asdict, replace
from pathlib import Path

import click

from arctrue.base.figures import figure
from arctrue.calibration.calibration import objections
from arctrue.cli._controller_table import write_controller_table
from arctrue.cli._export_printed import print_export
from arctrue.cli._loaded_set import (
    LoadedSet,
    common_options,
    console,
    for_people,
    load,
    set_argument,
    write_json,
)
from arctrue.cli._numbers import Finite
from arctrue.cli._options import lanes_option, refuse_given
from arctrue.cli._outputs import OutputFile
from arctrue.cli._progress import Progress
from arctrue.cli._refused import end_unless_written, may_write
from arctrue.cli._table_of_mean import write_table_of_mean
from arctrue.gateware.coefficient_file import write_coefficient_file
from arctrue.gateware.phase_sources import with_phase_from_heads, with_phase_from_probe
from arctrue.gateware.thermal import TIME_CONSTANT_MOST_S
from arctrue.generated.number_formats import CLOCK_HZ, THERMAL_RANGE_K
from arctrue.metrology.controllers import FORMATS
from arctrue.metrology.correction import Correction
from arctrue.workbench.model.export import export_model
from arctrue.workbench.model.followed_lanes import USUAL_REVERSAL_WIDTH_DEG, ConditionSettings
from arctrue.workbench.model.growth import fitted
from arctrue.workbench.model.model import Model
from arctrue.workbench.model.sensor_lag import fitted_sensor_lag, set_without_lag
from arctrue.workbench.model.stations import model_of_stations, require_whole_turn
from arctrue.workbench.model.taken_away import outcome, without_reference_errors
from arctrue.workbench.observations.build import observations_of

GATEWARE = "gateware"


_OF_GATEWARE = (
    "lanes", "sensor_lag", "range_c", "modulators", "reversal_width", "local_table", "mean_file",
    "real_orders", "phase_from", "probe",
)  # fmt: skip
"""Options that do not apply to a table for another controller."""
_NOT_OF_MEAN = (
    "json_file", "lanes", "temperature", "sensor_lag", "fit_sensor_lag", "range_c", "modulators",
    "reversal_width", "real_orders", "phase_from", "probe", "force",
)  # fmt: skip
"""Options that do not apply to the local table of a mean of heads."""


@click.command("export", short_help="Write a model for the gateware or another controller.")
@set_argument
@common_options
@click.option(
    "--format",
    "table_format",
    type=click.Choice([GATEWARE, *FORMATS]),
    default=GATEWARE,
    show_default=True,
    metavar="FORMAT",
    help="gateware: coefficients of the gateware. For another controller a table: "
    + ", ".join(FORMATS)
    + ".",
)
@click.option(
    "--points",
    type=click.IntRange(min=3),
    help="Number of steps of a table over a turn.  [default: as the controller needs it]",
)
@click.option(
    "--steps-per-second",
    type=Finite(min=1.0, max=1e6),
    help="With --format onstep: motor steps in a sidereal second, the mount's answer to :VS#.",
)
@lanes_option()
@click.option(
    "--temperature",
    type=Finite(),
    help="Temperature in °C, for effects that depend on it.  [default: the device follows its "
    "thermometer]",
)
@click.option(
    "--sensor-lag",
    type=Finite(min=0.0, max=TIME_CONSTANT_MOST_S),
    default=0.0,
    show_default=True,
    help="Time constant in seconds by which the thermometer lags behind the disc.",
)
@click.option(
    "--fit-sensor-lag",
    is_flag=True,
    help="Fit the time constant of --sensor-lag to SET, remove this lag from the temperatures, and "
    "fit the model to the result.",
)
@click.option(
    "--temperatures",
    "range_c",
    type=(Finite(min=-273.15), Finite(max=1000.0)),
    help="Lowest and highest temperature in °C that the lanes follow.  [default: "
    f"{THERMAL_RANGE_K} K on each side of the set's reference temperature, and every temperature "
    "in SET]",
)
@click.option(
    "--modulators",
    is_flag=True,
    help="For a gateware built with MODULATORS = true: errors that depend on direction, speed or "
    "a further column of SET, such as reversal error and latency, become lanes that follow this "
    "condition.",
)
@click.option(
    "--reversal-width",
    type=Finite(min=1e-3, max=20.0),
    help="With --modulators: half of the angle, in degrees, over which the correction changes "
    f"after a reversal. Default: as the model's hysteresis, or {USUAL_REVERSAL_WIDTH_DEG:g}.",
)
@click.option(
    "--local-table",
    is_flag=True,
    help="For a gateware built with LOCAL_TABLE = true: errors at one place of the turn, such as "
    "a scratch, are written into the local table.",
)
@click.option(
    "--mean",
    "mean_file",
    type=click.Path(path_type=Path),
    help="With --local-table: coefficient file of a mean of heads, written by arctrue calibrate "
    "--angle mean. The output is this file with a local table, which corrects the scratch where "
    "it passes each of the heads.",
)
@click.option(
    "--real-orders",
    is_flag=True,
    help="For a gateware built with REAL_ORDERS = true: harmonics whose order is not an "
    "integer (a belt, a gear of 71.4 teeth) become lanes whose phase continues from turn to turn. "
    "The file states their phase in the turn that begins at the zero of SET.",
)
@click.option(
    "--phase-from",
    type=click.Choice(["heads", "probe"]),
    help="With --real-orders: signal from which the device determines the phase of these lanes. "
    "heads: the difference of two heads, for errors that turn with the disc; probe: an index of "
    "the drive at probe_in.  [default: the operator enters the phase]",
)
@click.option(
    "--probe",
    type=(Finite(), Finite(min=1e-6)),
    metavar="DEGREES RATIO",
    help="With --phase-from probe: angle of the table in SET, counted over all turns, at which an "
    "index pulse of the drive occurred, and number of these pulses per turn of the table.",
)
@click.option(
    "--coefficients",
    "coefficient_file",
    type=OutputFile(),
    help="File to write.  [default: coefficients.toml, or a name by the format]",
)
@click.option(
    "--force",
    is_flag=True,
    help="Write the file even if it increases the error of the reference run, or if the firmware "
    "would refuse it.",
)
@for_people
def export(
    measurement_set: Path,
    model_file: Path | None,
    folders: tuple[Path, ...],
    json_file: Path | None,
    out: Path | None,
    seed: int,
    table_format: str,
    points: int | None,
    steps_per_second: float | None,
    lanes: int,
    temperature: float | None,
    sensor_lag: float,
    fit_sensor_lag: bool,
    range_c: tuple[float, float] | None,
    modulators: bool,
    reversal_width: float | None,
    local_table: bool,
    mean_file: Path | None,
    real_orders: bool,
    phase_from: str | None,
    probe: tuple[float, float] | None,
    coefficient_file: Path | None,
    force: bool,
) -> None:
    """Write the model as coefficients of the gateware, or as a table for another controller.

    For each effect of the model the command prints the part of the gateware that corrects it, and
    the remaining error, which excludes errors of the reference. If an effect has no values, the
    command first fits the model to SET; a reference run is enough for this. With --out the file
    goes into that folder. Exit code 1: the file is not written, because it would increase the error
    of SET or the firmware would refuse it (--force writes it).
    """
    if table_format == GATEWARE and points is not None:
        raise ValueError("--points: the gateware takes orders, not points; choose a --format")
    if table_format == GATEWARE and steps_per_second is not None:
        raise ValueError("--steps-per-second: expected with --format onstep only")
    if mean_file is not None and not local_table:
        raise ValueError("--mean: expected with --local-table only")
    if (phase_from == "probe") != (probe is not None):
        raise ValueError("--phase-from probe and --probe: expected both or none")
    if phase_from is not None and not real_orders:
        raise ValueError("--phase-from: expected with --real-orders only")
    if table_format != GATEWARE:
        refuse_given(_OF_GATEWARE, f"is for the gateware; --format {table_format} is a table")
        FORMATS[table_format].check_points(points)
    if mean_file is not None:
        refuse_given(_NOT_OF_MEAN, "does not apply to --mean, which only adds a table to its file")
    if temperature is not None:
        refuse_given(
            ("range_c", "sensor_lag"),
            "is for lanes that follow the thermometer; --temperature fixes the lanes",
        )
    if not modulators:
        refuse_given(("reversal_width",), "is for lanes that follow a condition: give --modulators")
    if range_c is not None and range_c[0] >= range_c[1]:
        raise ValueError(
            f"--temperatures: expected the lowest temperature first, found {range_c[0]:g} and "
            f"{range_c[1]:g} °C"
        )
    loaded = load(measurement_set, model_file, folders)
    model = loaded.model
    reference = loaded.observations.every_reference_row
    if model_file is None and loaded.observations.capture is None and reference is not None:
        model = model_of_stations(reference)
    elif model_file is None:
        require_whole_turn(loaded.observations)
    if not all(entry.coefficients for entry in model.effects):
        with Progress("fitting"):
            model, _ = fitted(model, loaded.observations, loaded.effects)
    if fit_sensor_lag:
        if sensor_lag:
            raise ValueError("either --sensor-lag or --fit-sensor-lag: the lag is stated or fitted")
        model, loaded, sensor_lag = _with_fitted_lag(model, loaded)
    if table_format != GATEWARE:
        form = FORMATS[table_format].for_axis(
            loaded.observations.drive_gear_teeth, steps_per_second
        )
        correction = form.part_of(
            Correction.of_model(
                model, loaded.observations, loaded.effects, temperature_c=temperature
            )
        )
        path = _path(coefficient_file or Path(form.file_name), out)
        judged = without_reference_errors(
            loaded.measurement_set, model, loaded.observations, loaded.effects
        )
        loaded = replace(loaded, measurement_set=judged)
        write_controller_table(
            loaded, correction, form, points or form.points, path, json_file, force=force
        )
        return
    path = _path(coefficient_file or Path("coefficients.toml"), out)
    if mean_file is not None:
        write_table_of_mean(model, loaded, mean_file, path)
        return
    captured = loaded.measurement_set.capture
    clock_hz = (captured.clock_hz if captured is not None else None) or float(CLOCK_HZ)
    result = export_model(
        model,
        loaded.observations,
        loaded.effects,
        lanes=lanes,
        temperature_c=temperature,
        sensor_time_constant_s=sensor_lag,
        range_c=range_c,
        conditions=ConditionSettings(reversal_width, clock_hz=clock_hz) if modulators else None,
        with_local_table=local_table,
        with_real_orders=real_orders,
    )
    if phase_from is not None:
        held = result.coefficients
        held = (
            with_phase_from_probe(held, probe[0] / 360.0, probe[1])
            if probe is not None
            else with_phase_from_heads(held)
        )
        result = replace(result, coefficients=held)
    became = outcome(
        model, loaded.observations, loaded.effects, result.coefficients, temperature_c=temperature
    )
    judged = without_reference_errors(
        loaded.measurement_set, model, loaded.observations, loaded.effects
    )
    refused = objections(judged, result.coefficients)
    written = may_write(result.warnings, refused, force=force)
    if written:
        path.parent.mkdir(parents=True, exist_ok=True)
        # The file also contains the scale of the words that the host writes; the gateware does not
        # need this scale.
        title = "; ".join([loaded.measurement, *result.scales])
        write_coefficient_file(path, result.coefficients, title=title)
    print_export(result, became, lanes)
    if written:
        console.print(f"wrote {path}")
    write_json(
        json_file,
        {
            "schema": 1,
            "file": str(path) if written else None,
            "refused": refused,
            "lanes": [
                {"order": order, "amplitude_arcsec": amplitude}
                for order, amplitude in zip(result.orders, result.amplitudes_arcsec, strict=True)
            ],
            "followed": result.followed,
            "local_table": result.local,
            "real_orders": result.real,
            "not_corrected": result.left_out,
            "effects": [asdict(item) for item in became.effects],
            "left_arcsec": became.left_arcsec,
        },
    )
    end_unless_written(path, written=written)


def _with_fitted_lag(model: Model, loaded: LoadedSet) -> tuple[Model, LoadedSet, float]:
    """Return the model and the set for the table's temperature, and the lag of the thermometer in
    seconds; if the set shows no lag, return model and set unchanged, and 0."""
    with Progress("fitting the thermometer's lag"):
        lag = fitted_sensor_lag(model, loaded.observations, loaded.effects)
        measured = f"{figure(lag.value, 3)} s ± {figure(lag.sigma, 2)} s"
        if lag.value < 2.0 * lag.sigma:
            console.print(f"the set shows no lag of the thermometer: {measured}")
            return model, loaded, 0.0
        measurement = set_without_lag(loaded.measurement_set, lag.value)
        observations = observations_of(
            measurement, reference_temperature_c=loaded.observations.reference_temperature_c
        )
        model, _ = fitted(model, observations, loaded.effects)
    console.print(f"the thermometer lags by {measured}")
    return model, replace(loaded, observations=observations, measurement_set=measurement), lag.value


def _path(file: Path, out: Path | None) -> Path:
    """Return the path to write: ``file``, or its name in the folder ``out``."""
    return file if out is None else out / file.name
