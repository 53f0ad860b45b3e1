"""Replaces links to files that the site lacks by the names of the files when mkdocs builds the
site.

People read the pages in the source tree, on code hosts and on the site. The site contains no files
outside docs/, no notebooks and no files of docs/data, so a link to such a file would be dead.
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

LINK = re.compile(r"(?<!!)\[(?P<text>[^\]]+)\]\((?P<target>[^)\s]+)\)")


def on_page_markdown(markdown: str, page: Any, config: Any, files: Any) -> str:
    """Return the text of a page for the site. mkdocs calls this function for each page."""
    folder = Path(page.file.src_uri).parent
    return LINK.sub(lambda link: _shown(link, folder, Path(config["docs_dir"])), markdown)


def _shown(link: re.Match[str], folder: Path, docs: Path) -> str:
    target = link["target"].partition("#")[0]
    if "://" in target or not target:
        return link[0]
    there = (docs / folder / target).resolve()
    shown = there.is_relative_to(docs.resolve()) and there.is_file()
    if shown and there.suffix != ".ipynb" and "data" not in there.relative_to(docs.resolve()).parts:
        return link[0]
    name = there.relative_to(docs.resolve().parent).as_posix()
    text = link["text"]
    return f"`{name}`" if text.strip("`").rstrip("/") == name else f"{text} (`{name}`)"
