"""Statements of the user about the files that are imported."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from datetime import datetime

from arctrue.measurement import Table


@dataclass(frozen=True)
class Settings:
    """Statements of the user about the files; "" or None means that the user stated nothing.

    Parameters
    ----------
    columns : mapping of str to str, optional
        Name of the column, by quantity.
    units : mapping of str to str, optional
        Unit of the column, by quantity.
    sign : {"", "reading-true", "true-reading"}, optional
        Sign of an error column.
    zero : {"", "keep", "shift"}, optional
        ``shift`` moves the reference's zero to the zero of the reading.
    clock_offset_s : float, optional
        Encoder's time minus the reference's time, seconds.
    rate_deg_s : float, optional
        Constant speed of the axis, degrees per second, for files with times and errors but no
        angle.
    missing : {"", "drop"}, optional
        ``drop`` leaves out the rows in which a value is missing.
    order : str, optional
        Treatment of rows whose time steps back, see ``row_order``.
    table : Table, optional
        Description of the table, as in the measurement set.
    instrument : str, optional
        Name of the reference instrument.
    standard_uncertainty_arcsec : float, optional
        Standard uncertainty of the reference, arcseconds.
    title : str, optional
        One line that names the set.
    date : datetime, optional
        Date and time of the measurement, with the time zone.
    """

    columns: Mapping[str, str] = field(default_factory=dict)
    units: Mapping[str, str] = field(default_factory=dict)
    sign: str = ""
    zero: str = ""
    clock_offset_s: float | None = None
    rate_deg_s: float | None = None
    missing: str = ""
    order: str = ""
    table: Table = field(default_factory=Table)
    instrument: str | None = None
    standard_uncertainty_arcsec: float | None = None
    title: str = ""
    date: datetime | None = None
