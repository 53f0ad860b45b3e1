"""Tests that CITATION.cff is valid (Citation File Format 1.2.0) and agrees with the source tree."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path
from typing import Any

import pytest
import yaml

ROOT = Path(__file__).resolve().parents[3]

# Keys from schema-guide.md of Citation File Format 1.2.0: "Required keys", "Optional keys" and the
# definitions.
REQUIRED = {"authors", "cff-version", "message", "title"}
OPTIONAL = {
    "abstract", "commit", "contact", "date-released", "doi", "identifiers", "keywords", "license",
    "license-url", "preferred-citation", "references", "repository", "repository-artifact",
    "repository-code", "type", "url", "version",
}  # fmt: skip
PERSON = {
    "address", "affiliation", "alias", "city", "country", "email", "family-names", "fax",
    "given-names", "name-particle", "name-suffix", "orcid", "post-code", "region", "tel", "website",
}  # fmt: skip
OF_A_PERSON_ALONE = {"affiliation", "family-names", "given-names", "name-particle", "name-suffix"}
ENTITY = (PERSON - OF_A_PERSON_ALONE) | {"date-end", "date-start", "location", "name"}
REFERENCE_REQUIRED = {"authors", "title", "type"}
REFERENCE_SEEN = REFERENCE_REQUIRED | {"doi", "journal", "notes", "url", "year"}


def faults(data: Any) -> list[str]:
    """Return the violations of the format in a citation file."""
    found = [f"lacks {key}" for key in sorted(REQUIRED - set(data))]
    found += [f"unknown key {key}" for key in sorted(set(data) - REQUIRED - OPTIONAL)]
    if data.get("cff-version") != "1.2.0":
        found.append("cff-version")
    if data.get("type", "software") not in ("software", "dataset"):
        found.append("type")
    texts = ("abstract", "message", "title", "version", "license")
    found += [f"{key} is no text" for key in texts if not isinstance(data.get(key, ""), str)]
    words = data.get("keywords", ["one"])
    if not words or len(set(words)) != len(words):
        found.append("keywords")
    found += _author_faults(data.get("authors", []), "authors")
    for reference in data.get("references", []):
        found += [f"reference lacks {key}" for key in REFERENCE_REQUIRED - set(reference)]
        found += [f"reference: {key}" for key in set(reference) - REFERENCE_SEEN]
        if not isinstance(reference.get("year", 1), int):
            found.append("reference: year")
        found += _author_faults(reference.get("authors", []), "reference")
    return found


def _author_faults(authors: list[dict[str, Any]], where: str) -> list[str]:
    if not authors:
        return [f"{where}: no author"]
    return [
        f"{where}: {author}"
        for author in authors
        if not author or not (set(author) <= PERSON or set(author) <= ENTITY)
    ]


@pytest.fixture(scope="module")
def citation() -> dict[str, Any]:
    return yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))


def test_it_is_by_the_format(citation: dict[str, Any]) -> None:
    assert faults(citation) == []


@pytest.mark.parametrize(
    "broken",
    [
        {"title": None},
        {"cff-version": "1.3.0"},
        {"authors": []},
        {"authors": [{"name": "A", "family-names": "B"}]},
        {"type": "hardware"},
        {"licence": "Apache-2.0"},
        {"version": 0.1},
        {"references": [{"title": "T"}]},
    ],
)
def test_a_file_that_is_not_is_noticed(citation: dict[str, Any], broken: dict[str, Any]) -> None:
    assert faults({**citation, **broken})


def test_it_says_what_the_package_says(citation: dict[str, Any]) -> None:
    package = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    assert citation["version"] == package["version"]
    assert citation["license"] == package["license"]


def test_the_paper_is_the_one_of_the_readme(citation: dict[str, Any]) -> None:
    (paper,) = citation["references"]
    readme = re.sub(r"\s+", " ", (ROOT / "README.md").read_text(encoding="utf-8"))
    names = [author["family-names"] for author in paper["authors"]]
    assert f"{', '.join(names[:-1])} and {names[-1]}, *{paper['title']}*" in readme
