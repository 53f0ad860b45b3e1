"""Redirects the browser to the pages of a session's steps."""

from __future__ import annotations

from flask import redirect, url_for
from werkzeug.wrappers import Response

from arctrue.page.session import Session


def to_step(session: Session, number: int, query: str = "", place: str = "") -> Response:
    """Redirect the browser to the page of a step (HTTP 303), so that a reload does not repeat the
    action."""
    address = url_for("analysis.step_page", name=session.name, number=number)
    return redirect(f"{address}{query}{'#' + place if place else ''}", 303)
