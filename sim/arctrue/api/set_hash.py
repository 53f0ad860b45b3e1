"""Computes the hash that identifies a measurement set in memory."""

from __future__ import annotations

import hashlib
import tempfile
from collections.abc import Mapping
from dataclasses import fields
from pathlib import Path

import numpy as np

from arctrue.measurement import (
    MeasurementError,
    MeasurementSet,
    read_measurement_set,
    write_measurement_set,
)
from arctrue.measurement.digest import set_digest


def sha256_of(measurement: MeasurementSet) -> str:
    """Return the hash of a set in memory as :func:`set_digest` computes it, see
    :attr:`Dataset.sha256`.

    Raises OSError if no temporary folder can be written.
    """
    folder = measurement.folder
    if folder is not None:
        try:
            if _fingerprint(read_measurement_set(folder)) == _fingerprint(measurement):
                return set_digest(folder)
        except (MeasurementError, OSError):
            pass
    with tempfile.TemporaryDirectory() as temporary:
        write_measurement_set(temporary, measurement)
        return set_digest(Path(temporary))


def _fingerprint(measurement: MeasurementSet) -> bytes:
    """Return a hash of table, title, date, capture and reference run."""
    digest = hashlib.sha256(repr((measurement.table, measurement.title, measurement.date)).encode())
    for part in (measurement.capture, measurement.reference):
        if part is None:
            digest.update(b"none")
            continue
        for item in fields(part):
            value = getattr(part, item.name)
            digest.update(item.name.encode())
            if isinstance(value, Mapping):
                for name in sorted(value):
                    digest.update(name.encode() + np.ascontiguousarray(value[name]).tobytes())
            elif isinstance(value, np.ndarray):
                digest.update(np.ascontiguousarray(value).tobytes())
            else:
                digest.update(repr(value).encode())
    return digest.digest()
