"""Keeps the latest fitted models in memory; a model that is no longer in memory is fitted again
from the files of its session."""

from __future__ import annotations

import threading
import time
from collections import OrderedDict
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from arctrue.base.json_text import plain
from arctrue.measurement import read_measurement_set
from arctrue.measurement.digest import set_digest
from arctrue.page.commands import Commands
from arctrue.page.ranking_key import ranking_key
from arctrue.page.session import Opened, Session, Sessions, Step
from arctrue.report.analysis import Analysis, analyse, with_effect, without_effect
from arctrue.report.ranking import Ranking, device_data
from arctrue.workbench.effects.base import Effect
from arctrue.workbench.model.growth import table_of
from arctrue.workbench.model.model import Model, default_model
from arctrue.workbench.model.provenance import with_provenance
from arctrue.workbench.observations import Observations

MOST_KEPT = 8


class Analyses:
    """Fits models and caches the latest of them; several threads may use it."""

    def __init__(
        self, sessions: Sessions, effects: Mapping[str, type[Effect]], commands: Commands
    ) -> None:
        """Store the sessions, all effects that a model may contain (``effects``), and the
        commands."""
        self.sessions = sessions
        self.effects = effects
        self.commands = commands
        self._kept: OrderedDict[tuple[str, int], tuple[str, Analysis]] = OrderedDict()
        """The analyses of the latest steps, each with the key of its inputs."""
        self._devices: dict[tuple[str, int, str, float], dict[str, Any]] = {}
        self._busy: dict[tuple[str, int], threading.Lock] = {}
        self._lock = threading.Lock()

    def first(self, folder: Path, opened: Opened) -> tuple[Session, Step]:
        """Create a session in ``folder`` and fit the default model. Raises the errors of the
        fit."""
        start = time.perf_counter()
        analysis = analyse_opened(opened, default_model(), self.effects)
        session = self.sessions.open(folder, opened)
        return session, self._grown(session, analysis, None, "open", "", start)

    def at(self, session: Session, number: int) -> Analysis:
        """Return the analysis of a step; its model is fitted again if it is no longer in memory, or
        if the set has changed."""
        key = (session.name, number)
        session.step(number)
        inputs = self._current_key(session, number)
        with self._lock:
            if (found := self._found(key, inputs)) is not None:
                return found
            busy = self._busy.setdefault(key, threading.Lock())
        with busy:
            with self._lock:
                if (found := self._found(key, inputs)) is not None:
                    return found
            analysis = analyse_opened(session.opened, session.model(number), self.effects)
            self._keep(key, inputs, analysis)
        return analysis

    def _found(self, key: tuple[str, int], inputs: str) -> Analysis | None:
        """Return the analysis in memory if it was made from these inputs; the caller has the
        lock."""
        kept, analysis = self._kept.get(key, ("", None))
        if analysis is None or kept != inputs:
            return None
        self._kept.move_to_end(key)
        return analysis

    def _current_key(self, session: Session, number: int) -> str:
        """Return the key of a step's inputs as they are now; a stored ranking of other inputs is
        deleted. Raises OSError, MeasurementError."""
        opened, model = session.opened, session.model(number)
        key = ranking_key(Path(opened.folder), opened.title, model, self.effects)
        if key != session.ranking_key(number):
            session.drop_ranking(number)
            session.write_ranking_key(number, key)
        return key

    def ranking(self, session: Session, number: int, temperature_c: float | None) -> Ranking | None:
        """Return the ranking of a step; if another temperature is requested, compute the device's
        coefficients for it."""
        inputs = self._current_key(session, number)
        found = session.ranking(number)
        device = None if found is None else found["device"]
        if found is None or device is None or temperature_c in (None, device["temperature_c"]):
            return found
        assert temperature_c is not None
        key = (session.name, number, inputs, temperature_c)
        if key not in self._devices:
            if len(self._devices) >= MOST_KEPT:
                self._devices.clear()
            self._devices[key] = plain(device_data(self.at(session, number), temperature_c))
        return {**found, "device": self._devices[key]}

    def add(self, session: Session, number: int, effect: str, settings: dict[str, object]) -> Step:
        """Add an effect to the model and store the result as a new step. Raises the errors of
        ``add_effect``."""
        return self._changed(
            session, number, "add", effect, lambda before: with_effect(before, effect, settings)
        )

    def drop(self, session: Session, number: int, effect: str) -> Step:
        """Drop an effect of the model and store the result as a new step. Raises the errors of
        ``drop_effect``."""
        return self._changed(
            session, number, "drop", effect, lambda before: without_effect(before, effect)
        )

    def load(self, session: Session, number: int, model: Model) -> Step:
        """Fit a model from a file and store the result as a new step. Raises ValueError for a model
        of another table, and the errors of the fit."""
        start = time.perf_counter()
        opened = session.opened
        for entry in model.effects:
            entry.effect(self.effects)
        refuse_other_table(model, self.at(session, number).observations)
        model = replace(model, folders=[])
        analysis = analyse_opened(opened, model, self.effects)
        return self._grown(session, analysis, number, "load", "", start)

    def _changed(
        self,
        session: Session,
        number: int,
        action: str,
        effect: str,
        change: Callable[[Analysis], Analysis],
    ) -> Step:
        start = time.perf_counter()
        before = self.at(session, number)
        after = change(before)
        dated = with_provenance(
            after.model, len(before.model.history), set_digest(Path(session.opened.folder))
        )
        return self._grown(session, replace(after, model=dated), number, action, effect, start)

    def _grown(
        self,
        session: Session,
        analysis: Analysis,
        parent: int | None,
        action: str,
        effect: str,
        start: float,
    ) -> Step:
        opened = session.opened
        step = session.grow(
            analysis.model,
            parent=parent,
            action=action,
            effect=effect,
            command=self.commands.of_step(action, effect, opened),
            seconds=time.perf_counter() - start,
        )
        key = self._current_key(session, step.number)
        self._keep((session.name, step.number), key, analysis)
        found = self.sessions.ranked(key)
        if found is not None:
            session.write_ranking(step.number, found)
        return step

    def _keep(self, key: tuple[str, int], inputs: str, analysis: Analysis) -> None:
        with self._lock:
            self._kept[key] = (inputs, analysis)
            self._kept.move_to_end(key)
            while len(self._kept) > MOST_KEPT:
                self._kept.popitem(last=False)
            self._busy.pop(key, None)


def analyse_opened(opened: Opened, model: Model, effects: Mapping[str, type[Effect]]) -> Analysis:
    """Fit a model to the set of a session; the first step of the model's history gets the present
    date.

    Raises MeasurementError, NotTestableError, ValueError.
    """
    folder = Path(opened.folder)
    measurement = read_measurement_set(folder)
    analysis = analyse(measurement, opened.title, model, effects)
    if not model.history:
        return replace(analysis, model=with_provenance(analysis.model, 0, set_digest(folder)))
    return analysis


def refuse_other_table(model: Model, observations: Observations) -> None:
    """Raise ValueError if the model belongs to another table than the set."""
    if model.table is None:
        return
    differences = model.table.differences(table_of(observations))
    if differences:
        raise ValueError(f"the model is of another table: {'; '.join(differences)}")
