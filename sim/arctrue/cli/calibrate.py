"""``arctrue calibrate SET``: computes the gateware's coefficients from two to four heads or from a
reference run."""

from __future__ import annotations

import math
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, NoReturn

import click
import numpy as np

from arctrue.base.extras import MissingExtraError, needs_extras
from arctrue.base.figures import figure
from arctrue.base.json_text import json_text
from arctrue.base.units import ARCSEC_PER_RAD
from arctrue.base.whole_file import write_whole_text
from arctrue.calibration import calibration as calibration_module
from arctrue.calibration.calibration import METHODS, Calibration, CalibrationSettings
from arctrue.calibration.capture_check import CaptureRefusedError
from arctrue.calibration.comparison import Extent, ReferenceComparison, extent
from arctrue.calibration.head_separation import Separation
from arctrue.calibration.heads_calibration import MeanCalibration, MeanSettings, calibrate_mean
from arctrue.calibration.selection import GAIN_LIMIT_DEFAULT
from arctrue.cli._mean_of_heads import figures as figures_of_mean
from arctrue.cli._mean_of_heads import motion_orders, print_mean
from arctrue.cli._numbers import Finite
from arctrue.cli._options import lanes_option, refuse_given
from arctrue.cli._outputs import OutputFile, OutputFolder
from arctrue.cli._reference_alone import ReferenceCalibration, calibrate_from_reference
from arctrue.cli._refused import NOT_WRITTEN
from arctrue.cli._tables import number, table, words
from arctrue.cli._terminal import Console, say, tell_error, tell_objection, tell_warning
from arctrue.gateware.coefficient_file import write_coefficient_file
from arctrue.measurement import MeasurementError, MeasurementSet, read_measurement_set

if TYPE_CHECKING:
    from arctrue.report.charts.chart import Chart

BAD_INPUT = 2
REFUSED = 3
_REFUSED_FAULTS = ("not_a_number", "empty")


class _ManyRuns(click.Command):
    """A command on whose command line ``--run 0 1 3`` means ``--run 0 --run 1 --run 3``."""

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        expanded: list[str] = []
        many = False
        for word in args:
            many = many and word.isdecimal()
            if many and expanded[-1] != "--run":
                expanded.append("--run")
            expanded.append(word)
            many = many or word == "--run"
        return super().parse_args(ctx, expanded)


