"""Tests of certificates: their uncertainty against Monte Carlo, their file against PTB's
Schematron, and sets that are refused."""

from __future__ import annotations

import re
import xml.etree.ElementTree as ET
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner, Result
from numpy.typing import NDArray
from scipy import stats

from arctrue.cli import main
from arctrue.cli.certificate import angles_deg, method_of
from arctrue.measurement import Capture, MeasurementSet, Reference, Table, write_measurement_set
from arctrue.measurement.digest import set_digest
from arctrue.metrology.budget import REVERSAL
from arctrue.metrology.certificate import SHIFT_ARCSEC, CertifiedError, certified_error
from arctrue.report.certificate_page import angle_digits
from arctrue.workbench.effects.registry import catalogue
from arctrue.workbench.model.model import Model, ModelEffect, default_model
from tests.workbench.small_sets import measurement_set

Float = NDArray[np.float64]

SURE = 1e-3
"""Probability that a correct program fails one of the tests that count random cases."""
ANGLES = np.arange(0.0, 360.0, 30.0)
NOISE, U_REFERENCE = 0.2, 0.1
COUNTS = 1 << 24
DETAILS = """number = "AT-2026-001"
[item]
name = "Rotary table"
serial_number = "0042"
manufacturer = "Example & Sons"
[laboratory]
name = "Angle laboratory"
city = "Braunschweig"
country = "DE"
street = "Road 1"
postcode = "38116"
code = "D-K-0"
email = "lab@example.org"
[customer]
name = "Observatory"
city = "Garching"
country = "DE"
[[person]]
name = "A. Person"
role = "head of laboratory"
[[person]]
name = "B. Person"
"""


def model(*orders: int) -> Model:
    entry = ModelEffect("graduation_harmonics", {"orders": list(orders)})
    return replace(default_model(), effects=[entry])


def true_error(angle: Float) -> Float:
    return np.asarray(2.0 * np.cos(angle + 0.3) + 0.5 * np.cos(2.0 * angle - 1.0))


def reference_set(random: np.random.Generator) -> MeasurementSet:
    """Return a reference run of ten turns over 24 faces; the reference instrument has a constant
    error and a random error."""
    target = np.tile(np.arange(24) * 15.0, 10)
    error = true_error(np.radians(target)) + NOISE * random.standard_normal(240)
    error = error + U_REFERENCE * random.standard_normal()
    rows = Reference(
        target_deg=target,
        error_arcsec=error,
        cycle=np.repeat(np.arange(10), 24),
        temperature_c=np.full(240, 20.0),
        faces=24,
        instrument="polygon",
        standard_uncertainty_arcsec=U_REFERENCE,
    )
    return MeasurementSet(Table(counts_per_rev=COUNTS), reference=rows, title="a < b & c")


@pytest.mark.large
def test_the_uncertainty_of_the_fit_is_that_of_monte_carlo() -> None:
    random, number = np.random.default_rng(1), 80
    made = [
        certified_error(reference_set(random), model(1, 2), catalogue(), ANGLES, {})
        for _ in range(number)
    ]
    off = np.array([one.error_arcsec - true_error(np.radians(ANGLES)) for one in made])
    stated = np.mean([np.mean(one.u_fit_arcsec**2) for one in made])
    # With 4 coefficients, the mean square over the turn has about 4 · 80 degrees of freedom.
    freedom = 4 * number
    ratio = float(np.mean(off**2)) / float(stated)
    assert stats.chi2.ppf(SURE, freedom) / freedom <= ratio
    assert ratio <= stats.chi2.ppf(1.0 - SURE, freedom) / freedom
    # U includes the constant error of the reference, so that U covers the error in at least 95 % of
    # the cases.
    constant = U_REFERENCE * random.standard_normal((number, 1))
    half = 0.5 * 360.0 * 3600.0 / COUNTS
    counts = random.uniform(-half, half, (number, 2)).sum(axis=1)[:, None]
    expanded = np.array([one.expanded_arcsec for one in made])
    held = np.abs(off + constant + counts) <= expanded
    assert held[:, 0].sum() >= stats.binom.ppf(SURE, number, 0.95)


def reversal_arcsec(rows: Reference) -> float:
    """Return the certificate's contribution of the reversal error for these rows."""
    made = MeasurementSet(Table(counts_per_rev=COUNTS), reference=rows, title="reversal")
    found = certified_error(made, model(1), catalogue(), ANGLES, {})
    return next(one.u_arcsec for one in found.contributions if one.quantity == REVERSAL)


