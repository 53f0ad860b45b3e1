"""Reads ``measurement.toml``, which describes the measured object and the instruments."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path, PurePosixPath, PureWindowsPath
from typing import Annotated, Any, Literal

from msgspec import Meta, Struct, field

from arctrue.base.printable import one_line
from arctrue.base.read_errors import unreadable
from arctrue.base.toml_file import TomlContentError, read_toml
from arctrue.base.typed_content import ContentError, line_of_text, shown, typed, unknown_keys
from arctrue.measurement.date import moment, with_text_date
from arctrue.measurement.errors import MeasurementError
from arctrue.measurement.measurement_set import (
    AnyNumber,
    Count,
    NotNegative,
    Origin,
    Positive,
    Table,
)

FILE_NAME = "measurement.toml"


class Channel(Struct, frozen=True):
    """Keys that both ``[capture]`` and ``[reference]`` may have; None: not stated."""

    file: str | None = None

    def __post_init__(self) -> None:
        """Check the file name. Raises ValueError for a file outside the set's folder."""
        if self.file is None:
            return
        line_of_text(self.file, "file")
        if not _stays_inside(self.file):
            raise ValueError(
                f"file: expected a file in the set's own folder, found {shown(self.file)}: "
                "copy or link the file into the folder, and name it without .."
            )


class CaptureKeys(Channel, frozen=True):
    """The keys of the section ``[capture]``."""

    clock_hz: Positive | None = None


class ReferenceKeys(Channel, frozen=True):
    """The keys of the section ``[reference]``."""

    instrument: str | None = None
    faces: Count | None = None
    standard_uncertainty_arcsec: NotNegative | None = None
    clock_offset_s: AnyNumber | None = None

    def __post_init__(self) -> None:
        """Check the texts. Raises ValueError for a text of more than one printable line."""
        super().__post_init__()
        line_of_text(self.instrument or "", "instrument")


Schema = Annotated[Literal[1], Meta(description="1, the schema that this program reads")]


class Keys(Struct, frozen=True):
    """All keys that this program knows; ``Description.other`` holds the unknown keys."""

    schema: Schema
    title: str = ""
    date: str = ""
    """Date of the measurement, ISO 8601; empty: not stated."""
    table: Table = field(default_factory=Table)
    capture: CaptureKeys | None = None
    reference: ReferenceKeys | None = None
    origin: Origin = field(default_factory=Origin)

    def __post_init__(self) -> None:
        """Check texts and date.

        Raises ValueError for a text of more than one printable line, or for an invalid date.
        """
        line_of_text(self.title, "title")
        if self.date:
            moment(self.date)


SECTIONS = ("table", "capture", "reference", "origin")


class Description(Struct, frozen=True):
    """The keys of a file; unknown keys are listed by their dotted names, with warnings."""

    path: Path
    keys: Keys
    other: Mapping[str, Any]
    warnings: tuple[str, ...]


class _OnlySchema(Struct):
    schema: Schema


def read_description(folder: Path) -> Description:
    """Read and check ``folder``/measurement.toml. Raises MeasurementError naming file and key."""
    path = folder / FILE_NAME
    if not folder.is_dir():
        what = "is a file" if folder.exists() else "no such folder"
        raise MeasurementError("missing", folder, f"{what}; expected a folder with a {FILE_NAME}")
    try:
        content = with_text_date(read_toml(path))
        # If the file states another schema, its keys may have other types; the error then names
        # only the schema.
        typed(content, _OnlySchema)
        keys = typed(content, Keys)
    except OSError as error:
        why = unreadable(error, "every set needs one")
        raise MeasurementError("missing", path, why) from error
    except TomlContentError as error:
        raise MeasurementError("format", path, str(error)) from error
    except ContentError as error:
        raise MeasurementError("missing" if error.missing else "value", path, str(error)) from error
    other, warnings = {}, []
    for dotted, near in unknown_keys(content, Keys).items():
        section, _, key = dotted.partition(".")
        other[dotted] = content[section][key] if section in SECTIONS else content[dotted]
        meant = f"; did you mean {' or '.join(near)}?" if near else ""
        warnings.append(f"{path}: the key {one_line(dotted)} is not known and is not used{meant}")
    return Description(path, keys, other, tuple(warnings))


def _stays_inside(name: str) -> bool:
    """Tell whether ``name`` is a relative path without ".." under the rules of every operating
    system."""
    windows, posix = PureWindowsPath(name), PurePosixPath(name)
    return not (windows.anchor or posix.is_absolute() or ".." in windows.parts + posix.parts)
