"""Checks who sends a request to the server, and restricts what a browser may do with the answer.

Another page in the same browser can also send requests to 127.0.0.1. Therefore a request must name
a host of this server, and a request that changes data must come from the page itself.
"""

from __future__ import annotations

import hmac
from collections.abc import Collection
from urllib.parse import urlencode, urlsplit

from flask import Flask, Request, Response, abort, make_response, redirect, request
from werkzeug.wrappers import Response as AnyResponse

_COOKIE = "arctrue_token"
_POLICY = (
    "default-src 'self'; style-src 'self' 'unsafe-inline'; img-src 'self' data: blob:; "
    "frame-ancestors 'none'; base-uri 'none'; form-action 'self'"
)
"""Content security policy of every answer: only the server's own scripts run; plotly.js may write
inline styles."""


def guard(app: Flask, hosts: Collection[str], token: str) -> None:
    """Make the application check every request.

    ``hosts``: allowed host names with port; if empty, any host is allowed. ``token``: token that a
    request needs; if empty, none is needed.
    """

    @app.before_request
    def only_from_here() -> AnyResponse | None:
        if hosts and request.host not in hosts:
            abort(403, f"this server is {', '.join(sorted(hosts))}, not {request.host[:80]!r}")
        if request.method not in ("GET", "HEAD") and not _same_origin(request):
            abort(403, "this request came from another page and was not carried out")
        return _without_token(token) if token else None

    @app.after_request
    def harmless(response: Response) -> Response:
        response.headers["Content-Security-Policy"] = _POLICY
        response.headers["X-Content-Type-Options"] = "nosniff"
        # With the policy no-referrer the browser would omit the origin when it sends a form.
        response.headers["Referrer-Policy"] = "same-origin"
        return response


def _same_origin(asked: Request) -> bool:
    origin = asked.headers.get("Origin")
    if origin is not None:
        return urlsplit(origin).netloc == asked.host
    return asked.headers.get("Sec-Fetch-Site", "same-origin") in ("same-origin", "none")


def _without_token(token: str) -> AnyResponse | None:
    """Return None if the cookie of the request contains the token; otherwise return the answer.

    A request with the token in its address gets a cookie with the token and is redirected to the
    same address without the token; any other request is refused.
    """
    if hmac.compare_digest(request.cookies.get(_COOKIE, "").encode(), token.encode()):
        return None
    given = request.args.get("token", "")
    if not hmac.compare_digest(given.encode(), token.encode()):
        abort(403, "this page needs the token that arctrue serve printed: …/?token=TOKEN")
    query = urlencode([each for each in request.args.items(multi=True) if each[0] != "token"])
    answer = make_response(redirect(f"{request.path}?{query}" if query else request.path))
    answer.set_cookie(_COOKIE, token, httponly=True, samesite="Strict")
    return answer
