"""Serves the page of one step of a model: its sections, figures, buttons and files."""

from __future__ import annotations

import json
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from flask import Blueprint, Response, abort, jsonify, render_template, request, send_file
from werkzeug.exceptions import RequestEntityTooLarge
from werkzeug.utils import secure_filename
from werkzeug.wrappers import Response as AnyResponse

from arctrue.base.json_text import plain
from arctrue.page.addresses import to_step
from arctrue.page.analyses import Analyses
from arctrue.page.commands import COEFFICIENTS, MODEL, Commands
from arctrue.page.device import load_into_device
from arctrue.page.jobs import Jobs
from arctrue.page.people import PEOPLE_ERRORS, shown
from arctrue.page.settings import PageSettings
from arctrue.report.charts.chart import Chart
from arctrue.report.charts.matplotlib_chart import chart_svg, save_chart
from arctrue.report.charts.plotly_chart import chart_data
from arctrue.report.charts.spectrum import ALONG
from arctrue.report.display import FIGURES, DisplaySettings, chart_of, temperature_fault
from arctrue.report.sections import addable, report_sections, words
from arctrue.studies.simulate.truth import BrokenSealError, read_truth
from arctrue.workbench.model.model_file import read_model

_WIDTH_PX = 900
_ADDRESS = "/s/<name>/<int:number>/"


