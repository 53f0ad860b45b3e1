"""Serves the page of ``arctrue serve`` until the program is interrupted."""

from __future__ import annotations

import errno
import secrets
import socket
from dataclasses import replace

from waitress import create_server  # type: ignore[import-untyped]

from arctrue.base.printable import one_line
from arctrue.base.progress import ReportStep
from arctrue.page.app import make_page
from arctrue.page.settings import MEGABYTE, PageSettings
from arctrue.page.start_pages import open_set_of

LOOPBACK = ("127.0.0.1", "localhost", "::1")
_THREADS = 8
_TOKEN_BYTES = 18


class AddressError(OSError):
    """Is raised if the page cannot be served at the requested address."""


def serve(settings: PageSettings, host: str, port: int, report_step: ReportStep) -> None:
    """Serve the page at ``host``:``port`` (0: a free port); report the address first.

    At a loopback address the server answers only requests that name this machine; at any other
    address a request needs a token. Raises AddressError if the address cannot be used.
    """
    listening = _listening(host, port)
    taken = listening.getsockname()[1]
    if host in LOOPBACK:
        names = {f"{name}:{taken}" for name in ("127.0.0.1", "localhost", "[::1]")}
        settings = replace(settings, hosts=names)
        query = ""
    else:
        settings = replace(settings, token=secrets.token_urlsafe(_TOKEN_BYTES))
        query = f"?token={settings.token}"
        report_step(
            f"warning: {host} can be reached by other machines, and the connection is not "
            "encrypted; only browsers with the token are accepted"
        )
    page = make_page(settings)
    path = "/"
    if page.folder.is_set:
        session, step = open_set_of(page.folder, ".", page.analyses)
        path = f"/s/{session.name}/{step.number}/"
    elif settings.device:
        path = "/device/"
    server = create_server(
        page.app,
        sockets=[listening],
        threads=_THREADS,
        # waitress refuses only uploads above a higher limit, because the page refuses uploads above
        # its own limit with a sentence.
        max_request_body_size=4 * settings.most_bytes + MEGABYTE,
        ident=None,
    )
    shown = f"[{host}]" if ":" in host else host
    report_step(f"serving http://{shown}:{taken}{path}{query}  (Ctrl-C ends it)")
    try:
        server.run()
    finally:
        page.jobs.end_all()
        server.close()


def _listening(host: str, port: int) -> socket.socket:
    """Return a socket that is bound to the address. Raises AddressError with advice."""
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    found = socket.socket(family, socket.SOCK_STREAM)
    found.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    try:
        found.bind((host, port))
        # The socket listens from this line on, so that no other server can bind the port and listen
        # in between.
        found.listen()
    except OSError as error:
        found.close()
        raise AddressError(_why_not(host, port, error)) from error
    return found


def _why_not(host: str, port: int, error: OSError) -> str:
    if error.errno == errno.EADDRINUSE:
        return (
            f"port {port} of {host} is in use, perhaps by another arctrue serve: end that one, or "
            "take another port with --http-port (0: any free one)"
        )
    if error.errno == errno.EACCES:
        return (
            f"port {port} is for the system's administrator: take one from 1024 on with --http-port"
        )
    if error.errno == errno.EADDRNOTAVAIL or isinstance(error, socket.gaierror):
        return (
            f"--host {one_line(host)}: this machine has no such address; expected 127.0.0.1, "
            "0.0.0.0 (all addresses of this machine) or one of its addresses"
        )
    return f"the page cannot be served at {one_line(host)}, port {port}: {error.strerror}"
