"""Serves the first page, where a user opens a set, drops files, or generates a table with a hidden
effect."""

from __future__ import annotations

import shutil
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from flask import Blueprint, redirect, render_template, request
from werkzeug.exceptions import RequestEntityTooLarge
from werkzeug.wrappers import Response

from arctrue.importing import Ambiguous
from arctrue.measurement import write_measurement_set
from arctrue.measurement.description import read_description
from arctrue.page.addresses import to_step
from arctrue.page.analyses import Analyses
from arctrue.page.commands import Commands
from arctrue.page.folder import ChosenFolder
from arctrue.page.jobs import Jobs
from arctrue.page.people import PEOPLE_ERRORS, shown
from arctrue.page.session import SET, Opened, Session, Step, now
from arctrue.page.settings import MEGABYTE, PageSettings
from arctrue.page.uploads import OpenQuestionsError, keep, receive
from arctrue.studies.simulate.experiment import EXPERIMENTS
from arctrue.studies.simulate.hidden import hidden_effect
from arctrue.studies.simulate.simulated_set import Wanted, simulate_set
from arctrue.studies.simulate.truth import write_truth

_UPLOAD = "files"
_KINDS = {
    "short": "short: four runs of 3,000 samples, and a polygon",
    "full": "full: four runs of 18,000 samples, and a polygon",
    "lean": "lean: one run of 18,000 samples, no reference",
}
_LARGEST_SEED = 2**32 - 1


def start_pages(
    settings: PageSettings,
    folder: ChosenFolder,
    analyses: Analyses,
    jobs: Jobs,
    commands: Commands,
) -> Blueprint:
    """Add the routes of the first page to the application."""
    pages = Blueprint("start", __name__)

    def start(status: int = 200, **messages: Any) -> tuple[str, int]:
        """Render the page; ``messages``: one sentence for each part, and the open questions of an
        import."""
        sessions = [(session, session.opened) for session in analyses.sessions.all()[:20]]
        shown: dict[str, Any] = {
            "open": "",
            "drop": "",
            "generate": "",
            "asked": [],
            "answers": {},
            "previews": [],
            "kept": "",
        }
        return (
            render_template(
                "start.html.j2",
                sets=folder.sets(),
                folder=folder.named,
                device=settings.device,
                sessions=sessions,
                kinds=_KINDS,
                most_megabytes=settings.most_bytes // MEGABYTE,
                most_bytes=settings.most_bytes,
                **{**shown, **messages},
            ),
            status,
        )

    @pages.get("/")
    def first() -> tuple[str, int]:
        return start()

    @pages.post("/open")
    def open_set() -> tuple[str, int] | Response:
        try:
            session, step = open_set_of(folder, request.form.get("set", ""), analyses)
        except PEOPLE_ERRORS as error:
            return start(422, open=shown(error))
        return to_step(session, step.number)

    @pages.post("/generate")
    def generate() -> tuple[str, int] | Response:
        place = analyses.sessions.make()
        try:
            opened = _generated(place, request.form.get("experiment", ""), request.form, commands)
            session, step = analyses.first(place, opened)
        except PEOPLE_ERRORS as error:
            shutil.rmtree(place, ignore_errors=True)
            return start(422, generate=shown(error, place))
        return to_step(session, step.number)

    @pages.post("/drop")
    def drop_in() -> tuple[str, int] | Response:
        try:
            answers = _answers(request.form)
            place, paths = _kept(analyses, request.form.get("kept", ""))
        except RequestEntityTooLarge:
            most = settings.most_bytes // MEGABYTE
            return start(
                413, drop=f"The files are larger than {most} MB together, which is the limit."
            )
        try:
            if not paths:
                paths = keep(request.files.getlist("file"), place / _UPLOAD)
            session, step = _received(analyses, place, paths, answers, commands)
        except OpenQuestionsError as error:
            asked = [_without_folder(item, place / _UPLOAD) for item in error.asked]
            return start(
                422,
                asked=asked,
                answers=error.answers,
                previews=error.previews,
                kept=place.name,
            )
        except PEOPLE_ERRORS as error:
            shutil.rmtree(place, ignore_errors=True)
            return start(422, drop=shown(error, place / SET, place / _UPLOAD, place))
        return to_step(session, step.number)

    @pages.post("/forget/<name>")
    def forget(name: str) -> Response:
        jobs.end_session(analyses.sessions[name])
        analyses.sessions.forget(name)
        return redirect("/", 303)

    return pages


def open_set_of(folder: ChosenFolder, name: str, analyses: Analyses) -> tuple[Session, Step]:
    """Open a measurement set of the chosen folder. Raises MeasurementError, ValueError, OSError."""
    path, named = folder.path(name), folder.as_named(name)
    title = read_description(path).keys.title or path.resolve().name
    place = analyses.sessions.make()
    try:
        opened = Opened(title, str(path.resolve()), named, "", generated=False, date=now())
        return analyses.first(place, opened)
    except PEOPLE_ERRORS:
        shutil.rmtree(place, ignore_errors=True)
        raise


def _generated(place: Path, experiment: str, form: Any, commands: Commands) -> Opened:
    if experiment not in _KINDS:
        raise ValueError(f"experiment: expected {', '.join(_KINDS)}, found {experiment[:40]!r}")
    text = form.get("seed", "").strip()
    if not text:
        seed = int(np.random.SeedSequence().generate_state(1)[0])
    elif text.isascii() and text.isdigit() and int(text) <= _LARGEST_SEED:
        seed = int(text)
    else:
        raise ValueError(f"seed: expected a whole number from 0, found {text[:40]!r}")
    hidden = form.get("hidden", "1") == "1"
    planned = EXPERIMENTS[experiment]()
    wanted = [Wanted(hidden_effect(seed, planned))] if hidden else []
    made = simulate_set(wanted, planned, seed)
    write_measurement_set(place / SET, made.measurement)
    write_truth(place / SET, made.truth)
    name = "table"
    return Opened(
        title=f"a table with {'a hidden effect' if hidden else 'nothing hidden'}, seed {seed}",
        folder=str(place / SET),
        named=name,
        command=commands.simulate(name, experiment, seed, hidden=hidden),
        generated=True,
        date=now(),
    )


def _answers(form: Any) -> dict[str, str]:
    return {
        name.removeprefix("answer:"): value
        for name, value in form.items()
        if name.startswith("answer:") and value.strip()
    }


def _kept(analyses: Analyses, name: str) -> tuple[Path, list[Path]]:
    """Return the folder of this upload, and the files that an earlier attempt with open questions
    stored there."""
    if name.isalnum():
        place = analyses.sessions.folder / name
        files = place / _UPLOAD
        if files.is_dir() and not (place / "session.json").exists():
            return place, sorted(files.iterdir())
    return analyses.sessions.make(), []


def _received(
    analyses: Analyses, place: Path, paths: list[Path], answers: dict[str, str], commands: Commands
) -> tuple[Session, Step]:
    received = receive(paths, place / SET, answers)
    name = "table"
    command = commands.imported(received.files, received.answers, name) if received.imported else ""
    opened = Opened(received.title, str(place / SET), name, command, generated=False, date=now())
    return analyses.first(place, opened)


def _without_folder(asked: Ambiguous, folder: Path) -> Ambiguous:
    """Remove the path of the server's own folder from the question."""
    return replace(asked, question=asked.question.replace(f"{folder}/", ""))
