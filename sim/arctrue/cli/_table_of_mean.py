"""Adds a local table to the coefficient file of a mean of heads."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from arctrue.calibration.acceptance import of_limits
from arctrue.cli._loaded_set import LoadedSet, console
from arctrue.gateware.capability import EVERYTHING
from arctrue.gateware.coefficient_file import read_coefficient_file, write_coefficient_file
from arctrue.workbench.model.local_errors import at_heads_of_mean, local_errors, table_of
from arctrue.workbench.model.model import Model


def write_table_of_mean(model: Model, loaded: LoadedSet, mean_file: Path, path: Path) -> None:
    """Write the coefficient file of a mean, completed by a table of the model's local errors at all
    heads.

    Raises ValueError for a file that has no mean or belongs to another table, for a model without
    such an error, and for a table that the firmware would refuse.
    """
    of_mean = read_coefficient_file(mean_file, EVERYTHING)
    if of_mean.extension is None or of_mean.extension.mean is None:
        raise ValueError(
            f"{mean_file}: it has no mean of heads; write one by calibrate --angle mean"
        )
    counts = of_mean.counts_per_rev
    if counts != loaded.observations.counts_per_rev:
        raise ValueError(
            f"{mean_file}: counts_per_rev is {counts}, the set has "
            f"{loaded.observations.counts_per_rev}"
        )
    errors = list(local_errors(model, loaded.effects).values())
    if not errors:
        raise ValueError("--mean: no effect of the model is an error at one place of the turn")
    made_table = table_of(at_heads_of_mean(errors, of_mean.extension.mean, counts), counts)
    made = replace(of_mean, extension=replace(of_mean.extension, local_table=made_table))
    refused = of_limits(made)
    if refused:
        raise ValueError(f"{path} is not written: {'; '.join(refused)}")
    path.parent.mkdir(parents=True, exist_ok=True)
    write_coefficient_file(path, made, title=loaded.measurement)
    console.print(
        f"wrote {path}: the mean of {mean_file.name} with a local table of "
        f"{len(made_table.starts_counts)} windows of 1/{2**made_table.width_exponent} turn"
    )