@click.command(cls=_ManyRuns, short_help="Calibrate from a capture; compare with a reference.")
@click.argument("folder", metavar="SET", type=click.Path(path_type=Path))
@click.option(
    "--method",
    type=click.Choice(list(METHODS)),
    default="least_squares",
    show_default=True,
    help="least_squares fits at the measured angles; fourier is the paper's transform, which "
    "assumes equal steps.",
)
@click.option(
    "--run",
    "runs",
    metavar="N…",
    type=int,
    multiple=True,
    help="Runs to use.  [default: all at the lowest speed]",
)
@click.option(
    "--orders",
    "most_order",
    type=click.IntRange(1, 1000),
    default=CalibrationSettings().most_order,
    show_default=True,
    help="Fit the orders from 1 to this one.",
)
@lanes_option()
@click.option(
    "--gain-limit",
    type=Finite(min=0.0, min_open=True),
    default=GAIN_LIMIT_DEFAULT,
    show_default=True,
    help="Largest noise gain of an order that is applied.",
)
@click.option(
    "--head-separation",
    "separation",
    type=click.Choice(["measured", "nominal", "harmonics"]),
    help="Source of the angle between the heads: index pulses (measured), nominal value, or "
    "harmonics of the reference run.  [default: measured; nominal if the index is implausible or "
    "less certain; harmonics if their uncertainty is the smallest]",
)
@click.option(
    "--angle",
    type=click.Choice(["head1", "mean"]),
    default="head1",
    show_default=True,
    help="Angle at the gateware's output. head1: head 1, corrected from heads 1 and 2. mean: "
    "the weighted mean of all heads, which contains no translation of the axis.",
)
@click.option(
    "--motion",
    metavar="ORDERS",
    help="With --angle mean: orders at which the axis may move: a list (1-8 or 2,3,9), "
    "none, or every.  [default: every with four heads, otherwise none]",
)
@click.option(
    "--force",
    is_flag=True,
    help="Write the coefficients even if they increase the error of the reference run, or if "
    "the firmware would refuse them.",
)
@click.option(
    "--json",
    "json_file",
    type=OutputFile(),
    help="Write the results as JSON.",
)
@click.option(
    "--out",
    type=OutputFolder(),
    help="Folder for coefficients.toml and calibration.png.  [default: build/calibration/NAME]",
)
def calibrate(
    folder: Path,
    method: Any,
    runs: tuple[int, ...],
    most_order: int,
    lanes: int,
    gain_limit: float,
    separation: Any,
    angle: str,
    motion: str | None,
    force: bool,
    json_file: Path | None,
    out: Path | None,
) -> None:
    """Calibrate from the capture of the measurement set SET, or from its reference run alone.

    For a set without a capture, the command fits the orders from 1 to the highest one that the
    spacing of the reference targets determines, at most to --orders. It refuses options that
    concern two heads.

    --angle mean calibrates the weighted mean of all heads of a set with head_places_deg and writes
    the coefficients of the mean, with a further coefficient set for each head that may fail.

    The command prints the orders and, if SET has a reference run, the error before and after the
    correction by the bit-true gateware. Exit code 1: the coefficients are refused (--force writes
    them); 2: the set or an option is wrong; 3: the capture cannot be used. In each of these cases
    an earlier coefficient file stays as it is.
    """
    settings = CalibrationSettings(method, runs or None, most_order, lanes, gain_limit, separation)
    try:
        measurement = read_measurement_set(folder)
        name = folder.resolve().name
        out = out or Path("build") / "calibration" / name
        results = _Results(measurement.title or name, json_file, out, force)
        if measurement.capture is None:
            _refuse_options_of_two_heads()
            alone = calibrate_from_reference(measurement, lanes=lanes, most_order=most_order)
            _finish_alone(alone, results)
            return
        if angle == "mean":
            refuse_given(_OF_HEAD1, "is for --angle head1")
            settings_of_mean = MeanSettings(runs or None, most_order, lanes, motion_orders(motion))
            mean = calibrate_mean(measurement, settings_of_mean)
            _finish_mean(mean, measurement, results)
            return
        if motion is not None:
            raise ValueError(
                "--motion is for --angle mean: the calibration of head 1 attributes "
                "all motion to the disc"
            )
        calibration = calibration_module.calibrate(measurement, settings)
    except CaptureRefusedError as refusal:
        _end(REFUSED, f"refused ({refusal.reason}): {refusal}")
    except MeasurementError as error:
        of_capture = error.file.name == _capture_name(folder)
        if of_capture and error.fault in _REFUSED_FAULTS:
            _end(REFUSED, f"refused ({error.fault}): {error}")
        _end(BAD_INPUT, str(error))
    except ValueError as error:
        _end(BAD_INPUT, f"{folder}: {error}")
    warnings = (*measurement.warnings, *calibration.warnings, *_further_heads(measurement))
    for warning in warnings:
        tell_warning(warning)
    console = _console()
    _print_summary(console, calibration, method)
    _print_orders(console, calibration)
    if calibration.comparison is not None:
        _print_comparison(console, calibration.comparison)

    def chart(title: str) -> Chart:
        from arctrue.report.charts.calibration_chart import calibration_chart

        return calibration_chart(calibration, title)

    results.write(_figures(calibration, method, warnings), calibration, chart)


@dataclass(frozen=True)
class _Results:
    """The files that the command writes."""

    title: str
    json_file: Path | None
    out: Path
    force: bool

    def write(
        self,
        figures: dict[str, Any],
        found: Calibration | MeanCalibration | ReferenceCalibration,
        chart: Callable[[str], Chart] | None = None,
    ) -> None:
        """Write figures, coefficients and picture; end the command if coefficients are refused."""
        coefficients, picture = self.out / "coefficients.toml", self.out / "calibration.png"

        def draw() -> None:
            # matplotlib is imported here, because its import takes longer than the calibration.
            from arctrue.report.charts.matplotlib_chart import save_chart

            assert chart is not None
            save_chart(chart(self.title), picture)

        try:
            if self.json_file is not None:
                write_whole_text(self.json_file, json_text(figures))
                say(f"Figures: {self.json_file}")
            _stop_if_refused(found.objections, self.out, force=self.force)
            write_coefficient_file(coefficients, found.coefficients, self.title)
            plotted = "" if chart is None else f"\n{_plotted(draw, picture)}"
            say(f"\nCoefficients: {coefficients}{plotted}")
        except OSError as error:
            _end(BAD_INPUT, f"{error.filename}: cannot be written: {error.strerror}")


