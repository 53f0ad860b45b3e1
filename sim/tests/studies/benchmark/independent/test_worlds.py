"""Tests, in every world (kind of measurement set) of the independent generator, that a fit of the
true causes finds their true sizes."""

from __future__ import annotations

import tempfile
from pathlib import Path

import numpy as np
import pytest

from arctrue.measurement import MeasurementSet, read_measurement_set, write_measurement_set
from arctrue.studies.benchmark.independent import worlds as folder
from arctrue.studies.benchmark.independent.causes.cause import Cause
from arctrue.studies.benchmark.independent.noise import FlickerNoise, StateNoise
from arctrue.studies.benchmark.independent.scene import Scene, made
from arctrue.studies.benchmark.independent.sets import independent_set
from arctrue.studies.benchmark.independent.sight import needed_noncentrality
from arctrue.studies.benchmark.independent.world import HIDDEN, NOTHING, independent_worlds
from arctrue.studies.benchmark.worlds import CONTENTS, WORLDS

NAMES = list(independent_worlds())
WITH_CAUSES = [
    name
    for name, world in independent_worlds().items()
    if HIDDEN in world.contents and name != "resonance"
]
"""Worlds whose causes have a size that can be fitted. A resonance is noise, which ``test_noise``
tests."""
ROWS = 600
SEEDS = range(6)
FIVE_SIGMA = 5.0
BENT = 0.02
"""Largest relative change of a cause's form with its size. The form changes because the angle of a
row comes from a reading that contains the cause."""
ARCSEC = float(np.radians(1 / 3600))


def test_every_file_is_a_world_with_a_name_of_its_own() -> None:
    files = {path.stem for path in Path(folder.__path__[0]).glob("*.py")} - {"__init__"}
    assert set(NAMES) == files
    assert not files & set(WORLDS)
    assert HIDDEN not in CONTENTS
    for world in independent_worlds().values():
        assert world.about.endswith("."), world.name
        assert set(world.contents) <= {NOTHING, HIDDEN}


def scene_of(world: str, seed: int) -> tuple[Scene, MeasurementSet, dict[str, object]]:
    random = np.random.default_rng([seed, 1])
    scene = independent_worlds()[world].draw(random, True, ROWS)
    return scene, *made(scene, random)


def fitted(
    scene: Scene, measurement: MeasurementSet, causes: list[Cause]
) -> tuple[np.ndarray, ...]:
    """Fit the true causes to the whitened rows by least squares; return their relative sizes and
    standard deviations σ, and the residual.

    This function writes the design matrix from the rows of the set: 20 orders, an offset for each
    run of the capture, and a constant of the reference.
    """
    whole = scene.channels(causes)
    alone = [
        {
            name: whole[name]
            - scene.channels([other for other in causes if other is not cause])[name]
            for name in whole
        }
        for cause in causes
    ]
    blocks = []
    orders = np.arange(1, 21)

    def waves(angle: np.ndarray) -> np.ndarray:
        return np.hstack([np.cos(np.outer(angle, orders)), np.sin(np.outer(angle, orders))])

    capture, reference = measurement.capture, measurement.reference
    runs = 0 if capture is None else int(capture.run.max()) + 1
    if capture is not None:
        count = 2 * np.pi / scene.disc.counts_per_rev
        times = np.concatenate([run.begin_s + run.time_s for run in scene.runs])
        kept = np.isin(np.round(times, 9), np.round(capture.time_s, 9))
        angle = capture.head1_counts * count
        shown = (capture.head2_counts - capture.head1_counts) * count / ARCSEC
        base = np.hstack(
            [
                waves(angle + scene.disc.separation_rad) - waves(angle),
                np.eye(runs)[capture.run],
                np.zeros((angle.size, 1)),
            ]
        )
        signal = np.column_stack([item["capture"][kept] for item in alone])
        noise = scene.head_noise.scaled(np.sqrt(2)).with_white(count / ARCSEC / np.sqrt(6))
        rows = np.column_stack([base, signal, shown - scene.disc.separation_rad / ARCSEC])
        blocks.append(noise.whiten(rows, capture.time_s))
    if reference is not None:
        target = np.radians(reference.target_deg)
        base = np.hstack([waves(target), np.zeros((target.size, runs)), np.ones((target.size, 1))])
        signal = np.column_stack([item["reference"] for item in alone])
        noise = scene.reference_noise.with_white(scene.display_arcsec / np.sqrt(12))
        assert reference.time_s is not None
        rows = np.column_stack([base, signal, reference.error_arcsec])
        blocks.append(noise.whiten(rows, reference.time_s))
    rows = np.vstack(blocks)
    # The place of an index mark is uniform over the counts from −n to n with n = index_counts; its
    # variance is n(n + 1)/3 for each head.
    scatter = scene.disc.arcsec_per_count * np.sqrt(
        2 * scene.index_counts * (scene.index_counts + 1) / 3
    )
    held = np.zeros((runs, rows.shape[1]))
    held[:, 40 : 40 + runs] = np.eye(runs) / max(scatter, 1e-6)
    rows = np.vstack([rows, held])
    scale = np.linalg.norm(rows[:, :-1], axis=0)
    scale[scale == 0] = 1.0
    columns = rows[:, :-1] / scale
    left_vectors, values, right_vectors = np.linalg.svd(columns, full_matrices=False)
    own = values > 1e-8 * values[0]
    spread = right_vectors[own].T / values[own]
    found = spread @ (left_vectors[:, own].T @ rows[:, -1])
    left = rows[:-runs, -1] - (columns @ found)[:-runs] if runs else rows[:, -1] - columns @ found
    last = slice(-len(causes), None)
    return (found / scale)[last], (np.sqrt(np.sum(spread**2, axis=1)) / scale)[last], left


