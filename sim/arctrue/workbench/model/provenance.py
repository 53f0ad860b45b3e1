"""Records date, program version and digest of the set for each step of a model's history."""

from __future__ import annotations

from dataclasses import replace
from datetime import UTC, datetime
from importlib.metadata import version

from msgspec import structs

from arctrue.workbench.model.model import Model


def with_provenance(model: Model, steps_before: int, measurement_sha256: str) -> Model:
    """Add date, program version and digest of the set to every new history step.

    ``steps_before`` is the length of the history before these steps. ``measurement_sha256``: see
    :func:`arctrue.measurement.digest.set_digest`.
    """
    date = datetime.now(UTC).isoformat(timespec="seconds")
    program = f"arctrue {version('arctrue')}"
    newer = [
        structs.replace(step, date=date, program=program, measurement_sha256=measurement_sha256)
        for step in model.history[steps_before:]
    ]
    return replace(model, history=[*model.history[:steps_before], *newer])