_OF_HEAD1 = ("method", "gain_limit", "separation")
_OF_TWO_HEADS = (*_OF_HEAD1, "runs", "angle", "motion")


def _refuse_options_of_two_heads() -> None:
    refuse_given(_OF_TWO_HEADS, "is for two heads, and the set has no capture")


def _further_heads(measurement: MeasurementSet) -> list[str]:
    heads = 2 if measurement.capture is None else len(measurement.capture.heads)
    if heads == 2:
        return []
    return [
        f"the set has {heads} heads, and head 1 is calibrated from heads 1 and 2 alone; "
        "--angle mean uses all"
    ]


def _finish_mean(mean: MeanCalibration, measurement: MeasurementSet, results: _Results) -> None:
    for warning in (*measurement.warnings, *mean.warnings):
        tell_warning(warning)
    print_mean(_console(), mean)
    results.write(figures_of_mean(mean), mean)


def _finish_alone(alone: ReferenceCalibration, results: _Results) -> None:
    for warning in alone.warnings:
        tell_warning(warning)
    console = _console()
    alone.print_orders(console)
    _print_comparison(console, alone.comparison)

    def chart(title: str) -> Chart:
        from arctrue.report.charts.calibration_chart import reference_calibration_chart

        return reference_calibration_chart(alone.comparison, title)

    results.write(alone.figures(_before_and_after), alone, chart)


def _stop_if_refused(objections: Sequence[str], out: Path, *, force: bool) -> None:
    """Print the objections to the coefficients; end the command unless the user forces the
    coefficients."""
    for objection in objections:
        tell_objection(objection, forced=force)
    if objections and not force:
        _end(NOT_WRITTEN, f"no coefficients written to {out}; --force writes them")
    out.mkdir(parents=True, exist_ok=True)


def _before_and_after(comparison: ReferenceComparison | None) -> dict[str, Any]:
    if comparison is None:
        return {"before_arcsec": None, "after_arcsec": None}
    return {
        name: {"min": of.lowest, "max": of.highest, "rms": of.rms}
        for name, of in (
            ("before_arcsec", extent(comparison.before_arcsec)),
            ("after_arcsec", extent(comparison.after_arcsec)),
        )
    }


def _end(code: int, message: str) -> NoReturn:
    tell_error(str(message))
    sys.exit(code)


def _capture_name(folder: Path) -> str:
    from arctrue.measurement.description import read_description

    try:
        keys = read_description(folder).keys.capture
    except MeasurementError:
        keys = None
    return "capture.csv" if keys is None or keys.file is None else keys.file


def _console() -> Console:
    return Console(highlight=False)


def _print_summary(console: Console, calibration: Calibration, method: str) -> None:
    estimate = calibration.estimate
    parts = ", ".join(
        f"{p.run} ({p.turns} turn{'s' if p.turns > 1 else ''} "
        f"{'up' if p.step_counts > 0 else 'down'})"
        for p in calibration.turns
    )
    samples = sum(p.samples for p in calibration.turns)
    console.print(
        f"{method}: runs {parts}; {samples:,} samples, "
        f"{estimate.residual_rms_arcsec:.3f}″ RMS left in R₂ − R₁",
        soft_wrap=True,
    )
    of = calibration.separations
    nominal = of["nominal"]

    def stated(separation: Separation) -> str:
        if not math.isfinite(separation.u_rad):
            return f"not determined ({separation.note})"
        off = (separation.value_rad - nominal.value_rad) * ARCSEC_PER_RAD
        return f"{figure(off, 2, signed=True)}″ (u = {separation.u_rad * ARCSEC_PER_RAD:.2f}″)"

    console.print(
        f"head separation: {math.degrees(estimate.head_separation_rad):.6f}°, "
        f"{estimate.separation_choice} used. Deviation from the nominal "
        f"{math.degrees(nominal.value_rad):.6f}° (u = {nominal.u_rad * ARCSEC_PER_RAD:.2f}″): "
        f"measured by the index {stated(of['measured'])}, "
        f"from the harmonics of the reference {stated(of['harmonics'])}",
        soft_wrap=True,
    )


