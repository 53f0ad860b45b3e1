"""Tests that every page escapes the texts that it inserts into HTML, and that only
report/html_templates.py makes HTML from templates."""

from __future__ import annotations

import re
from pathlib import Path

import arctrue
from arctrue.page.app import make_page
from arctrue.page.settings import PageSettings
from arctrue.report.html_templates import html_environment

PACKAGE = Path(arctrue.__file__).parent
TEMPLATES = sorted(path.name for path in PACKAGE.glob("*/templates/*.j2"))


def test_text_is_escaped_whatever_the_template_is_called(tmp_path: Path) -> None:
    live = make_page(PageSettings(tmp_path, tmp_path / "state")).app.jinja_env
    for environment in (html_environment(), live):
        escapes = environment.autoescape
        assert TEMPLATES
        for name in TEMPLATES:
            assert escapes is True or escapes(name), name  # type: ignore[operator]
        template = environment.from_string("{{ text }}")
        assert template.render(text="<i>'\"&") == "&lt;i&gt;&#39;&#34;&amp;"


def test_html_is_made_with_those_options_alone() -> None:
    makers = [
        path.relative_to(PACKAGE).as_posix()
        for path in PACKAGE.rglob("*.py")
        if re.search(r"\bEnvironment\(|render_template_string|\|\s*safe", path.read_text("utf-8"))
    ]
    # The other two modules in the list write Python files from templates.
    assert sorted(makers) == [
        "report/html_templates.py",
        "workbench/diagnose/adopted.py",
        "workbench/effects/new_effect.py",
    ]
