"""Tests that the documentation site is complete, builds without warnings, and uses no other
server."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest
import yaml

ROOT = Path(__file__).resolve().parents[3]
DOCS = ROOT / "docs"
PARTS = ["Tutorial", "How to", "Reference", "Explanation"]
"""The four kinds of documentation according to diataxis.fr."""
FORMER = {"blind.md"}
"""Former names of pages, each of which leads to the present page for one release."""


def build(config: Path, to: Path) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-m", "mkdocs", "build", "--strict", "-f", str(config), "-d", str(to)],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=False,
        timeout=300,
        env={**os.environ, "NO_MKDOCS_2_WARNING": "1", "PYTHONPATH": str(ROOT)},
    )


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("site")
    done = build(ROOT / "mkdocs.yml", folder)
    assert done.returncode == 0, done.stdout + done.stderr
    assert "WARNING" not in done.stderr
    return folder


def test_every_page_is_on_the_site_and_its_pictures_too(site: Path) -> None:
    for page in [*DOCS.glob("*.md"), *(DOCS / "entities").glob("*.md")]:
        name = page.relative_to(DOCS).with_suffix(".html")
        made = site / (name.with_name("index.html") if page.name == "README.md" else name)
        assert made.is_file(), page
        for picture in re.findall(r'<img [^>]*src="([^"]+)"', made.read_text(encoding="utf-8")):
            assert (made.parent / picture).is_file(), f"{page}: {picture}"
    assert (site / "search" / "search_index.json").is_file()


def test_a_page_asks_no_other_server_for_anything(site: Path) -> None:
    for made in site.rglob("*.html"):
        text = made.read_text(encoding="utf-8")
        for source in re.findall(r'<(?:script|img|link|iframe)\b[^>]*(?:src|href)="([^"]+)"', text):
            assert not source.startswith(("http:", "https:", "//")), f"{made.name}: {source}"


def test_links_to_the_sources_are_shown_as_names(site: Path) -> None:
    text = (site / "own-effect.html").read_text(encoding="utf-8")
    assert "sim/arctrue/workbench/effects/base.py</code>" in text
    assert 'href="../sim' not in text


def test_the_navigation_has_four_parts_and_every_page_once() -> None:
    class Loader(yaml.SafeLoader):
        """A loader that accepts the tag with which mkdocs.yml names a Python function."""

    Loader.add_multi_constructor("tag:yaml.org,2002:python/", lambda loader, suffix, node: suffix)
    navigation = yaml.load((ROOT / "mkdocs.yml").read_text(encoding="utf-8"), Loader)["nav"]
    parts = [next(iter(item)) for item in navigation if isinstance(item, dict)]
    assert parts == PARTS
    pages = re.findall(r"[\w/-]+\.md", str(navigation))
    assert sorted(pages) == sorted(
        [*({path.name for path in DOCS.glob("*.md")} - FORMER), "entities/README.md"]
    )


@pytest.mark.parametrize(
    ("page", "said"),
    [
        ("[x](nowhere.md)", "nowhere.md"),
        ("[x](#nowhere)", "#nowhere"),
        ("![x](nowhere.png)", "nowhere.png"),
    ],
)
def test_a_dead_link_fails_the_build(tmp_path: Path, page: str, said: str) -> None:
    """With the rules of mkdocs.yml, the build fails for a site whose only page has a dead link."""
    (tmp_path / "docs").mkdir()
    (tmp_path / "docs" / "index.md").write_text(f"# Page\n\n{page}\n", encoding="utf-8")
    text = (ROOT / "mkdocs.yml").read_text(encoding="utf-8")
    rules = text[text.index("validation:") : text.index("hooks:")]
    (tmp_path / "mkdocs.yml").write_text(f"site_name: x\nstrict: true\n{rules}", encoding="utf-8")
    done = build(tmp_path / "mkdocs.yml", tmp_path / "out")
    assert done.returncode != 0
    assert said in done.stderr