@pytest.mark.parametrize("world", WITH_CAUSES)
def test_least_squares_that_knows_the_answer_finds_it(world: str) -> None:
    """The fit finds each visible cause at its true size, and the residual of the fit equals the
    stated noise."""
    seen = 0
    for seed in SEEDS:
        scene, measurement, truth = scene_of(world, seed)
        causes = list(scene.causes)
        size, sigma, left = fitted(scene, measurement, causes)
        by_size = {(item["effect"], item["size"]): item for item in truth["effects"]}  # type: ignore[attr-defined]
        for cause, found, error in zip(causes, size, sigma, strict=True):
            item = by_size[cause.name, float(f"{cause.size:.7g}")]
            if item["noncentrality"] < item["needed"]:
                continue
            seen += 1
            about = f"{world} {seed} {cause.name}"
            assert abs(found - 1.0) < FIVE_SIGMA * error + BENT, about
            # The noncentrality that the oracle states is 1/σ² of this fit's relative size.
            assert item["noncentrality"] == pytest.approx(error**-2, rel=0.05), about
        heavy = any(
            isinstance(noise, StateNoise) and np.isfinite(noise.freedom)
            for noise in (scene.head_noise, scene.reference_noise)
        )
        rounded = isinstance(scene.reference_noise, FlickerNoise) or scene.display_arcsec
        if not heavy and not rounded and left.size > 200:
            freedom = left.size - 60
            assert 0.8 < float(left @ left) / freedom < 1.2, f"{world} {seed}"
    assert seen >= 2, world


@pytest.mark.parametrize("world", NAMES)
def test_a_set_is_its_seed_and_is_written_and_read_without_its_truth(world: str) -> None:
    content = independent_worlds()[world].contents[-1]
    first, truth = independent_set(world, content, 3, ROWS)
    second, again = independent_set(world, content, 3, ROWS)
    assert truth == again
    with tempfile.TemporaryDirectory() as place:
        for name, item in (("a", first), ("b", second)):
            write_measurement_set(Path(place) / name, item)
        for file in (Path(place) / "a").iterdir():
            assert file.read_bytes() == (Path(place) / "b" / file.name).read_bytes()
            text = file.read_text(encoding="utf-8").replace("head_separation_deg", "")
            assert not any(item["effect"] in text for item in truth["effects"])
        read = read_measurement_set(Path(place) / "a")
    assert not read.warnings
    assert (read.capture is None) == (first.capture is None)


@pytest.mark.parametrize(
    "world", [n for n, w in independent_worlds().items() if NOTHING in w.contents]
)
def test_nothing_is_nothing(world: str) -> None:
    _, truth = independent_set(world, NOTHING, 5, ROWS)
    assert truth["effects"] == []
    assert not truth["accepted"]["names"] or HIDDEN in independent_worlds()[world].contents


def test_a_content_that_a_world_does_not_have_is_refused() -> None:
    with pytest.raises(ValueError, match="nulls has the contents nothing, not hidden"):
        independent_set("nulls", HIDDEN, 1, ROWS)


def test_needed_noncentrality_is_that_of_the_tables() -> None:
    """The needed noncentrality equals that of tables of χ²: (2.5758 + 1.6449)² for one degree of
    freedom, 1 % two-sided and a power of 95 %."""
    assert needed_noncentrality(1, 1) == pytest.approx((2.5758 + 1.6449) ** 2, rel=1e-3)
    assert needed_noncentrality(2, 1000) > needed_noncentrality(2, 1) > needed_noncentrality(1, 1)
