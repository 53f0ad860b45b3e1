"""Reads the user's TOML file with the item, laboratory and persons that the certificate states."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

from msgspec import Meta, Struct

from arctrue.base.printable import one_line
from arctrue.base.toml_file import TomlContentError, read_toml
from arctrue.base.typed_content import ContentError, Number, line_of_text, typed, unknown_keys

Text = Annotated[str, Meta(min_length=1)]
Country = Annotated[str, Meta(pattern="^[A-Z]{2}$", description="two capitals, ISO 3166-1")]


class Contact(Struct, frozen=True):
    """Name and address of a laboratory or a customer."""

    name: Text
    city: Text
    country: Country
    street: Text | None = None
    postcode: Text | None = None
    email: Text | None = None


class Laboratory(Contact, frozen=True):
    """The laboratory that calibrated the table; ``code`` is its accreditation number."""

    code: Text | None = None


class Item(Struct, frozen=True):
    """The table that was calibrated."""

    name: Text
    serial_number: Text
    manufacturer: Text | None = None
    model: Text | None = None


class Person(Struct, frozen=True):
    """A responsible person; the first person in the file signs the certificate."""

    name: Text
    role: Text | None = None


class CertificateDetails(Struct, frozen=True):
    """Content of the user's whole file."""

    number: Text
    """Unique identifier of the certificate."""
    item: Item
    laboratory: Laboratory
    customer: Contact
    person: Annotated[tuple[Person, ...], Meta(min_length=1)]
    place: Literal["laboratory", "customer", "laboratoryBranch", "customerBranch", "other"] = (
        "laboratory"
    )
    temperature_c: Number | None = None
    """Ambient temperature; it is used if the measurement set records none."""

    def __post_init__(self) -> None:
        """Check the texts. Raises ValueError for a text of more than one printable line, or a text
        of only blanks."""
        line_of_text(self.number, "number")
        named = (("item", self.item), ("laboratory", self.laboratory), ("customer", self.customer))
        for key, part in (*named, *(("person", one) for one in self.person)):
            for name in part.__struct_fields__:
                value = getattr(part, name)
                if isinstance(value, str):
                    line_of_text(value, f"{key}.{name}")
                    if not value.strip():
                        raise ValueError(f"{key}.{name}: expected a text, found only blanks")


def read_details(path: Path) -> CertificateDetails:
    """Read the user's file. Raises ValueError naming file and key for a missing or wrong value."""
    try:
        content = read_toml(path)
        found = typed(content, CertificateDetails)
    except (TomlContentError, ContentError) as error:
        raise ValueError(f"{path}: {error}") from error
    for key, near in unknown_keys(content, CertificateDetails).items():
        meant = f"; did you mean {' or '.join(near)}?" if near else ""
        raise ValueError(f"{path}: {one_line(key)}: is not known{meant}")
    return found