def analysis_pages(
    settings: PageSettings, analyses: Analyses, jobs: Jobs, commands: Commands
) -> Blueprint:
    """Add the routes of a step's page to the application."""
    pages = Blueprint("analysis", __name__)
    sessions = analyses.sessions

    def page(name: str, number: int, status: int = 200, **messages: str) -> tuple[str, int]:
        """Render the page; ``messages`` contains for each button a sentence that is shown next to
        it."""
        session = sessions[name]
        step, opened = session.step(number), session.opened
        display = DisplaySettings.of_query(request.args)
        analysis = analyses.at(session, number)
        ranking = analyses.ranking(session, number, display.temperature_c)
        if status == 200 and jobs.state(session, number)["state"] == "none":
            jobs.start(session, number)
        temperature = request.args.get("temperature", "")
        messages = {"device": temperature_fault(temperature), **messages}
        html = render_template(
            "analysis.html.j2",
            session=session,
            opened=opened,
            step=step,
            steps=session.steps(),
            display=display,
            temperature=temperature,
            query=display.query(),
            sections=report_sections(analysis, ranking, display),
            ranking=jobs.state(session, number),
            addable=[(effect, words(effect)) for effect in addable(analysis)],
            drawn=[figure for figure in FIGURES if _there(figure, ranking)],
            along=ALONG,
            commands=commands,
            port=settings.port,
            serve=commands.serve(settings.folder, settings.state, settings.port),
            truth=_truth(opened.folder) if display.reveal and opened.generated else None,
            messages={"add": "", "drop": "", "model": "", "device": "", "ranking": "", **messages},
            files={"model": MODEL, "coefficients": COEFFICIENTS},
            words=words,
        )
        return html, status

    @pages.get("/s/<name>/")
    def latest(name: str) -> AnyResponse:
        session = sessions[name]
        return to_step(session, session.steps()[-1].number)

    @pages.get(_ADDRESS)
    def step_page(name: str, number: int) -> tuple[str, int]:
        return page(name, number)

    def chart(name: str, number: int, figure: str) -> Chart:
        session = sessions[name]
        session.step(number)
        display = DisplaySettings.of_query(request.args)
        try:
            ranking = analyses.ranking(session, number, display.temperature_c)
            found = chart_of(figure, analyses.at(session, number), ranking, display)
        except KeyError:
            found = None
        if found is None:
            abort(404, f"there is no figure {figure[:40]!r} yet")
        return found

    @pages.get(_ADDRESS + "figure/<figure>.json")
    def figure_json(name: str, number: int, figure: str) -> Response:
        width = request.args.get("width", _WIDTH_PX, int)
        drawn = chart(name, number, figure)
        data = chart_data(drawn, min(max(width, 200), 4000))
        # Do not use the key "meta" of the layout: plotly.js inserts it into texts that contain
        # %{meta}.
        return jsonify(plain({**data, "words": drawn.words}))

    @pages.get(_ADDRESS + "figure/<figure>.svg")
    def figure_svg(name: str, number: int, figure: str) -> Response:
        svg = chart_svg(chart(name, number, figure))
        head = '<?xml version="1.0" encoding="utf-8"?>\n'
        return Response(head + svg, mimetype="image/svg+xml")

    @pages.get(_ADDRESS + "figure/<figure>.png")
    def figure_png(name: str, number: int, figure: str) -> Response:
        with TemporaryDirectory() as folder:
            path = save_chart(chart(name, number, figure), Path(folder) / f"{figure}.png")
            return Response(path.read_bytes(), mimetype="image/png")

    @pages.get(_ADDRESS + "<any(add, drop, model, load):action>")
    def not_repeated(name: str, number: int, action: str) -> AnyResponse:
        """Redirect to the page of the step if the browser opens the address of a form again."""
        return to_step(sessions[name], number, _query())

    @pages.post(_ADDRESS + "add")
    def add(name: str, number: int) -> tuple[str, int] | AnyResponse:
        effect = request.form.get("effect", "")
        try:
            step = analyses.add(sessions[name], number, effect, {})
        except PEOPLE_ERRORS as error:
            return page(name, number, 422, add=shown(error))
        return to_step(sessions[name], step.number, _query(), "ladder")

    @pages.post(_ADDRESS + "drop")
    def drop(name: str, number: int) -> tuple[str, int] | AnyResponse:
        effect = request.form.get("effect", "")
        try:
            step = analyses.drop(sessions[name], number, effect)
        except PEOPLE_ERRORS as error:
            return page(name, number, 422, drop=shown(error))
        return to_step(sessions[name], step.number, _query(), "ladder")

    @pages.post(_ADDRESS + "model")
    def load_model(name: str, number: int) -> tuple[str, int] | AnyResponse:
        session = sessions[name]
        with TemporaryDirectory(dir=session.folder) as folder:
            path = Path(folder) / MODEL
            try:
                file = request.files.get("model")
                if file is None or not file.filename:
                    raise ValueError("no file was chosen: choose a model file")
                path = path.with_name(secure_filename(file.filename) or MODEL)
                file.save(path)
                step = analyses.load(session, number, read_model(path))
            except RequestEntityTooLarge:
                return page(name, number, 413, model="The file is larger than the limit.")
            except PEOPLE_ERRORS as error:
                return page(name, number, 422, model=shown(error, path.parent))
        return to_step(session, step.number, _query(), "ladder")

    @pages.get(_ADDRESS + "ranking")
    def ranking_state(name: str, number: int) -> Response:
        session = sessions[name]
        session.step(number)
        return jsonify(jobs.state(session, number))

    @pages.post(_ADDRESS + "ranking/start")
    def ranking_start(name: str, number: int) -> AnyResponse:
        session = sessions[name]
        session.step(number)
        jobs.start(session, number)
        return to_step(session, number, _query(), "missing")

    @pages.post(_ADDRESS + "ranking/cancel")
    def ranking_cancel(name: str, number: int) -> AnyResponse:
        session = sessions[name]
        session.step(number)
        jobs.cancel(session, number)
        return to_step(session, number, _query(), "missing")

    @pages.get(_ADDRESS + "model.toml")
    def model_file(name: str, number: int) -> Response:
        sessions[name].step(number)
        return _download(sessions[name].model_file(number), MODEL)

    @pages.get(_ADDRESS + "diagnosis.json")
    def diagnosis_file(name: str, number: int) -> Response:
        ranking = _ranking(name, number)
        text = json.dumps(ranking["diagnosis"], indent=1, ensure_ascii=False)
        return _attached(text, "application/json", "diagnosis.json")

    @pages.get(_ADDRESS + "coefficients.toml")
    def coefficient_file(name: str, number: int) -> Response:
        device = _ranking(name, number)["device"] or {}
        if "file" not in device:
            abort(404, "there are no coefficients for a device here")
        return _attached(device["file"], "application/toml", COEFFICIENTS)

    def _ranking(name: str, number: int) -> dict[str, Any]:
        session = sessions[name]
        session.step(number)
        display = DisplaySettings.of_query(request.args)
        found = analyses.ranking(session, number, display.temperature_c)
        if found is None:
            abort(404, "the diagnosis of this step is not complete yet")
        return found

    @pages.post(_ADDRESS + "load")
    def load(name: str, number: int) -> tuple[str, int]:
        device = _ranking(name, number)["device"] or {}
        try:
            said = load_into_device(settings.port, device, force=request.form.get("force") == "1")
        except PEOPLE_ERRORS as error:
            return page(name, number, 422, device=shown(error))
        return page(name, number, 200, device=said)

    return pages


def _there(figure: str, ranking: dict[str, Any] | None) -> bool:
    """Tell whether the ranking so far contains the data of this figure."""
    if figure == "finding":
        return bool(ranking and ranking["finding"] and ranking["finding"]["best"])
    if figure == "lanes":
        device = None if ranking is None else ranking["device"]
        return bool(device and device.get("orders"))
    return True


def _query() -> str:
    return DisplaySettings.of_query(request.args).query(reveal=False)


def _truth(folder: str) -> dict[str, Any]:
    """Return the truth of a generated set, or the reason why the truth cannot be read."""
    try:
        return read_truth(Path(folder))
    except (OSError, BrokenSealError, ValueError) as error:
        return {"fault": str(error)}


def _download(path: Path, name: str) -> Response:
    return send_file(path, mimetype="application/toml", as_attachment=True, download_name=name)


def _attached(text: str, kind: str, name: str) -> Response:
    headers = {"Content-Disposition": f"attachment; filename={name}"}
    return Response(text, mimetype=kind, headers=headers)
