"""Creates the Flask application that serves the page."""

from __future__ import annotations

import sys
import traceback
from dataclasses import dataclass

from flask import Flask, Response, render_template, send_file
from jinja2 import ChoiceLoader, PackageLoader
from werkzeug.exceptions import HTTPException

from arctrue.measurement import MeasurementError
from arctrue.page.analyses import Analyses
from arctrue.page.analysis_pages import analysis_pages
from arctrue.page.commands import Commands
from arctrue.page.commissioning_pages import commissioning_pages
from arctrue.page.device_pages import device_pages
from arctrue.page.folder import ChosenFolder
from arctrue.page.guard import guard
from arctrue.page.jobs import Jobs
from arctrue.page.live_device import LiveDevice
from arctrue.page.plotly_file import plotly_file
from arctrue.page.session import NoSuchSessionError, Sessions
from arctrue.page.settings import PageSettings
from arctrue.page.start_pages import start_pages
from arctrue.report.html_templates import HTML_OPTIONS
from arctrue.workbench.effects.registry import catalogue


@dataclass(frozen=True)
class Page:
    """The Flask application and the objects that its server uses."""

    app: Flask
    jobs: Jobs
    analyses: Analyses
    folder: ChosenFolder


def make_page(settings: PageSettings) -> Page:
    """Create the application and the objects that run its background processes.

    Raises EffectFileError for an unusable folder of effects, OSError for the state folder.
    """
    app = Flask("arctrue.page", static_folder="static", template_folder="templates")
    # Flask by default escapes templates with names in .html, but not templates with names in
    # .html.j2.
    app.jinja_options = dict(HTML_OPTIONS)
    app.jinja_loader = ChoiceLoader(
        [PackageLoader("arctrue.page"), PackageLoader("arctrue.report")]
    )
    app.config["MAX_CONTENT_LENGTH"] = settings.most_bytes
    guard(app, settings.hosts, settings.token)
    commands = Commands(settings.effect_folders)
    sessions = Sessions(settings.state)
    analyses = Analyses(sessions, catalogue(settings.effect_folders), commands)
    jobs = Jobs(settings.effect_folders)
    folder = ChosenFolder(settings.folder)
    app.register_blueprint(start_pages(settings, folder, analyses, jobs, commands))
    app.register_blueprint(analysis_pages(settings, analyses, jobs, commands))
    if settings.device:
        app.register_blueprint(device_pages(LiveDevice(settings.device), analyses))
        app.register_blueprint(commissioning_pages(settings.device))

    @app.after_request
    def as_it_is_now(response: Response) -> Response:
        if response.mimetype == "text/html":
            # After Back, a stored copy of the page would lack the steps that were made since.
            response.headers["Cache-Control"] = "no-store"
        return response

    @app.get("/style.css")
    def style() -> Response:
        return Response(render_template("live_style.css.j2"), mimetype="text/css")

    @app.get("/plotly.js")
    def plotly() -> Response:
        return send_file(plotly_file(), mimetype="text/javascript", max_age=86_400)

    @app.errorhandler(NoSuchSessionError)
    def gone(error: NoSuchSessionError) -> tuple[str, int]:
        return _sentence(f"Not here: {error}. It may have been deleted."), 404

    @app.errorhandler(MeasurementError)
    def unreadable(error: MeasurementError) -> tuple[str, int]:
        return _sentence(f"The set of this page cannot be read: {error}"), 422

    @app.errorhandler(HTTPException)
    def refused(error: HTTPException) -> tuple[str, int]:
        return _sentence(f"{error.name}: {error.description}"), error.code or 500

    @app.errorhandler(Exception)
    def broken(error: Exception) -> tuple[str, int]:
        traceback.print_exception(error, file=sys.stderr)
        said = "The program has a fault; its terminal shows details. No stored step is lost"
        return _sentence(f"{said}: {type(error).__name__}: {error}."), 500

    return Page(app, jobs, analyses, folder)


def _sentence(text: str) -> str:
    return render_template("sentence.html.j2", text=text)
