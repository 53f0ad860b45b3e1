"""Writes the certificate as an HTML page for printing."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from arctrue.metrology.budget import COVERAGE
from arctrue.metrology.certificate import CertifiedError
from arctrue.metrology.certificate_details import CertificateDetails, Contact
from arctrue.report.certificate_xml import CertificateFacts
from arctrue.report.document import Document, Picture, Rows, Text, document_html
from arctrue.report.numbers import decimal
from arctrue.report.svg import AFTER, house_style


def certificate_page(
    found: CertifiedError, details: CertificateDetails, facts: CertificateFacts
) -> str:
    """Return a self-contained HTML page with the content of the XML file."""
    item = details.item
    stated = [
        ("certificate", details.number),
        ("item", ", ".join(filter(None, [item.manufacturer, item.name, item.model]))),
        ("serial number", item.serial_number),
        ("laboratory", _address(details.laboratory)),
        ("customer", _address(details.customer)),
        ("responsible", ", ".join(_person(one.name, one.role) for one in details.person)),
        ("measured", facts.measured.isoformat()),
        ("issued", facts.issued.isoformat()),
        ("measurement set", facts.title),
        ("SHA-256 of the set", facts.sha256),
        ("program", f"arctrue {facts.version}"),
        ("method", facts.method),
        ("temperature", f"{facts.temperature_c:.2f} °C"),
    ]
    digits = angle_digits(found.angle_deg)
    rows = [
        [decimal(angle, digits), decimal(error, 4), decimal(expanded, 4)]
        for angle, error, expanded in zip(
            found.angle_deg, found.error_arcsec, found.expanded_arcsec, strict=True
        )
    ]
    lines = [
        [one.quantity, one.source, one.evaluation, decimal(one.u_arcsec, 4)]
        for one in found.contributions
    ]
    fit = f"{found.u_fit_arcsec.min():.4f} to {found.u_fit_arcsec.max():.4f}"
    separation = f"{found.u_separation_arcsec.min():.4f} to {found.u_separation_arcsec.max():.4f}"
    conditions = ", ".join(f"{name} {value:g}" for name, value in found.conditions.items())
    return document_html(
        Document(
            "Calibration certificate",
            stated,
            [
                Text(
                    "Error of indication: reading of head 1 less the angle, without the mean over "
                    f"the turn, by the model {', '.join(found.effects)}"
                    f"{f' under {conditions}' if conditions else ''}."
                ),
                Picture("Error of indication with U", _picture(found)),
                Rows("Results", ("angle °", "error ″", "U ″"), rows, names=0),
                Text(
                    f"U is the expanded uncertainty, k = {COVERAGE:g}, which covers "
                    f"{100.0 * found.coverage_probability:.2f} % of a normal distribution "
                    "(JCGM 100:2008)."
                ),
                Rows(
                    "Standard uncertainties",
                    ("quantity", "source", "type", "u ″"),
                    [
                        ["fitted model", "covariance of the coefficients", "A", fit],
                        ["head separation", "mounting, ± 50″", "B", separation],
                        *lines,
                    ],
                    names=3,
                ),
            ],
        )
    )


def angle_digits(angle_deg: NDArray[np.float64]) -> int:
    """Return the number of decimals, 2 to 4, with which these angles are exact, if possible."""
    exact = (
        digits for digits in (2, 3) if np.abs(np.round(angle_deg, digits) - angle_deg).max() < 1e-9
    )
    return next(exact, 4)


def _address(contact: Contact) -> str:
    place = " ".join(filter(None, [contact.postcode, contact.city]))
    return ", ".join(filter(None, [contact.name, contact.street, place, contact.country]))


def _person(name: str, role: str | None) -> str:
    return name if role is None else f"{name} ({role})"


def _picture(found: CertifiedError) -> Figure:
    with house_style():
        figure = Figure(figsize=(8.0, 3.0), layout="constrained")
        axes = figure.subplots()
        axes.errorbar(
            found.angle_deg, found.error_arcsec, found.expanded_arcsec, fmt="o", markersize=3.0,
            color=AFTER, capsize=2.0,
        )  # fmt: skip
        axes.set_xlim(-5, 365)
        axes.set_xticks(range(0, 361, 45))
        axes.set_xlabel("angle, °")
        axes.set_ylabel("error, ″")
    return figure
