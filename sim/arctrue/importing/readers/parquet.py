"""Reads Apache Parquet files with the package pyarrow."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from arctrue.base.extras import LazyModule
from arctrue.importing.choices import Choices
from arctrue.importing.file_content import FileContent
from arctrue.importing.reader import ReadSettings
from arctrue.importing.readers.arrays import recording_of
from arctrue.importing.readers.unpacked_size import refuse_above_limit
from arctrue.measurement import MeasurementError

if TYPE_CHECKING:
    import pyarrow as pa  # type: ignore[import-untyped]
    import pyarrow.parquet as pa_parquet  # type: ignore[import-untyped]
else:
    pa, pa_parquet = LazyModule("pyarrow"), LazyModule("pyarrow.parquet")


def recognises(path: Path, head: bytes) -> bool:
    """Tell whether the file begins with the magic bytes of Parquet."""
    return head.startswith(b"PAR1")


def read(path: Path, settings: ReadSettings, choices: Choices) -> FileContent:
    """Return the columns of the table.

    Raises MeasurementError for a damaged file or a size above the limit, MissingExtraError without
    pyarrow.
    """
    try:
        metadata = pa_parquet.read_metadata(path)
        # A constant column needs a few bytes in the file, but eight bytes per row in memory.
        refuse_above_limit(path, metadata.num_rows * metadata.num_columns * 8)
        table = pa_parquet.read_table(path)
        arrays = {name: np.asarray(table.column(name).to_numpy()) for name in table.column_names}
    except (pa.ArrowInvalid, pa.ArrowNotImplementedError) as error:
        raise MeasurementError("format", path, f"cannot be read as Parquet: {error}") from error
    return recording_of(path, "parquet", arrays)
