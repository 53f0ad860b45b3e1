"""arctrue serve: serves the page of the analysis to a browser."""

from __future__ import annotations

import os
from pathlib import Path

import click

from arctrue.cli._loaded_set import for_people
from arctrue.cli._outputs import OutputFolder
from arctrue.cli._terminal import note

_STATE = Path("arctrue") / "page"


def state_folder() -> Path:
    """Return the default folder of sessions, according to the XDG base directories."""
    base = os.environ.get("XDG_STATE_HOME", "")
    return (Path(base) if base else Path.home() / ".local" / "state") / _STATE


@click.command("serve", short_help="Open the page: see the misfit, add the effect.")
@click.argument(
    "folder",
    metavar="[SET]",
    default=Path(),
    type=click.Path(path_type=Path, file_okay=False, exists=True),
)
@click.option(
    "--host", default="127.0.0.1", show_default=True, help="Address at which the page is served."
)
@click.option(
    "--http-port",
    type=click.IntRange(0, 65535),
    default=8050,
    show_default=True,
    help="Port at which the page is served; 0: any free one.",
)
@click.option(
    "--effects",
    "folders",
    type=click.Path(path_type=Path),
    multiple=True,
    help="Folder of own effects; the program runs their code.",
)
@click.option(
    "--state",
    type=OutputFolder(),
    help="Folder for sessions.  [default: ~/.local/state/arctrue/page]",
)
@click.option(
    "--most-megabytes",
    type=click.IntRange(1, 4096),
    default=64,
    show_default=True,
    help="Largest total size of files that are dropped on the page together, megabytes.",
)
@click.option("--port", default="", help="Serial port of a device, for the button Load.")
@click.option(
    "--device",
    default="",
    help="Device to show live, through its daemon: its serial port or HOST:PORT.",
)
@for_people
def serve(
    folder: Path,
    host: str,
    http_port: int,
    folders: tuple[Path, ...],
    state: Path | None,
    most_megabytes: int,
    port: str,
    device: str,
) -> None:
    """Serve a page that compares a set with a model and names the effect that the model lacks.

    SET is a measurement set or a folder of sets (default: the current folder); the page reads sets
    from no other folder. The page also accepts sets that the user drops on it, and simulates sets.
    Only this machine can open the page; with --host other machines can open it with a token.
    """
    from arctrue.page.server import serve as serve_page
    from arctrue.page.settings import MEGABYTE, PageSettings

    settings = PageSettings(
        folder=folder,
        state=state or state_folder(),
        effect_folders=folders,
        most_bytes=most_megabytes * MEGABYTE,
        port=port,
        device=device,
    )
    serve_page(settings, host, http_port, note)
