"""Tests the advice for sets that have a reference only: a further measurement of the same kind
comes first, and a capture of two heads is for a table that has them."""

from __future__ import annotations

import pickle

import numpy as np
import pytest

from arctrue.measurement import MeasurementSet, Reference, Table
from arctrue.workbench.diagnose.diagnosis import diagnose
from arctrue.workbench.diagnose.lacking import lacking_words, of_the_same_kind, separates
from arctrue.workbench.diagnose.report import sentences
from arctrue.workbench.effects.base import Parameter
from arctrue.workbench.effects.missing import (
    Missing,
    lacking_capture,
    lacking_key,
    missing_of,
)
from arctrue.workbench.effects.registry import built_in
from arctrue.workbench.model.growth import settle
from arctrue.workbench.model.model import default_model
from arctrue.workbench.observations.build import observations_of

EFFECTS = built_in()
CAPTURE = "a capture of both heads"


def test_measurements_come_before_keys_and_captures() -> None:
    said = of_the_same_kind(
        {
            "vibration": [CAPTURE],
            "gain": [f"{CAPTURE}: it gives the true size"],
            "gear": ["the key table.drive_gear_teeth"],
            "latency": ["a reference run at more than one speed"],
        }
    )
    assert said == (
        "a set that has a reference run at more than one speed; the key table.drive_gear_teeth: "
        "2 of the effects that were not tested each need one or more of these (on a table with two "
        "heads, a capture of both heads could test 2 more)"
    )
    nothing_else = of_the_same_kind({"vibration": [CAPTURE]})
    assert nothing_else.startswith("the same reference run with more turns")


def test_the_words_that_contain_others_replace_them() -> None:
    longer = f"{CAPTURE}: the table's own order 1 hides it"
    assert lacking_words([CAPTURE, longer, CAPTURE]) == [longer]
    assert lacking_words([CAPTURE]) == [CAPTURE]


@pytest.mark.parametrize(
    "item",
    [
        lacking_capture(),
        lacking_capture("the table's own order 1 hides it"),
        lacking_capture(instead="a reference run of 500 rows"),
        lacking_key("table.grating_lines"),
        lacking_key("reference.faces", "stations at the faces"),
        Missing("a reference run", reason="two heads alone cannot separate it"),
    ],
)
def test_plain_text_of_an_own_effect_has_the_kind_that_the_catalogue_declares(
    item: Missing,
) -> None:
    for other in (missing_of(str(item)), pickle.loads(pickle.dumps(item))):
        assert other == item
        assert (other.kind, other.what) == (item.kind, item.what)


def test_what_an_effect_declares_if_only_heads_would_separate_it() -> None:
    assert separates("drift", {"motion": [CAPTURE]}, "the first station again").startswith(
        "the first station again (on a table with two heads"
    )


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_a_mount_is_not_asked_for_a_capture_first(seed: int) -> None:
    """A mount follows a star over 20° in 80 minutes and drifts by 18″/h; 5 rows a minute with σ =
    1″ determine the rate to 0.14″/h (σ·√12/(√n·1.33 h), n = 400)."""
    random = np.random.default_rng(seed)
    time_s = np.arange(400) * 12.0
    error = 18.0 * time_s / 3600.0 + random.normal(0.0, 1.0, time_s.size)
    reference = Reference(time_s * 15.0 / 3600.0, error, time_s=time_s)
    observations = observations_of(MeasurementSet(Table(), None, reference, title="mount"))
    found = diagnose(observations, settle(default_model(), observations, EFFECTS), EFFECTS)
    said = " ".join(sentences(found))
    assert found.next_measurement is not None
    assert not found.next_measurement.startswith("a set that has a capture")
    assert f"a set that has {CAPTURE}" not in said
    assert found.effect_class[0] == "reference_drift"
    rate = float(said.split("rate ")[1].split("″/h")[0])
    assert rate == pytest.approx(18.0, abs=5 * 0.14)


def _faces(sigma: float) -> dict[str, Parameter]:
    values = np.array([0.1, -0.2, 0.05, -0.1, 0.12, 1.4, -0.3, 0.02, 0.1, -0.4, 0.2, -0.3])
    faces = {f"face_{face}": Parameter(it, sigma, "arcsec") for face, it in enumerate(values)}
    return {"rms": Parameter(float(np.sqrt(np.mean(values**2))), sigma, "arcsec")} | faces


def test_the_largest_faces_are_listed_with_their_angles() -> None:
    """Face 5 of 12 is read at 150°, face 9 at 270°."""
    effect = EFFECTS["polygon_face_error"]()
    said = effect.describe_values(_faces(0.03))
    # √((0.01 + 0.04 + 0.0025 + 0.01 + 0.0144 + 1.96 + 0.09 + 0.0004 + 0.01 + 0.16 + 0.04 +
    # 0.09)/12) = 0.450.
    assert said.startswith("Fitted size: 0.450″ ± 0.030″ RMS. The largest errors of the 12 faces: ")
    assert "face 5 (150° after face 0) +1.4″ (u 0.03″), face 9 (270° after face 0) -0.4″" in said
    undetermined = effect.describe_values(_faces(np.nan))
    assert "nan" not in undetermined
    assert undetermined.endswith(
        "without the orders that this set cannot separate from the table's."
    )
