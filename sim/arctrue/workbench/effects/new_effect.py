"""Writes a file for a user's own effect and a file with its test, both from templates."""

from __future__ import annotations

import keyword
import re
from contextlib import ExitStack
from pathlib import Path

from jinja2 import Environment, PackageLoader, StrictUndefined

from arctrue.base.whole_file import whole_file
from arctrue.workbench.effects.registry import built_in


def write_new_effect(name: str, folder: Path) -> list[Path]:
    """Write ``NAME.py`` and ``test_NAME.py`` into ``folder``; return the paths.

    Raises ValueError for the name of a built-in effect or a name that is not allowed,
    FileExistsError for an existing file.
    """
    if not re.fullmatch(r"[a-z][a-z0-9_]*", name) or keyword.iskeyword(name):
        raise ValueError(
            f"{name!r} is no name for an effect: use small letters, digits, underscores"
        )
    if name in built_in():
        raise ValueError(f"the effect name {name} is taken already")
    templates = Environment(
        loader=PackageLoader("arctrue.workbench.effects", "templates"),
        undefined=StrictUndefined,
        keep_trailing_newline=True,
        autoescape=False,
    )
    values = {"name": name, "class_name": "".join(part.capitalize() for part in name.split("_"))}
    made = {folder / f"{name}.py": "effect.py.j2", folder / f"test_{name}.py": "test_effect.py.j2"}
    for path in made:
        if path.exists():
            raise FileExistsError(f"{path}: exists already; it was not changed")
    with ExitStack() as both:
        for path, template in made.items():
            unfinished = both.enter_context(whole_file(path))
            unfinished.write_text(templates.get_template(template).render(values), encoding="utf-8")
    return list(made)
