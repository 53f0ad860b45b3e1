"""The page of a running device: its state, and a capture that is diagnosed."""

from __future__ import annotations

import shutil
from typing import Any

from flask import Blueprint, render_template
from werkzeug.wrappers import Response

from arctrue.device.console import ConsoleError
from arctrue.measurement.description import read_description
from arctrue.page.addresses import to_step
from arctrue.page.analyses import Analyses
from arctrue.page.live_device import LiveDevice
from arctrue.page.people import PEOPLE_ERRORS, sentence
from arctrue.page.session import SET, Opened, now


def device_pages(device: LiveDevice, analyses: Analyses) -> Blueprint:
    """Add the routes of the device's page."""
    pages = Blueprint("device", __name__, url_prefix="/device")

    def shown(status: int = 200, problem: str = "") -> tuple[str, int]:
        return render_template("device.html.j2", port=device.port, problem=problem), status

    @pages.get("/")
    def page() -> tuple[str, int]:
        return shown()

    @pages.get("/state")
    def state() -> dict[str, Any]:
        return device.shown()

    @pages.post("/capture")
    def capture() -> tuple[str, int] | Response:
        """Copy the capture into a session: the daemon deletes its oldest captures."""
        place = analyses.sessions.make()
        try:
            path = device.capture()
            shutil.copytree(path, place / SET)
            title = read_description(place / SET).keys.title or path.name
            folder, date = str(place / SET), now()
            opened = Opened(title, folder, str(path), "", generated=False, date=date)
            session, step = analyses.first(place, opened)
        except (ConsoleError, *PEOPLE_ERRORS) as error:
            shutil.rmtree(place, ignore_errors=True)
            return shown(422, sentence(error, place))
        return to_step(session, step.number)

    return pages
