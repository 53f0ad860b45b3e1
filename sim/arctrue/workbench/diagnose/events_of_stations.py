"""Describes jumps of a reference by their time or row, and finds them in a reference whose rows are
not closely spaced."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from arctrue.workbench.diagnose.jumps import Jump
from arctrue.workbench.inference.forward.events import Step, columns_of_steps, search_steps
from arctrue.workbench.inference.forward.noise_of_record import noise_with
from arctrue.workbench.inference.forward.of_solution import records_of_events
from arctrue.workbench.inference.forward.record import Record
from arctrue.workbench.inference.forward.slow import SlowChange, slow_change
from arctrue.workbench.inference.solution import Solution
from arctrue.workbench.observations import Observations


def jump_of(step: Step, record: Record, *, timed: bool) -> Jump:
    """Return a step of a record as a jump, with its time if the record has times."""
    found = Jump(step.size_arcsec, step.sigma_arcsec, None, step.place, None, step.gain)
    if not timed:
        return found
    return replace(found, time_s=step.measured(record), turns=None)


def events_of_stations(
    solution: Solution, quantum_arcsec: float, *, timed: bool
) -> tuple[list[Jump], SlowChange | None]:
    """Search for steps, and also for a slow change, in a reference whose rows are not closely
    spaced. Jumps by one step of the display, ``quantum_arcsec``, are not returned."""
    found: list[tuple[Record, list[Step]]] = []
    for record in records_of_events(solution):
        none = np.zeros((record.clock.size, 0))
        steps = search_steps(record, none, noise_with(record, none))
        found.append((record, steps))
        if len(steps) == 1:
            break
    if not found:
        return [], None
    # A step that ends when its run ends is found as one step if each run is a stretch of its own,
    # otherwise as two steps.
    record, steps = min(found, key=lambda item: len(item[1]) or np.inf)
    slow = slow_change(record, columns_of_steps(record, steps)) if timed else None
    events = [step for step in steps if not step.may_be_one(quantum_arcsec)]
    jumps = [jump_of(step, record, timed=timed) for step in events]
    if not timed:
        jumps = [_at_its_row(jump, solution.observations) for jump in jumps]
    return jumps, slow


def _at_its_row(jump: Jump, observations: Observations) -> Jump:
    """Return the jump with the number of its row in the file, from 0, in place of its number among
    the used rows.

    The number is that of the row after the last used row before the jump: the first row after a
    jump is often an outlier among its neighbours and then not used.
    """
    if jump.turns is None:
        return jump
    # The first row of data is line 2 of the file.
    last_before = observations.reference_line(round(jump.turns) - 1) - 2
    return replace(jump, turns=None, row=last_before + 1)
