"""Validates a certificate against the official schema; the user supplies a copy of the schema."""

from __future__ import annotations

import io
import xml.etree.ElementTree as ET
from pathlib import Path

from arctrue.base.extras import optional


def check_schema(content: bytes, schema_file: Path) -> None:
    """Validate XML against ``dcc.xsd`` and the schemas in the same folder; nothing is downloaded.

    Raises ValueError with the first fault, or if the schema cannot be used (for example because an
    imported schema is missing); MissingExtraError without the package xmlschema.
    """
    xmlschema = optional("xmlschema")
    places: dict[str, list[str]] = {}
    for path in sorted(schema_file.parent.glob("*.xsd")):
        if path.resolve() != schema_file.resolve():
            try:
                namespace = ET.parse(path).getroot().get("targetNamespace", "")
            except ET.ParseError as error:
                raise ValueError(f"{path}: is not XML: {error}") from error
            places.setdefault(namespace, []).append(str(path.resolve()))
    try:
        schema = xmlschema.XMLSchema10(str(schema_file), locations=places, allow="local")
        fault = next(schema.iter_errors(io.BytesIO(content)), None)
    except xmlschema.XMLSchemaException as error:
        raise ValueError(f"{schema_file}: cannot be used as a schema: {error}") from error
    if fault is not None:
        raise ValueError(f"{schema_file}: refuses {fault.path}: {fault.reason}")
