"""arctrue certificate: writes a Digital Calibration Certificate of a set, and a page for
printing."""

from __future__ import annotations

import math
from datetime import UTC, datetime
from importlib.metadata import version
from pathlib import Path

import click
import numpy as np
from numpy.typing import NDArray

from arctrue.base.whole_file import write_whole_text
from arctrue.cli._loaded_set import console, effects_option, for_people, load, model_option
from arctrue.cli._numbers import Finite
from arctrue.cli._outputs import OutputFile
from arctrue.cli._progress import Progress
from arctrue.measurement import MeasurementSet
from arctrue.measurement.digest import set_digest
from arctrue.metrology.certificate import certified_error
from arctrue.metrology.certificate_details import CertificateDetails, read_details
from arctrue.workbench.model.stations import model_of_stations

FULL_TURN_DEG = 360.0
HEADS = {2: "two", 3: "three", 4: "four"}
"""Words for the number of read heads in the description of the method."""


@click.command("certificate", short_help="Write a Digital Calibration Certificate (DCC) of a set.")
@click.argument("measurement_set", metavar="SET", type=click.Path(path_type=Path))
@click.option(
    "--details",
    "details_file",
    type=click.Path(path_type=Path, dir_okay=False),
    required=True,
    help="Item, laboratory, customer and persons (TOML).",
)
@click.option("--out", type=OutputFile(".xml"), required=True, help="File of the certificate.")
@click.option(
    "--step",
    type=Finite(min=0.1, max=180.0),
    default=15.0,
    show_default=True,
    help="Angle between two stated values, degrees.",
)
@click.option(
    "--direction",
    type=click.Choice(["1", "-1"]),
    help="Direction of motion of the stated errors, for a model with hysteresis.",
)
@click.option(
    "--temperature",
    type=Finite(),
    help="Temperature of the stated errors in °C, for a model that depends on it.",
)
@click.option(
    "--schema",
    "schema_file",
    type=click.Path(path_type=Path, dir_okay=False, exists=True),
    help="Official dcc.xsd for a check of the certificate. The schemas that dcc.xsd imports must "
    "be in the same folder.",
)
@model_option
@effects_option
@for_people
def certificate(
    measurement_set: Path,
    details_file: Path,
    out: Path,
    step: float,
    direction: str | None,
    temperature: float | None,
    schema_file: Path | None,
    model_file: Path | None,
    folders: tuple[Path, ...],
) -> None:
    """Write the certificate of SET: its error function with expanded uncertainty (k = 2).

    The command fits the model of --model to SET. Without --model it fits the paper's model or, for
    a reference run alone, the harmonics that the targets determine. Next to the XML file it writes
    a printable page (.html). All entries about item, laboratory and persons come from --details and
    SET: if one is missing, the command names it and writes no file.
    """
    if measurement_set.is_file():
        raise ValueError(
            f"{measurement_set}: is a file; a model alone has no covariance, which the uncertainty "
            f"needs. Give its measurement set: arctrue certificate SET --model {measurement_set}"
        )
    details = read_details(details_file)
    loaded = load(measurement_set, model_file, folders)
    measured = loaded.measurement_set
    if measured.date is None:
        raise ValueError(
            f"{measurement_set}: states no date; a certificate needs it. Add a line such as "
            "date = 2026-03-12 at the top of its measurement.toml"
        )
    temperature_c = _temperature(measured, details, details_file)
    conditions: dict[str, float] = {}
    if direction is not None:
        conditions["direction"] = float(direction)
    if temperature is not None:
        conditions["temperature_c"] = temperature
    model, stations = loaded.model, loaded.observations.every_reference_row
    if model_file is None and measured.capture is None and stations is not None:
        model = model_of_stations(stations)
    with Progress("fitting the set"):
        found = certified_error(
            measured,
            model,
            loaded.effects,
            angles_deg(step),
            conditions,
        )
    # matplotlib is imported here, because its import takes longer than everything else.
    from arctrue.report.certificate_page import certificate_page
    from arctrue.report.certificate_xml import CertificateFacts, certificate_xml

    facts = CertificateFacts(
        measured=measured.date.date(),
        issued=datetime.now(UTC).date(),
        sha256=set_digest(measurement_set),
        title=loaded.measurement,
        version=version("arctrue"),
        method=method_of(measured),
        temperature_c=temperature_c,
    )
    content = certificate_xml(found, details, facts)
    if schema_file is not None:
        from arctrue.report.certificate_check import check_schema

        check_schema(content, schema_file)
        console.print(f"{schema_file}: the certificate is valid", soft_wrap=True)
    write_whole_text(out, content.decode())
    page = out.with_suffix(".html")
    write_whole_text(page, certificate_page(found, details, facts))
    console.print(
        f"U (k = 2) from {found.expanded_arcsec.min():.4f}″ to {found.expanded_arcsec.max():.4f}″"
    )
    console.print(f"wrote {out} and {page}", soft_wrap=True)


def angles_deg(step: float) -> NDArray[np.float64]:
    """Return the multiples of ``step`` below a full turn, degrees.

    If the step divides the turn within rounding, 360° is omitted, because it is angle 0.
    """
    return np.asarray(step * np.arange(math.ceil(FULL_TURN_DEG / step - 1e-9)), dtype=np.float64)


def method_of(measured: MeasurementSet) -> str:
    """Return the description of the calibration method of a set."""
    ways = []
    if measured.capture is not None:
        heads = HEADS[len(measured.capture.heads)]
        ways.append(f"self-calibration with {heads} read heads")
    if measured.reference is not None:
        instrument = measured.reference.instrument
        ways.append("comparison with " + (instrument or "a reference"))
    return " and ".join(ways).capitalize() if len(ways) == 1 else " and ".join(ways)


def _temperature(measured: MeasurementSet, details: CertificateDetails, file: Path) -> float:
    """Return the mean of the recorded temperatures, or else the temperature in the file of details.

    Raises ValueError if there is neither.
    """
    rows = [
        part.temperature_c
        for part in (measured.capture, measured.reference)
        if part is not None and part.temperature_c is not None
    ]
    if rows:
        return float(np.mean(np.concatenate(rows)))
    if details.temperature_c is None:
        raise ValueError(
            f"{file}: temperature_c: is missing; the set records no temperature, and a certificate "
            "must state the temperature of the measurement"
        )
    return details.temperature_c
