"""Imports sets from files of other programs; exports models as gateware coefficients or as
tables."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace
from importlib.metadata import version
from pathlib import Path
from typing import Unpack

from arctrue.api.dataset import Dataset
from arctrue.api.fit import not_determined
from arctrue.api.keywords import Metadata, keys_of
from arctrue.api.model import ModelLike, model_of
from arctrue.api.sets import SetOrFolder, set_of
from arctrue.base.printable import one_line
from arctrue.base.whole_file import write_whole_text
from arctrue.calibration.calibration import objections
from arctrue.importing import Choices, ReadSettings, Settings
from arctrue.importing.questions import Import
from arctrue.measurement import Origin
from arctrue.measurement.date import moment
from arctrue.workbench.inference.directions import directions_of, undetermined_parameters
from arctrue.workbench.inference.solution import Solution
from arctrue.workbench.model.growth import as_stored, fitted

GATEWARE = "gateware"


class ExportRefusedError(ValueError):
    """Is raised if ``export`` finds reasons not to write a file; the text states the reasons."""


def import_files(
    files: Path | str | Iterable[Path | str],
    *,
    columns: Mapping[str, str] | None = None,
    units: Mapping[str, str] | None = None,
    reader: str = "",
    group: str = "",
    period_s: float | None = None,
    sign: str = "",
    zero: str = "",
    missing: str = "",
    order: str = "",
    **metadata: Unpack[Metadata],
) -> Dataset:
    """Make a set from files of other programs, as ``arctrue import`` does.

    Parameters
    ----------
    files : Path, str, or iterable of these
        Files with text in columns, JSON lines, NumPy, Parquet, HDF5 or MAT files, or logs of PHD2,
        LinuxCNC or EPICS.
    columns : mapping of str to str, optional
        Name of the column that contains a quantity, as for ``--column``.
    units : mapping of str to str, optional
        The unit of a quantity, as for ``--unit``.
    reader : str, optional
        Name of the reader, by default the reader that recognises the file, as for ``--format``.
    group : str, optional
        Group of an HDF5 file or variable of an EPICS log.
    period_s : float, optional
        Seconds between two rows, for files without a time.
    sign : {"reading-true", "true-reading"}, optional
        Meaning of the error column.
    zero : {"shift", "keep"}, optional
        Whether the reference's zero is shifted to the zero of the reading.
    missing : {"drop"}, optional
        ``drop`` leaves out the rows in which a value is missing; otherwise such a row is an error.
    order : str, optional
        Treatment of rows whose time decreases, as for ``--order``.
    **metadata
        Keys of ``measurement.toml``, as in :meth:`Dataset.from_arrays`.

    Returns
    -------
    Dataset
        The set; its ``origin.notes`` list the decisions of the import.

    Raises
    ------
    AmbiguousError
        The files can be read in several ways. The text names the option of ``arctrue import`` that
        decides; for example, ``--unit head1=deg`` there is ``units={"head1": "deg"}`` here.
    MeasurementError
        A file is damaged; the text states row and column.
    MissingExtraError
        The reader needs a package that is not installed.
    """
    paths = [Path(files)] if isinstance(files, Path | str) else [Path(one) for one in files]
    keys = keys_of(metadata)
    of_reference = keys.reference
    assert of_reference is not None
    settings = Settings(
        columns=dict(columns or {}),
        units=dict(units or {}),
        sign=sign,
        zero=zero,
        clock_offset_s=of_reference.clock_offset_s,
        missing=missing,
        order=order,
        table=replace(keys.table, faces=of_reference.faces),
        instrument=of_reference.instrument,
        standard_uncertainty_arcsec=of_reference.standard_uncertainty_arcsec,
        title=keys.title,
        date=moment(keys.date) if keys.date else None,
    )
    reading = ReadSettings(group=group, period_s=period_s)
    imported = Import(paths, reader, reading, settings).run(Choices())
    origin = Origin(
        program=f"arctrue {version('arctrue')}",
        notes=tuple(one_line(text) for text in imported.notes),
    )
    found = replace(imported.measurement, origin=origin)
    if found.capture is not None and keys.capture is not None:
        found = replace(found, capture=replace(found.capture, clock_hz=keys.capture.clock_hz))
    return Dataset.of(found)


def export(
    measurement: SetOrFolder,
    model: ModelLike,
    file: Path | str,
    *,
    table_format: str = GATEWARE,
    points: int | None = None,
    steps_per_second: float | None = None,
    lanes: int | None = None,
    temperature_c: float | None = None,
    force: bool = False,
) -> list[str]:
    """Write a model as coefficients of the gateware, or as another controller's table.

    Parameters
    ----------
    measurement : MeasurementSet, Path or str
        The set, or the name of its folder; the written correction is tested on it.
    model : Model, Path, str or iterable of str
        The model, its file, or names of effects; effects without values are fitted first.
    file : Path or str
        The file to write.
    table_format : str, optional
        ``gateware``, or a format of ``arctrue export --format``.
    points : int, optional
        Number of steps of a table per turn.
    steps_per_second : float, optional
        Motor steps in a sidereal second, which ``table_format="onstep"`` needs.
    lanes : int, optional
        Number of lanes of the gateware; by default the number with which the gateware is built.
    temperature_c : float, optional
        Temperature for which the coefficients hold, °C; by default the coefficients follow the
        table's temperature.
    force : bool, optional
        Write the file even if there are reasons for ExportRefusedError.

    Returns
    -------
    list of str
        Parts of the model that are not corrected, and further remarks, one sentence each.

    Raises
    ------
    ExportRefusedError
        The correction would increase the error of the set, or the firmware would refuse it; nothing
        was written.
    ValueError
        The format is not known or does not accept ``points``, or the set does not state the counts
        per turn.
    OSError
        The file cannot be written.
    """
    from arctrue.gateware.coefficient_file import write_coefficient_file
    from arctrue.generated.number_formats import LANES_DEFAULT
    from arctrue.metrology.controllers import FORMATS
    from arctrue.metrology.correction import Correction, table_objections
    from arctrue.workbench.model.export import export_model
    from arctrue.workbench.model.taken_away import without_reference_errors

    data, start = set_of(measurement), model_of(model)
    observations, known, content = start.observations(data), start.known(), start.content
    doubts = []
    if not all(entry.coefficients for entry in content.effects):
        content, solution = fitted(content, observations, known)
        doubts = not_determined(_lost(solution))
    elif content.history and content.history[-1].measurement_sha256 == data.sha256:
        doubts = not_determined(_lost(as_stored(content, observations, known)))
    path = Path(file)
    if table_format != GATEWARE:
        if table_format not in FORMATS:
            raise ValueError(
                f"table_format {table_format!r}: expected {', '.join((GATEWARE, *FORMATS))}"
            )
        FORMATS[table_format].check_points(points)
        form = FORMATS[table_format].for_axis(observations.drive_gear_teeth, steps_per_second)
        correction = form.part_of(
            Correction.of_model(content, observations, known, temperature_c=temperature_c)
        )
        judged = without_reference_errors(data, content, observations, known)
        refused = table_objections(judged.reference, correction, observations.counts_per_rev)
        _refuse(path, refused, force=force)
        write_whole_text(path, form.text(correction, points or form.points, one_line(data.label)))
        return [*refused, *doubts, *correction.warnings, *form.not_corrected(correction)]
    result = export_model(
        content,
        observations,
        known,
        lanes=LANES_DEFAULT if lanes is None else lanes,
        temperature_c=temperature_c,
    )
    judged = without_reference_errors(data, content, observations, known)
    refused = objections(judged, result.coefficients)
    _refuse(path, refused, force=force)
    path.parent.mkdir(parents=True, exist_ok=True)
    write_coefficient_file(path, result.coefficients, title=data.label)
    return [*refused, *doubts, *result.warnings, *result.left_out]


def _lost(solution: Solution) -> list[str]:
    """Return the names of the parameters that the rows of the set do not determine."""
    return undetermined_parameters(solution, directions_of(solution))


def _refuse(path: Path, refused: list[str], *, force: bool) -> None:
    """Raise ExportRefusedError if ``refused`` contains reasons, unless ``force`` is True."""
    if refused and not force:
        raise ExportRefusedError(f"{path} was not written: {' '.join(refused)}")
