"""Runs the demo's second act: the compiled gateware measures a table with a hidden effect at full
scale, and the workbench corrects the effect."""

from __future__ import annotations

import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from arctrue.base.json_text import json_text
from arctrue.base.progress import ReportStep
from arctrue.base.whole_file import write_whole_text
from arctrue.studies.hidden_effect.cases import CASES
from arctrue.studies.hidden_effect.experiment import run_hidden
from arctrue.studies.hidden_effect.result import HiddenResult
from arctrue.studies.hidden_effect.settings import HiddenSettings

HIDDEN = "subdivision_error"
LEFT_SHARE = 0.1
"""Largest permitted error at the signal period, as a share of the error with the paper's model;
half a count is always permitted."""


@dataclass(frozen=True)
class SecondAct:
    """Result of the second act, and the limits that it exceeds."""

    result: HiddenResult
    faults: tuple[str, ...]
    total_s: float

    def as_json(self) -> dict[str, Any]:
        """Return the result and the exceeded limits as plain values."""
        return {**self.result.as_json(), "faults": list(self.faults), "total_s": self.total_s}

    @property
    def passed(self) -> bool:
        """Tell whether the act keeps all limits."""
        return not self.faults


def run_second_act(settings: HiddenSettings, folder: Path, report_step: ReportStep) -> SecondAct:
    """Run the second act; write intermediate files and ``result.json`` into ``folder``.

    Raises InstrumentError if the instrument cannot run.
    """
    started = time.monotonic()
    folder.mkdir(parents=True, exist_ok=True)

    result = run_hidden(
        CASES[HIDDEN],
        settings,
        folder,
        report_run=lambda now: report_step(f"  {now.words}"),
        report_step=report_step,
    )
    act = SecondAct(result, tuple(faults(result)), time.monotonic() - started)
    write_whole_text(folder / "result.json", json_text(act.as_json()))
    return act


def faults(result: HiddenResult) -> list[str]:
    """List the limits that the result of the second act exceeds; empty if it keeps all."""
    found = []
    verdict = result.diagnosed.diagnosis.verdict
    if result.diagnosed.effect != HIDDEN:
        found.append(
            f"the workbench's verdict is {verdict}, added: {result.diagnosed.effect}; "
            f"the hidden effect is {HIDDEN}"
        )
    before, after = (
        period.amplitude_arcsec[0] for period in (result.paper_period, result.corrected_period)
    )
    half_count = result.settings.revolution.arcsec_per_count / 2
    limit = max(LEFT_SHARE * before, half_count)
    if not after <= limit < before:
        found.append(
            f"at the signal period {before:.3f}″ became {after:.3f}″, the limit is {limit:.3f}″"
        )
    paper, corrected = result.paper.edges_rms_arcsec, result.corrected.edges_rms_arcsec
    if not corrected < paper:
        found.append(f"the RMS of the output went from {paper:.3f}″ to {corrected:.3f}″")
    return found