def up_and_down(reversal: float) -> Reference:
    """Return three runs up and three runs down over 24 targets, with an eccentricity of 100″ and a
    reversal error."""
    once, random = np.arange(24) * 15.0, np.random.default_rng(1)
    target = np.concatenate([once, once[::-1]] * 3)
    direction = np.tile(np.repeat([1, -1], 24), 3)
    noise = 0.05 * random.standard_normal(target.size)
    return Reference(
        target_deg=target,
        error_arcsec=100.0 * np.cos(np.radians(target)) + 0.5 * reversal * direction + noise,
        direction=direction,
        run=np.repeat(np.arange(6), 24),
        standard_uncertainty_arcsec=0.05,
        instrument="polygon",
    )


def test_the_reversal_error_is_that_of_the_residual_of_the_used_rows() -> None:
    """Neither a masked row nor a target that one direction lacks adds a reversal error. The bound
    is four standard errors of half the difference of two means of 72 rows."""
    bound = 4.0 * 0.05 / np.sqrt(144.0)
    plain = up_and_down(0.0)
    assert reversal_arcsec(plain) < bound
    mask = np.arange(144) == 5
    masked = replace(plain, error_arcsec=plain.error_arcsec + 3600.0 * mask, mask=mask)
    assert reversal_arcsec(masked) < bound
    assert reversal_arcsec(plain.where(~((plain.target_deg == 0.0) & (plain.direction == 1)))) < (
        bound * np.sqrt(72.0 / 69.0)
    )
    assert reversal_arcsec(up_and_down(3.0)) == pytest.approx(1.5, abs=bound)


@pytest.mark.parametrize("heads", [3, pytest.param(4, marks=pytest.mark.large)])
def test_the_mounting_of_every_head_adds_to_the_uncertainty(heads: int) -> None:
    """The contribution of the heads' places is the root of the sum of squares over all heads except
    head 1. The test moves each place and takes the difference of the certified errors."""
    places = (0.0, 64.3, 177.0, 257.9)[:heads]
    angle, random = 2.0 * np.pi * np.arange(900) / 900, np.random.default_rng(0)
    columns = {}
    for number, place in enumerate(places, start=1):
        disc = angle + np.radians(place)
        error = 1000.0 * np.cos(disc) + 300.0 * np.cos(3.0 * disc)
        error += 0.02 * random.standard_normal(disc.size)
        turn = disc / (2.0 * np.pi) + error / 1_296_000
        columns[f"head{number}_counts"] = np.rint(turn * COUNTS).astype(np.int64)
    capture = Capture(run=np.zeros(900, dtype=np.int64), time_s=np.arange(900) * 1e-3, **columns)  # type: ignore[arg-type]

    def certified(*moved_deg: float) -> CertifiedError:
        table = Table(counts_per_rev=COUNTS, head_places_deg=moved_deg)
        made = MeasurementSet(table, capture=capture, title="heads")
        return certified_error(made, model(1, 3), catalogue(), ANGLES, {})

    found, square = certified(*places), np.zeros(ANGLES.size)
    for head in range(1, heads):
        moved = certified(*(places + np.eye(heads)[head] * SHIFT_ARCSEC / 3600.0))
        slope = (moved.error_arcsec - found.error_arcsec) / SHIFT_ARCSEC
        square += (slope * 50.0) ** 2 / 3.0
    np.testing.assert_allclose(found.u_separation_arcsec, np.sqrt(square), rtol=1e-6)
    measured = MeasurementSet(
        Table(counts_per_rev=COUNTS, head_places_deg=places), capture=capture, title="heads"
    )
    assert f"with {('three', 'four')[heads - 3]} read heads" in method_of(measured).lower()


def test_u_is_the_root_of_the_sum_of_squares() -> None:
    found = certified_error(
        reference_set(np.random.default_rng(2)), model(1, 2), catalogue(), ANGLES, {}
    )
    parts = {one.quantity: one.u_arcsec for one in found.contributions}
    assert parts["reference instrument"] == U_REFERENCE
    half = 0.5 * 360.0 * 3600.0 / COUNTS / np.sqrt(3.0)
    assert parts["reading of head 1, resolution"] == pytest.approx(half)
    square = found.u_fit_arcsec**2 + sum(value**2 for value in parts.values())
    np.testing.assert_allclose(found.expanded_arcsec, 2.0 * np.sqrt(square))
    # With white noise in 240 rows at even angles, a coefficient of an order has u² = 2σ²/240.
    np.testing.assert_allclose(
        found.u_fit_arcsec, NOISE * np.sqrt(4.0 / 240.0), rtol=4.0 / np.sqrt(2 * 240)
    )


