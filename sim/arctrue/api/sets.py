"""Reads, writes and simulates measurement sets for the Python interface."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from arctrue.api.dataset import Dataset
from arctrue.measurement import MeasurementSet, write_measurement_set

SetOrFolder = MeasurementSet | Path | str
"""A measurement set, or the name of its folder."""


def read_set(folder: Path | str) -> Dataset:
    """Read the folder of a measurement set.

    Parameters
    ----------
    folder : Path or str
        The folder with ``measurement.toml``.

    Returns
    -------
    Dataset
        The set with the content of its files.

    Raises
    ------
    MeasurementError
        A file is missing or wrong; the text states file, row, column, expected and found content.
    """
    return Dataset.read_set(folder)


def write_set(folder: Path | str, measurement: MeasurementSet) -> None:
    """Write a measurement set into a folder; a set in this folder is replaced completely.

    Parameters
    ----------
    folder : Path or str
        The folder; it is made if it does not exist.
    measurement : MeasurementSet
        The set to write. Times are rounded to 1 µs, targets to 10⁻⁹ °, errors and uncertainties to
        10⁻⁶ ″, temperatures to 1 mK.

    Raises
    ------
    ValueError
        A value is not finite, or too large to be read again; or the folder holds a capture.csv,
        reference.csv or mask.csv, but no set.
    OSError
        The folder cannot be written.
    """
    write_measurement_set(folder, measurement)


def set_of(measurement: SetOrFolder) -> Dataset:
    """Return a set as a Dataset; a folder is read first.

    Raises MeasurementError for a folder that cannot be read, TypeError for anything else.
    """
    if isinstance(measurement, MeasurementSet):
        return Dataset.of(measurement)
    if isinstance(measurement, Path | str):
        return read_set(measurement)
    raise TypeError(
        "expected a measurement set (Dataset, read_set, simulate) or the name of its folder, found "
        f"{type(measurement).__name__}"
    )


def simulate(
    *effects: str,
    sizes: Sequence[float] = (),
    experiment: str = "short",
    seed: int = 1,
) -> Dataset:
    """Simulate a table and its measurement.

    Parameters
    ----------
    *effects : str
        Causes of error that the table has, as ``arctrue simulate --list`` names them.
    sizes : sequence of float, optional
        Sizes of the effects, in the order and unit of the effects; an effect without a size gets a
        random size.
    experiment : {"full", "short", "lean", "one_pass", "one_speed"}, optional
        Extent of the measurement.
    seed : int, optional
        Seed of all random numbers.

    Returns
    -------
    Dataset
        A capture, and a reference run unless the experiment has none (``lean``).

    Raises
    ------
    ValueError
        No effect or experiment has that name, or there are more sizes than effects.
    """
    from arctrue.studies.simulate.experiment import EXPERIMENTS
    from arctrue.studies.simulate.simulated_set import Wanted, simulate_set

    if experiment not in EXPERIMENTS:
        raise ValueError(f"experiment {experiment!r}: expected {', '.join(sorted(EXPERIMENTS))}")
    padded: list[float | None] = [*sizes, *[None] * (len(effects) - len(sizes))]
    wanted = [Wanted(name, size) for name, size in zip(effects, padded, strict=True)]
    return Dataset.of(simulate_set(wanted, EXPERIMENTS[experiment](), seed).measurement)
