"""Writes a Digital Calibration Certificate as XML in PTB's schema DCC 3.3.0 with D-SI 2.2.1."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Iterable
from dataclasses import dataclass
from datetime import date

import numpy as np
from numpy.typing import NDArray

from arctrue.metrology.budget import COVERAGE
from arctrue.metrology.certificate import CertifiedError
from arctrue.metrology.certificate_details import CertificateDetails, Contact

DCC, SI = "https://ptb.de/dcc", "https://ptb.de/si"
SCHEMA_VERSION = "3.3.0"
SCHEMA_PLACE = f"{DCC} {DCC}/v{SCHEMA_VERSION}/dcc.xsd"
XSI = "http://www.w3.org/2001/XMLSchema-instance"
LANGUAGE = "en"
DECIMALS = 4
"""Number of decimals of every listed value. In arcseconds, the last decimal, 0.1 mas, is far below
every contribution."""


@dataclass(frozen=True)
class CertificateFacts:
    """Facts about the data and the program that the certificate states."""

    measured: date
    issued: date
    sha256: str
    """Digest of the files of the measurement set."""
    title: str
    version: str
    """Version of the program that writes the certificate, such as ``0.1.0``."""
    method: str
    temperature_c: float


def certificate_xml(
    found: CertifiedError, details: CertificateDetails, facts: CertificateFacts
) -> bytes:
    """Return the whole XML file, encoded in UTF-8."""
    ET.register_namespace("dcc", DCC)
    ET.register_namespace("si", SI)
    ET.register_namespace("xsi", XSI)
    root = ET.Element(
        f"{{{DCC}}}digitalCalibrationCertificate",
        {"schemaVersion": SCHEMA_VERSION, f"{{{XSI}}}schemaLocation": SCHEMA_PLACE},
    )
    _administrative(_add(root, "administrativeData"), details, facts)
    _results(_add(root, "measurementResults"), found, facts)
    ET.indent(root)
    text: str = ET.tostring(root, encoding="unicode")
    return f'<?xml version="1.0" encoding="UTF-8"?>\n{text}\n'.encode()


def _add(parent: ET.Element, name: str, text: str | None = None, **attributes: str) -> ET.Element:
    element = ET.SubElement(parent, f"{{{DCC}}}{name}", attributes)
    element.text = text
    return element


def _si(parent: ET.Element, name: str, text: str | None = None) -> ET.Element:
    element = ET.SubElement(parent, f"{{{SI}}}{name}")
    element.text = text
    return element


def _named(parent: ET.Element, text: str, name: str = "name") -> None:
    _add(_add(parent, name), "content", text, lang=LANGUAGE)


def _administrative(
    parent: ET.Element, details: CertificateDetails, facts: CertificateFacts
) -> None:
    _software(_add(parent, "dccSoftware"), facts)
    core = _add(parent, "coreData")
    _add(core, "countryCodeISO3166_1", details.laboratory.country)
    _add(core, "usedLangCodeISO639_1", LANGUAGE)
    _add(core, "mandatoryLangCodeISO639_1", LANGUAGE)
    _add(core, "uniqueIdentifier", details.number)
    _identified(core, "other", facts.sha256, "SHA-256 of the measurement set")
    _add(core, "beginPerformanceDate", facts.measured.isoformat())
    _add(core, "endPerformanceDate", facts.measured.isoformat())
    _add(core, "performanceLocation", details.place)
    _add(core, "issueDate", facts.issued.isoformat())
    item = _add(_add(parent, "items"), "item")
    _named(item, details.item.name)
    if details.item.manufacturer is not None:
        _named(_add(item, "manufacturer"), details.item.manufacturer)
    if details.item.model is not None:
        _add(item, "model", details.item.model)
    _identified(item, "manufacturer", details.item.serial_number, "Serial number")
    laboratory = _add(parent, "calibrationLaboratory")
    if details.laboratory.code is not None:
        _add(laboratory, "calibrationLaboratoryCode", details.laboratory.code)
    _contact(_add(laboratory, "contact"), details.laboratory)
    persons = _add(parent, "respPersons")
    for number, one in enumerate(details.person):
        person = _add(persons, "respPerson")
        _named(_add(person, "person"), one.name)
        if one.role is not None:
            _add(person, "role", one.role)
        if number == 0:
            _add(person, "mainSigner", "true")
    _contact(_add(parent, "customer"), details.customer)


def _contact(parent: ET.Element, contact: Contact) -> None:
    _named(parent, contact.name)
    if contact.email is not None:
        _add(parent, "eMail", contact.email)
    location = _add(parent, "location")
    _add(location, "city", contact.city)
    _add(location, "countryCode", contact.country)
    if contact.postcode is not None:
        _add(location, "postCode", contact.postcode)
    if contact.street is not None:
        _add(location, "street", contact.street)


def _identified(parent: ET.Element, issuer: str, value: str, name: str) -> None:
    one = _add(_add(parent, "identifications"), "identification")
    _add(one, "issuer", issuer)
    _add(one, "value", value)
    _named(one, name)


def _software(parent: ET.Element, facts: CertificateFacts) -> None:
    software = _add(parent, "software")
    _named(software, "ArcTrue")
    _add(software, "release", f"v{facts.version}")


def _results(parent: ET.Element, found: CertifiedError, facts: CertificateFacts) -> None:
    whole = _add(parent, "measurementResult")
    _named(whole, "Error of indication of head 1")
    method = _add(_add(whole, "usedMethods"), "usedMethod", refType="basic_calibrationMethod")
    _named(method, facts.method)
    described = _add(method, "description")
    _add(described, "content", described_method(found), lang=LANGUAGE)
    uncertainty = _add(whole[-1], "usedMethod", refType="basic_methodMeasurementUncertainty")
    _named(uncertainty, "Expanded uncertainty by JCGM 100:2008, k = 2")
    _software(_add(whole, "usedSoftware"), facts)
    condition = _add(
        _add(whole, "influenceConditions"), "influenceCondition", refType="basic_temperature"
    )
    _named(condition, "Temperature")
    data = _add(condition, "data")
    quantity = _add(data, "quantity")
    real = _si(quantity, "real")
    _si(real, "value", f"{facts.temperature_c:.2f}")
    _si(real, "unit", "\\degreecelsius")
    result = _add(_add(whole, "results"), "result")
    _named(result, "Error function: reading of head 1 less the angle, without the mean")
    table = _add(_add(result, "data"), "list")
    _quantity(table, "Angle", "basic_nominalValue", found.angle_deg, "\\degree", None)
    _quantity(
        table, "Error of indication", "basic_measurementError", found.error_arcsec,
        "\\arcsecond", (found.expanded_arcsec, found.coverage_probability),
    )  # fmt: skip


def described_method(found: CertifiedError) -> str:
    """Return one text that describes model, conditions and contributions."""
    lines = [f"Model: {', '.join(found.effects)}."]
    if found.conditions:
        named = ", ".join(f"{name} {value:g}" for name, value in found.conditions.items())
        lines.append(f"Conditions: {named}.")
    parts = [
        f"{one.quantity} {one.u_arcsec:.{DECIMALS}f} arcsec (type {one.evaluation})"
        for one in found.contributions
    ]
    lines.append(
        "Standard uncertainties in addition to the covariance of the fit and the head "
        f"separation: {'; '.join(parts)}."
    )
    return " ".join(lines)


def _quantity(
    parent: ET.Element, name: str, kind: str, values: NDArray[np.float64], unit: str,
    expanded: tuple[NDArray[np.float64], float] | None,
) -> None:  # fmt: skip
    quantity = _add(parent, "quantity", refType=kind)
    _named(quantity, name)
    real = _si(quantity, "realListXMLList")
    _si(real, "valueXMLList", _listed(values))
    _si(real, "unitXMLList", unit)
    if expanded is not None:
        sizes, probability = expanded
        stated = _si(_si(real, "measurementUncertaintyUnivariateXMLList"), "expandedMUXMLList")
        _si(stated, "valueExpandedMUXMLList", _listed(sizes))
        _si(stated, "coverageFactorXMLList", f"{COVERAGE:g}")
        _si(stated, "coverageProbabilityXMLList", f"{probability:g}")
        _si(stated, "distributionXMLList", "normal")


def _listed(values: Iterable[float]) -> str:
    return " ".join(f"{value:.{DECIMALS}f}" for value in values)