def test_the_sensitivity_to_the_head_separation_is_that_of_the_equation() -> None:
    """The certificate's sensitivity to the head separation is ∂ε/∂α = −Re Σ Eₙ·jn·e^{jnα}/(e^{jnα}
    − 1)·e^{jnθ}, which follows from E = D/(e^{jnα} − 1)."""
    amplitude = 90.0
    made = measurement_set(
        lambda disc, *_: amplitude * np.cos(disc + 0.4), seed=1, runs=1, turns=2, reference=False
    )
    found = certified_error(made, model(1), catalogue(), ANGLES, {})
    alpha = np.radians(33.0)
    turned = np.exp(1j * alpha)
    component = amplitude * np.exp(0.4j)
    slope = (-component * 1j * turned / (turned - 1.0) * np.exp(1j * np.radians(ANGLES))).real
    expected = np.abs(slope) * np.pi / 648_000.0 * 50.0 / np.sqrt(3.0)
    # Both runs have the same rounding, so that the finite difference is exact up to the second
    # order of the shift.
    np.testing.assert_allclose(found.u_separation_arcsec, expected, atol=0.02 * expected.max())
    assert SHIFT_ARCSEC < 50.0


@pytest.fixture(scope="module")
def place(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("certificate")
    made = replace(reference_set(np.random.default_rng(3)), date=datetime(2026, 3, 12, tzinfo=UTC))
    write_measurement_set(folder / "set", made)
    (folder / "details.toml").write_text(DETAILS, encoding="utf-8")
    words = ["set", "--details", "details.toml", "--out", "certificate.xml", "--model", "m.toml"]
    added = CliRunner().invoke(
        main,
        [
            *("add", "graduation_harmonics", str(folder / "set")),
            *("--model", str(folder / "m.toml"), "--set", "orders=[1, 2]"),
        ],
    )
    assert added.exit_code == 0, added.output
    done = certificate(folder, *words)
    assert done.exit_code == 0, done.output
    return folder


def certificate(folder: Path, *words: str) -> Result:
    files = {"set", "other", "details.toml", "certificate.xml", "no.xml", "m.toml", "dcc.xsd"}
    named = [str(folder / word) if word in files or "/" in word else word for word in words]
    return CliRunner().invoke(main, ["certificate", *named])


NAMES = {"dcc": "https://ptb.de/dcc", "si": "https://ptb.de/si"}


def test_the_file_has_what_was_found_and_stated(place: Path) -> None:
    root = ET.parse(place / "certificate.xml").getroot()

    def text(path: str) -> str:
        element = root.find(path, NAMES)
        assert element is not None, path
        return element.text or ""

    assert root.get("schemaVersion") == "3.3.0"
    assert text(".//dcc:uniqueIdentifier") == "AT-2026-001"
    assert text(".//dcc:item/dcc:identifications/dcc:identification/dcc:value") == "0042"
    assert text(".//dcc:item/dcc:manufacturer/dcc:name/dcc:content") == "Example & Sons"
    assert text(".//dcc:coreData/dcc:identifications/dcc:identification/dcc:value") == set_digest(
        place / "set"
    )
    assert text(".//dcc:beginPerformanceDate") == "2026-03-12"
    assert text(".//dcc:usedSoftware/dcc:software/dcc:release") == "v0.1.0"
    values = [
        np.array([float(item) for item in (element.text or "").split()])
        for element in root.iterfind(".//si:valueXMLList", NAMES)
    ]
    np.testing.assert_allclose(values[0], np.arange(24) * 15.0)
    expanded = np.array([float(x) for x in text(".//si:valueExpandedMUXMLList").split()])
    assert expanded.shape == values[1].shape == (24,)
    off = np.abs(values[1] - true_error(np.radians(values[0])))
    # The constant error of the reference is not in these values, because the fit separates it from
    # the orders; the error of the fit is much smaller than U.
    assert (off <= expanded).all()
    assert text(".//si:coverageFactorXMLList") == "2"
    assert text(".//si:coverageProbabilityXMLList") == "0.9545"
    page = (place / "certificate.html").read_text(encoding="utf-8")
    assert "AT-2026-001" in page
    assert "Example &amp; Sons" in page
    assert set_digest(place / "set") in page


def test_ptbs_schematron_accepts_it(place: Path) -> None:
    validation = pytest.importorskip("dcclib.validation.schematron")
    found = validation.SchematronValidator.for_dcc().validate_file(str(place / "certificate.xml"))
    assert found.is_valid, found.failed_assertions
    roles = {report.__dict__.get("role") for report in found.successful_reports}
    assert not roles & {"error", "warning"}


@pytest.mark.parametrize(
    ("line", "said"),
    [
        ('serial_number = "0042"\n', "item.serial_number: is missing"),
        ('number = "AT-2026-001"\n', "number: is missing"),
        ('[[person]]\nname = "A. Person"\nrole = "head of laboratory"\n', ""),
        (
            '[customer]\nname = "Observatory"\ncity = "Garching"\ncountry = "DE"\n',
            "customer: is missing",
        ),
    ],
)
def test_what_is_missing_is_named_and_nothing_is_written(
    place: Path, tmp_path: Path, line: str, said: str
) -> None:
    text = DETAILS.replace(line, "")
    if not said:
        text, said = re.sub(r"\[\[person\]\][^[]*", "", DETAILS), "person"
    (tmp_path / "details.toml").write_text(text, encoding="utf-8")
    done = CliRunner().invoke(
        main,
        [
            *("certificate", str(place / "set"), "--details", str(tmp_path / "details.toml")),
            *("--out", str(tmp_path / "no.xml")),
        ],
    )
    assert done.exit_code == 2
    assert "details.toml" in done.stderr
    assert said in " ".join(done.stderr.split())
    assert not (tmp_path / "no.xml").exists()


def refused(place: Path, made: MeasurementSet, tmp_path: Path) -> str:
    write_measurement_set(tmp_path / "other", made)
    done = CliRunner().invoke(
        main,
        [
            *("certificate", str(tmp_path / "other"), "--details", str(place / "details.toml")),
            *("--out", str(tmp_path / "no.xml"), "--model", str(place / "m.toml")),
        ],
    )
    assert done.exit_code == 2
    assert not (tmp_path / "no.xml").exists()
    return " ".join(done.stderr.split())


def test_a_set_without_date_uncertainty_or_temperature_is_refused(
    place: Path, tmp_path: Path
) -> None:
    made = replace(reference_set(np.random.default_rng(3)), date=datetime(2026, 3, 12, tzinfo=UTC))
    assert made.reference is not None
    assert "states no date; a certificate needs it" in refused(
        place, replace(made, date=None), tmp_path
    )
    without_u = replace(made.reference, standard_uncertainty_arcsec=None)
    assert "reference.standard_uncertainty_arcsec is not stated" in refused(
        place, replace(made, reference=without_u), tmp_path
    )
    cold = replace(made, reference=replace(made.reference, temperature_c=None))
    assert "temperature_c: is missing; the set records no temperature" in refused(
        place, cold, tmp_path
    )


def test_an_error_that_no_row_determines_is_not_certified(place: Path, tmp_path: Path) -> None:
    """24 stations, 15° apart, do not separate order 4 from order 20; three stations separate
    nothing over the turn. The covariance of a fit contains no uncertainty for a coefficient that no
    row determines."""
    made = reference_set(np.random.default_rng(4))
    rows = made.reference
    assert rows is not None
    with pytest.raises(ValueError, match=r"does not determine the error at 5°.*(cos|sin) "):
        certified_error(made, default_model(), catalogue(), np.array([0.0, 5.0, 15.0]), {})
    three = replace(made, reference=rows.where(rows.target_deg < 45.0))
    with pytest.raises(ValueError, match="does not determine the error at 0°"):
        certified_error(three, model(1, 2), catalogue(), ANGLES, {})
    # At a station, the sum of the aliases is determined. The bound is five standard deviations of
    # the mean of ten readings.
    found = certified_error(made, default_model(), catalogue(), ANGLES, {})
    off = found.error_arcsec - true_error(np.radians(ANGLES))
    assert np.abs(off).max() < 5.0 * NOISE / np.sqrt(10.0)
    # Without --model, the command fits the orders that the stations separate: 1 to 11.
    write_measurement_set(tmp_path / "set", replace(made, date=datetime(2026, 3, 12, tzinfo=UTC)))
    out = tmp_path / "certificate.xml"
    words = ("--details", place / "details.toml", "--out", out, "--step", "5")
    done = CliRunner().invoke(main, ["certificate", str(tmp_path / "set"), *map(str, words)])
    assert done.exit_code == 0, done.output
    assert out.exists()


def test_a_model_alone_is_refused(place: Path) -> None:
    done = certificate(place, "m.toml", "--details", "details.toml", "--out", "no.xml")
    assert done.exit_code == 2
    assert "a model alone has no covariance" in " ".join(done.stderr.split())


@pytest.mark.parametrize("number", [1, 7, 49, 360, 1233, 2880, 3599])
def test_equal_steps_do_not_reach_the_full_turn(number: int) -> None:
    """A step of 1/n turn gives n angles, and none of them is 360°, even if the step is rounded
    down. The page shows each angle with the decimals that it needs."""
    for step in (360.0 / number, np.nextafter(360.0 / number, 0.0)):
        angle = angles_deg(step)
        np.testing.assert_allclose(angle, np.arange(number) * 360.0 / number, atol=1e-9)
    places = (np.array([0.5, 15.0]), 2), (angles_deg(0.125), 3), (angles_deg(360.0 / 7.0), 4)
    assert [angle_digits(angle) for angle, _ in places] == [digits for _, digits in places]


SCHEMA = """<xs:schema xmlns:xs="http://www.w3.org/2001/XMLSchema" xmlns:dcc="https://ptb.de/dcc"
  targetNamespace="https://ptb.de/dcc" elementFormDefault="qualified">
  <xs:import namespace="https://ptb.de/si" schemaLocation="https://ptb.de/si/none.xsd"/>
  <xs:element name="digitalCalibrationCertificate"><xs:complexType><xs:sequence>
    <xs:any processContents="skip" minOccurs="{least}" maxOccurs="unbounded"/>
  </xs:sequence><xs:attribute name="schemaVersion"/></xs:complexType></xs:element>
</xs:schema>"""
SI_SCHEMA = """<xs:schema xmlns:xs="http://www.w3.org/2001/XMLSchema"
  targetNamespace="https://ptb.de/si"/>"""


def test_a_schema_of_the_user_decides(place: Path, tmp_path: Path) -> None:
    """The command accepts or refuses the certificate by the user's schema.

    The schema imports another schema from a server; the folder has a copy of the imported schema.
    """
    pytest.importorskip("xmlschema")
    (tmp_path / "SI_Format.xsd").write_text(SI_SCHEMA, encoding="utf-8")
    words = ["set", "--details", "details.toml", "--out", "certificate.xml", "--model", "m.toml"]
    for least, code in ((2, 0), (3, 2)):
        (tmp_path / "dcc.xsd").write_text(SCHEMA.format(least=least), encoding="utf-8")
        done = certificate(place, *words, "--schema", str(tmp_path / "dcc.xsd"))
        assert done.exit_code == code, done.output
    assert "dcc.xsd: refuses /dcc:digitalCalibrationCertificate" in " ".join(done.stderr.split())


def test_the_uncertainty_contains_that_of_an_order() -> None:
    """At an angle θ far outside the measured angles, an uncertainty δn of the order of a line of
    amplitude A gives A·(θ − θ₀)·|sin(nθ + φ)|·δn, which is larger than every other contribution;
    θ₀ is the mean of the measured angles."""
    random = np.random.default_rng(7)
    angle = np.sort(random.uniform(0.0, 1440.0, 200))
    noise = random.normal(0.0, 0.1, angle.size)
    error = 0.6 * np.cos(7.3 * np.deg2rad(angle) + 1.0) + noise
    made = MeasurementSet(
        Table(counts_per_rev=COUNTS),
        None,
        Reference(target_deg=angle, error_arcsec=error, standard_uncertainty_arcsec=U_REFERENCE),
    )
    line = Model(effects=[ModelEffect("periodic_error", {})])
    far = np.array([36000.0, 36010.0])
    found = certified_error(made, line, catalogue(), far, {})
    ((order, amplitude, phase),) = [
        (item["order"], item["amplitude"].value, item["phase"].value)
        for item in found.solution.parameters()
    ]
    sine = np.abs(np.sin(order.value * np.deg2rad(far) + np.deg2rad(phase)))
    expected = amplitude * np.deg2rad(far - angle.mean()) * sine * order.sigma
    np.testing.assert_allclose(found.u_fit_arcsec, expected, rtol=0.1)
