"""Result of the experiment with a hidden effect, and its plain values."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from arctrue.instrument.turn_score import TurnScore
from arctrue.studies.hidden_effect.cases import Case
from arctrue.studies.hidden_effect.settings import HiddenSettings
from arctrue.studies.hidden_effect.signal_period import SignalPeriod
from arctrue.studies.hidden_effect.workbench import DiagnosedModel
from arctrue.workbench.model.export import Export


@dataclass(frozen=True)
class HiddenResult:
    """Result of the experiment; the scores apply to the turns that :attr:`Case.fresh` describes."""

    case: Case
    settings: HiddenSettings
    folder: Path
    """Folder of the measurement set."""
    diagnosed: DiagnosedModel
    export: Export
    raw: TurnScore
    """Score of head 1 without a correction."""
    paper: TurnScore
    """Score of the output with the coefficients that the firmware calibrates by the paper's
    model."""
    corrected: TurnScore
    """Score of the output with the coefficients that the workbench exported."""
    unit_left_out: TurnScore | None
    """Score like ``corrected``, but without the lanes that follow a condition or have a real order,
    and with an empty local table."""
    raw_period: SignalPeriod
    """Error of head 1 over a period of the grating; the next two attributes are the same error of
    the output, with the paper's model and with the export."""
    paper_period: SignalPeriod
    corrected_period: SignalPeriod
    fresh_capture_arcsec: dict[str, float]
    """RMS of the residuals in the capture of the judged run, under the model ``without`` and
    ``with`` the effect."""
    firmware_orders: int
    reversal_arcsec: dict[str, float] | None
    """Mean error upwards minus mean error downwards of the output, with the paper's model and with
    the export; None if the case has no polygon.
    """
    lines_counts: dict[str, list[float]]
    """Amplitudes, in counts, of the case's lines in the output: ``without`` lanes of real orders,
    and ``forwards`` and ``backwards`` with these lanes; empty if the case judges no lines."""
    clocks: int
    simulating_s: float
    workbench_s: float

    def judged_arcsec(self) -> dict[str, float]:
        """Return the size of the effect in the output, for each set of coefficients."""
        if self.reversal_arcsec is not None:
            return {name: abs(value) for name, value in self.reversal_arcsec.items()}
        order = self.case.judged_order
        scores = {"paper": self.paper, "corrected": self.corrected}
        if self.unit_left_out is not None:
            scores["unit_left_out"] = self.unit_left_out
        return {
            name: float(
                np.nanmax(np.abs(score.error_arcsec))
                if order is None
                else score.amplitude_arcsec[order - 1]
            )
            for name, score in scores.items()
        }

    def as_json(self) -> dict[str, Any]:
        """Return the whole result as plain values."""
        return {
            "effect": self.case.name,
            "counts_per_rev": self.settings.revolution.counts_per_rev,
            "lines": self.settings.revolution.lines,
            "lanes": self.settings.revolution.lanes,
            "samples": self.settings.revolution.samples,
            "noise_arcsec": self.settings.revolution.noise_arcsec,
            "set": str(self.folder),
            "diagnosis": self.diagnosed.data(),
            "words": self.diagnosed.words(),
            "added": self.diagnosed.effect,
            "effect_file": None
            if self.diagnosed.effect_file is None
            else str(self.diagnosed.effect_file),
            "parameters": {
                name: {"value": item.value, "sigma": item.sigma, "unit": item.unit}
                for name, item in self.diagnosed.model.effects[-1].parameters.items()
            },
            "ladder": [
                {
                    "action": step.action,
                    "effect": step.effect,
                    "rms_arcsec": step.rms_arcsec,
                    "heldout_rms_arcsec": step.heldout_rms_arcsec,
                    "peak_arcsec": step.peak_arcsec,
                    "noise_arcsec": step.noise_arcsec,
                }
                for step in self.diagnosed.ladder
            ],
            "lanes_written": [
                {"order": order, "amplitude_arcsec": amplitude}
                for order, amplitude in zip(
                    self.export.orders, self.export.amplitudes_arcsec, strict=True
                )
            ],
            "not_corrected": self.export.left_out,
            **{
                name: {**turn.as_json(), **turn.curve_as_json(), "signal_period": period.as_json()}
                for name, turn, period in (
                    ("raw", self.raw, self.raw_period),
                    ("paper", self.paper, self.paper_period),
                    ("corrected", self.corrected, self.corrected_period),
                )
            },
            "fresh_capture_arcsec": self.fresh_capture_arcsec,
            "firmware_orders": self.firmware_orders,
            "reversal_arcsec": self.reversal_arcsec,
            "lines_counts": self.lines_counts,
            "judged_arcsec": self.judged_arcsec(),
            "clocks": self.clocks,
            "simulating_s": self.simulating_s,
            "workbench_s": self.workbench_s,
        }