def _print_orders(console: Console, calibration: Calibration) -> None:
    estimate = calibration.estimate
    orders = table(
        "Orders of the error, as a function of the reading",
        *map(number, ("order", "amplitude\n″", "u ″", "phase °", "u °", "noise\ngain")),
        words("applied, or why not"),
    )
    u_phase = np.degrees(estimate.u_phase_rad)
    for i, verdict in enumerate(calibration.verdicts):
        seen = bool(np.isfinite(estimate.noise_gain[i]))
        reason = "applied" if verdict.applied else verdict.reason
        known = seen and u_phase[i] < 60.0
        orders.add_row(
            str(verdict.order),
            figure(estimate.amplitude_arcsec[i] if seen else None, 4),
            figure(estimate.u_amplitude_arcsec[i] if seen else None, 4),
            figure(math.degrees(estimate.phase_rad[i]) if known else None, 2),
            figure(u_phase[i] if known else None, 2),
            figure(estimate.noise_gain[i], 2) if seen else "∞",
            "; ".join([reason, *verdict.flags]),
            style="bold" if verdict.applied else "dim",
        )
    console.print()
    console.print(orders)


def _print_comparison(console: Console, comparison: ReferenceComparison) -> None:
    extents = table(
        "Error against the reference run, through the gateware, ″",
        words(),
        *map(number, ("min", "max", "peak to\npeak", "RMS", "rows")),
    )

    def row(name: str, of: Extent, rows: int) -> None:
        extents.add_row(
            name,
            *(figure(value, 3) for value in (of.lowest, of.highest, of.peak_to_peak, of.rms)),
            f"{rows:,}",
        )

    for name, values in (("before", comparison.before_arcsec), ("after", comparison.after_arcsec)):
        row(name, extent(values), values.size)
        if comparison.direction is not None:
            for sign, way in ((1, "up"), (-1, "down")):
                chosen = values[comparison.direction == sign]
                if chosen.size:
                    row(f"{name}, {way}", extent(chosen), chosen.size)
    if comparison.noise is not None:
        row("scatter of the reference's repeats", comparison.noise, comparison.target_deg.size)
    console.print()
    console.print(extents)


def _figures(calibration: Calibration, method: str, warnings: tuple[str, ...]) -> dict[str, Any]:
    estimate, comparison = calibration.estimate, calibration.comparison
    return {
        "method": method,
        "runs": [
            {
                "run": part.run,
                "turns": part.turns,
                "direction": 1 if part.step_counts > 0 else -1,
                "samples": part.samples,
                "residual_rms_arcsec": fit.residual_rms_arcsec,
                "head_separation_deg": math.degrees(fit.head_separation_rad),
            }
            for part, fit in zip(calibration.turns, estimate.runs, strict=True)
        ],
        "warnings": list(warnings),
        "refused": list(calibration.objections),
        "residual_rms_arcsec": estimate.residual_rms_arcsec,
        "alpha": {
            "value_deg": math.degrees(estimate.head_separation_rad),
            "u_arcsec": estimate.u_head_separation_rad * ARCSEC_PER_RAD,
            "from": estimate.separation_choice,
            "sources": {
                name: {
                    "value_deg": math.degrees(separation.value_rad),
                    "u_arcsec": separation.u_rad * ARCSEC_PER_RAD,
                    "note": separation.note,
                }
                for name, separation in calibration.separations.items()
            },
        },
        **_before_and_after(comparison),
        "head_separation_deg": math.degrees(estimate.measured_separation_rad),
        "u_head_separation_arcsec": estimate.u_measured_separation_rad * ARCSEC_PER_RAD,
        "orders": [
            {
                "order": verdict.order,
                "amplitude_arcsec": estimate.amplitude_arcsec[i],
                "phase_deg": math.degrees(estimate.phase_rad[i]),
                "u_amplitude_arcsec": estimate.u_amplitude_arcsec[i],
                "u_phase_deg": math.degrees(estimate.u_phase_rad[i]),
                "noise_gain": estimate.noise_gain[i],
                "applied": verdict.applied,
            }
            for i, verdict in enumerate(calibration.verdicts)
        ],
    }


def _plotted(draw: Callable[[], None], picture: Path) -> str:
    """Draw the plot and return a line with its path; if an extra is missing, return a line that
    names the extra."""
    try:
        with needs_extras():
            draw()
    except MissingExtraError as missing:
        return f"No plot: {missing}"
    return f"Plot: {picture}"
