"""Runs ``arctrue calibrate`` for a set with a reference run but without a capture."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from arctrue.base.figures import figure
from arctrue.calibration import acceptance
from arctrue.calibration.comparison import ReferenceComparison, compare
from arctrue.cli._tables import number, table
from arctrue.cli._terminal import Console
from arctrue.gateware.coefficients import Coefficients
from arctrue.measurement import MeasurementSet
from arctrue.workbench.effects.registry import catalogue
from arctrue.workbench.model.export import export_model
from arctrue.workbench.model.growth import fitted
from arctrue.workbench.model.stations import model_of_stations
from arctrue.workbench.observations.build import observations_of


@dataclass(frozen=True)
class ReferenceCalibration:
    """Coefficients that were fitted to a reference run, tested with the same run."""

    coefficients: Coefficients
    comparison: ReferenceComparison
    rows: int
    targets: int
    most_order: int
    orders: list[int]
    amplitudes_arcsec: list[float]
    left_out: list[str]
    objections: list[str]
    warnings: list[str]

    def print_orders(self, console: Console) -> None:
        """Print the number of rows and targets, and the orders that are applied."""
        console.print(
            f"reference run alone: {self.rows} rows at {self.targets} targets, which determine "
            f"orders 1 to {self.most_order}",
            soft_wrap=True,
        )
        orders = table(
            "Orders of the error, as a function of the reading",
            number("order"),
            number("amplitude ″"),
        )
        for order, amplitude in zip(self.orders, self.amplitudes_arcsec, strict=True):
            orders.add_row(str(order), figure(amplitude, 4))
        console.print()
        console.print(orders)
        for text in self.left_out:
            console.print(f"not applied: {text}", soft_wrap=True)

    def figures(self, extents: Callable[[ReferenceComparison], dict[str, Any]]) -> dict[str, Any]:
        """Return the figures for JSON, with the keys that the calibration by two heads uses for the
        same figures."""
        return {
            "method": "reference",
            "runs": [],
            "warnings": self.warnings,
            "refused": self.objections,
            **extents(self.comparison),
            "orders": [
                {"order": order, "amplitude_arcsec": amplitude, "applied": True}
                for order, amplitude in zip(self.orders, self.amplitudes_arcsec, strict=True)
            ],
        }


def calibrate_from_reference(
    measurement: MeasurementSet, *, lanes: int, most_order: int
) -> ReferenceCalibration:
    """Fit the harmonics that the targets determine, and quantise the significant ones.

    Raises ValueError for a set without counts, or with targets that cover only a part of the turn.
    """
    if measurement.table.counts_per_rev is None:
        raise ValueError(
            "coefficients of the gateware need table.counts_per_rev in measurement.toml; for "
            "another controller: arctrue export SET --format"
        )
    observations = observations_of(measurement)
    rows, reference = observations.every_reference_row, measurement.reference
    if rows is None or reference is None:
        raise ValueError("the set has neither a capture nor a reference run")
    effects = catalogue([])
    model = model_of_stations(rows, most_order)
    orders = model.effects[0].settings["orders"]
    assert isinstance(orders, list)
    model, _ = fitted(model, observations, effects)
    result = export_model(model, observations, effects, lanes=lanes, temperature_c=None)
    used = observations.used_reference_rows
    kept = np.ones(reference.target_deg.size, dtype=bool)
    if used is not None:
        kept[:] = False
        kept[used] = True
    comparison = compare(reference.where(kept), result.coefficients)
    return ReferenceCalibration(
        coefficients=result.coefficients,
        comparison=comparison,
        rows=int(rows.target_rad.size),
        targets=int(np.unique(np.round(np.degrees(rows.target_rad) % 360.0, 6)).size),
        most_order=len(orders),
        orders=result.orders,
        amplitudes_arcsec=result.amplitudes_arcsec,
        left_out=result.left_out,
        objections=[
            *acceptance.of_limits(result.coefficients),
            *acceptance.of_comparison(comparison),
        ],
        warnings=[
            *measurement.warnings,
            *result.warnings,
            *(f"not used: {row}" for row in observations.masked),
            "the calibration is tested only with its own reference run: measure another one",
        ],
    )
