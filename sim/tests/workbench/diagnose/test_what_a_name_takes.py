"""Tests that the diagnosis names an effect for the error that the effect removes, and reports a
further error as a separate detection."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from sim.tests.workbench.reversal_sets import REVERSAL, VARIES, reversal_set
from sim.tests.workbench.small_sets import measurement_set, paper_error

from arctrue.measurement import MeasurementSet, Reference, Table
from arctrue.studies.benchmark.diagnosis import diagnosed
from arctrue.workbench.diagnose.case import Case
from arctrue.workbench.diagnose.diagnosis import diagnose
from arctrue.workbench.diagnose.lack_of_fit import LACK_OF_FIT, LEAST_EXCESS
from arctrue.workbench.diagnose.next_measurement import has_already, measurement_for_parts
from arctrue.workbench.diagnose.remaining_error import varies
from arctrue.workbench.diagnose.report import sentences
from arctrue.workbench.diagnose.report_json import diagnosis_data
from arctrue.workbench.diagnose.rules.best_effect import LEAST_TAKEN
from arctrue.workbench.diagnose.rules.removes_little import RISES, makes_it_worse, takes_little
from arctrue.workbench.diagnose.rules.table import said_of
from arctrue.workbench.diagnose.survey import LEAST_HELD_OUT
from arctrue.workbench.effects.part_conditions import SIMPLE_CONDITIONS, column_condition
from arctrue.workbench.effects.product_of_parts import ProductOfParts
from arctrue.workbench.effects.registry import built_in
from arctrue.workbench.inference.block_share import BLOCKS, block_share, share_of
from arctrue.workbench.inference.design_matrix import Term
from arctrue.workbench.inference.fit import fit
from arctrue.workbench.inference.residuals import Residuals
from arctrue.workbench.observations import Observations
from arctrue.workbench.observations.build import observations_of

EFFECTS = built_in()


@pytest.mark.parametrize(
    ("stations", "noise"),
    [
        pytest.param(36, 0.05, marks=pytest.mark.large),
        (24, 0.01),
        pytest.param(72, 0.1, marks=pytest.mark.large),
    ],
)
def test_a_reversal_error_that_differs_from_place_to_place_keeps_its_name(
    stations: int, noise: float
) -> None:
    """A reversal error that differs from place to place keeps its name, and its variation by a
    fifth remains as an error. The repeats have so little noise that the variation is as
    significant as the whole error."""
    _, found = diagnosed(reversal_set(stations=stations, noise=noise))
    assert found.named is not None
    assert found.named.name == "hysteresis"
    size = found.named.parameters()["reversal_error"].value
    # The sizes at the places were drawn with the mean 1, so that the mean over all stations is the
    # size.
    assert abs(size) == pytest.approx(REVERSAL, rel=0.02)
    assert found.second is not None
    assert found.second.channel == "reference"
    assert found.second.variation == pytest.approx(VARIES, rel=0.1)
    reported = " ".join(sentences(found))
    assert "differs by ±20 % from place to place" in reported
    assert diagnosis_data(found, [])["second_finding"]["variation"] == found.second.variation
    # The size is printed with its uncertainty.
    assert f"reversal error {size:.1f}"[:-1] in reported
    # The set already has both directions.
    assert "other direction" not in reported


def test_a_reversal_error_that_is_the_same_everywhere_leaves_no_error() -> None:
    _, found = diagnosed(reversal_set(varies=0.0))
    assert found.named is not None
    assert found.second is None


def test_the_variation_is_that_which_was_drawn() -> None:
    """The stated variation equals the standard deviation of the sizes that the test drew: the error
    is ±(1 + δ), with its own δ at each of 40 places, which are visited 6 times each."""
    random = np.random.default_rng(5)
    place = np.repeat(np.arange(40), 6)
    side = np.tile([1.0, -1.0], 120)
    factor = random.normal(0.0, 0.3, 40)
    noise = random.normal(0.0, 0.1, 240)
    found = varies(side, factor[place] * side + noise, place, 0.1)
    assert found is not None
    # A standard deviation from 40 draws would scatter by 11 %; the test therefore compares with the
    # draws themselves.
    assert found == pytest.approx(float(np.sqrt(np.mean(factor**2))), rel=0.05)
    assert varies(side, noise, place, 0.1) is None
    # An error that is the same in both directions is no variation of the reversal error.
    assert varies(factor[place], factor[place] + noise, place, 0.1) is None


@pytest.mark.parametrize("condition", SIMPLE_CONDITIONS)
def test_no_advice_asks_for_what_the_set_holds(condition) -> None:  # type: ignore[no-untyped-def]
    """The advice requests neither another direction, another speed nor a warm run, because the set
    already has these."""
    whole = observations_of(measurement_set(turns=1, cycles=1))
    for part in ("direction", "speed", "temperature"):
        assert has_already(part, whole)
    advice = measurement_for_parts(ProductOfParts.of(condition, (2.0,), "disc"), whole)
    assert advice.kind not in ("direction", "speed", "warm")


def _with_load(load: np.ndarray) -> Observations:
    size = load.size
    reference = Reference(
        target_deg=np.tile(np.arange(size // 4) * 1440.0 / size, 4),
        error_arcsec=np.random.default_rng(3).normal(0.0, 1.0, size),
        time_s=5.0 * np.arange(size),
        conditions={"load_nm": load},
    )
    return observations_of(MeasurementSet(Table(), None, reference))


@pytest.mark.parametrize("orders", [(), (2.0,)])
def test_no_advice_asks_for_another_load_if_the_set_has_many(orders: tuple[float, ...]) -> None:
    """Loads at random, and loads that rise and fall, between 0 and 40 N·m."""
    random = np.random.default_rng(4).uniform(0.0, 40.0, 96)
    random[:2] = 0.0, 40.0
    swing = 20.0 - 20.0 * np.cos(2.0 * np.pi * np.arange(97)[:96] / 32.0)
    product = ProductOfParts.of(column_condition("load_nm", 20.0), orders, "reference")
    for load in (random, swing):
        advice = measurement_for_parts(product, _with_load(load))
        assert "load_nm outside 0 to 40 N·m" in advice.words


@pytest.mark.parametrize("load", [np.repeat([0.0, 10.0], 48), np.linspace(5.0, 10.0, 96)])
def test_a_load_that_changed_once_is_asked_for_again(load: np.ndarray) -> None:
    product = ProductOfParts.of(column_condition("load_nm", 5.0), (), "reference")
    assert "another load_nm, all else" in measurement_for_parts(product, _with_load(load)).words


@pytest.mark.parametrize("condition", SIMPLE_CONDITIONS)
def test_no_polygon_is_put_on_again_for_an_error_of_a_condition(
    condition,
) -> None:  # type: ignore[no-untyped-def]
    """An error that depends on the direction, the temperature, the speed or the time cannot move
    with the polygon. The set already has both directions, several speeds and temperatures."""
    whole = observations_of(measurement_set(turns=1, cycles=1))
    advice = measurement_for_parts(ProductOfParts.of(condition, (2.0,), "reference"), whole)
    assert "polygon" not in advice.words


def _blocks(coefficients: np.ndarray, columns: np.ndarray, noise: float = 1.0, seed: int = 0):  # type: ignore[no-untyped-def]
    """Return the normal matrix and the moments of each block; the blocks' true coefficients have
    the shape (blocks, q)."""
    random = np.random.default_rng(seed)
    block = np.arange(columns.shape[0]) * BLOCKS // columns.shape[0]
    measured = np.sum(columns * coefficients[block], axis=1)
    measured = measured + random.normal(0.0, noise, block.size)
    parts = [columns[block == number] for number in range(BLOCKS)]
    values = [measured[block == number] for number in range(BLOCKS)]
    return (
        np.array([part.T @ part for part in parts]),
        np.array([part.T @ value for part, value in zip(parts, values, strict=True)]),
    )


def test_what_is_the_same_in_all_blocks_is_predicted_and_what_changes_is_not() -> None:
    columns = np.random.default_rng(1).normal(size=(600, 2))
    same = np.tile([0.6, -0.4], (BLOCKS, 1))
    shares = [share_of(*_blocks(same, columns, seed=seed)) for seed in range(40)]
    found = np.array([item.share for item in shares if item is not None])
    assert found.size == 40
    # The disagreement of the blocks is a χ² with 12 degrees of freedom, times 1.2, relative to a
    # gain of about 300: σ is 0.02 for each set.
    assert float(found.mean()) == pytest.approx(1.0, abs=0.02)
    assert float(found.min()) > LEAST_HELD_OUT
    turning = 0.7 * np.array(
        [[np.cos(angle), np.sin(angle)] for angle in np.arange(BLOCKS) * 2.0 * np.pi / BLOCKS]
    )
    for seed in range(10):
        changing = share_of(*_blocks(turning, columns, seed=seed))
        assert changing is not None
        # The mean of the other five blocks is a fifth as large as the block's own value, with the
        # opposite sign.
        assert changing.share < 0.0


def test_blocks_do_not_judge_what_happens_once_or_is_weak() -> None:
    columns = np.random.default_rng(1).normal(size=(600, 1))
    once = columns.copy()
    once[100:] = 0.0
    assert share_of(*_blocks(np.full((BLOCKS, 1), 2.0), once)) is None
    assert share_of(*_blocks(np.full((BLOCKS, 1), 0.1), columns)) is None


def test_a_line_that_loses_its_phase_is_not_predicted_by_other_blocks() -> None:
    """The other blocks of rows do not predict a resonance driven by noise, which keeps its phase
    for a few periods only; they do predict a steady sine of the same frequency."""
    frequency, size = 1.3, 0.6

    def line(time, speed):  # type: ignore[no-untyped-def]
        return size * np.cos(2.0 * np.pi * frequency * time)

    def resonance(time, speed):  # type: ignore[no-untyped-def]
        random = np.random.default_rng(int(abs(speed) * 1e3) + int(time[0]))
        step, drive = time[1] - time[0], random.normal(size=time.size)
        turn = 2.0 * np.pi * frequency * step
        loss = np.exp(-0.5 * turn / 15.0)
        shaken = np.zeros(time.size)
        for row in range(2, time.size):
            shaken[row] = (
                2.0 * loss * np.cos(turn) * shaken[row - 1] - loss**2 * shaken[row - 2] + drive[row]
            )
        return size * shaken / shaken.std()

    shares = []
    for shape in (line, resonance):
        made = measurement_set(head2_only=shape, reference=False, runs=2)
        residuals = Residuals(
            fit([Term(EFFECTS["graduation_harmonics"](), {})], observations_of(made))
        )
        place = {"frequency": frequency}
        found = block_share(residuals, EFFECTS["vibration"](), place)
        assert found is not None
        shares.append(found.share)
    assert shares[0] == pytest.approx(1.0, abs=0.05)
    assert shares[1] < LEAST_HELD_OUT


def _left(rms: float, noise: float = 0.1, reference: float = 0.1) -> SimpleNamespace:
    rms_arcsec = {"capture": rms, "reference": reference}

    def mean_log_ratio(before) -> float:  # type: ignore[no-untyped-def]
        return float(
            np.mean([np.log(rms_arcsec[name] / before.rms_arcsec[name]) for name in rms_arcsec])
        )

    return SimpleNamespace(
        rms_arcsec=rms_arcsec,
        noise_arcsec={"capture": noise, "reference": 0.1},
        mean_log_ratio=mean_log_ratio,
    )


def _case(before: SimpleNamespace, after: SimpleNamespace, lack_of_fit_p: float = 0.0) -> Case:
    item = SimpleNamespace(
        name="count_slip",
        moved_arcsec={"capture": 0.3},
        gain=100.0,
        share=None,
        regular=None,
        evidence=None,
    )
    channel = SimpleNamespace(lack_of_fit_p=lack_of_fit_p, noise_arcsec=0.1)
    fit_of = {"capture": channel, "reference": SimpleNamespace(lack_of_fit_p=0.5, noise_arcsec=0.1)}
    survey = SimpleNamespace(channels=fit_of, is_the_reversal=lambda item: False)
    case = Case(survey, {}, lambda item: survey, said_of)  # type: ignore[arg-type, return-value]
    rest = SimpleNamespace(survey=survey, best=None)
    case.__dict__.update(best=item, before_and_after=(before, after), with_best=rest, further=None)
    return case


@pytest.mark.parametrize(
    ("before", "after", "refused"),
    [
        (0.498, 0.596, True),
        (0.292, 0.293, True),
        (0.666, 0.716, True),
        (0.298, 0.2981 * (1.0 + 0.5 * RISES), False),
        (0.5, 0.3, False),
    ],
)
def test_a_name_after_which_the_error_rises_is_refused(
    before: float, after: float, refused: bool
) -> None:
    found = makes_it_worse(_case(_left(before), _left(after)))
    assert (found is not None) is refused
    if found is not None:
        assert found.verdict == "unknown"
        assert found.resembles is not None
        assert f"{after:.4g}″" in str(found.unlike)


def test_a_line_that_other_blocks_predict_keeps_its_name_where_slow_noise_is_larger() -> None:
    """A line of 3.8″ with a period of 122 s keeps its name although the set has a slow change of
    9″. With the line in the model, the table's orders fit the slow change slightly worse."""
    line = _case(_left(3.915), _left(3.924))
    assert makes_it_worse(line) is not None
    line.best.regular = SimpleNamespace()  # type: ignore[union-attr, assignment]
    assert makes_it_worse(line) is None


@pytest.mark.parametrize(
    ("share", "after", "refused"),
    [(0.9997, 1.967, False), (0.6, 1.967, True), (0.9997, 2.2, True)],
)
def test_an_effect_that_other_blocks_predict_may_raise_a_larger_error_a_little(
    share: float, after: float, refused: bool
) -> None:
    """A defect of the disc of 0.44″ RMS next to an error of 1.95″ that follows the temperature."""
    case = _case(_left(1.948), _left(after))
    case.best.share = SimpleNamespace(share=share)  # type: ignore[union-attr, assignment]
    assert (makes_it_worse(case) is not None) is refused


def test_a_fall_in_one_channel_makes_up_for_a_rise_in_another() -> None:
    """The rule averages the relative change over both channels: if two causes are missing, a model
    with one of them may leave a larger residual in the channel of the other."""
    before, after = _left(1.254, reference=3.63), _left(0.144, reference=4.41)
    assert makes_it_worse(_case(before, after)) is None


def test_a_name_that_takes_a_tenth_of_the_excess_or_less_is_what_it_resembles() -> None:
    noise, excess = 0.1, 1.0
    before = _left(float(np.hypot(noise, excess)))
    for share, refused in ((0.5 * LEAST_TAKEN, True), (2.0 * LEAST_TAKEN, False)):
        after = _left(float(np.sqrt(noise**2 + excess**2 * (1.0 - share))))
        found = takes_little(_case(before, after))
        assert (found is not None) is refused
        # If slow noise can explain the residual, a small effect keeps its name.
        assert takes_little(_case(before, after, 2.0 * LACK_OF_FIT)) is None
        # One of many sines removes only a small part of the whole error, but the other blocks
        # predict this sine.
        confirmed = _case(before, after)
        confirmed.best.share = SimpleNamespace(share=0.9)  # type: ignore[union-attr]
        assert takes_little(confirmed) is None
        # A sine from the forward search has no share; the search keeps a sine only if the other
        # blocks predict it.
        line = _case(before, after)
        line.best.regular = SimpleNamespace()  # type: ignore[union-attr, assignment]
        assert takes_little(line) is None
    little = _left(float(np.hypot(noise, 0.5 * LEAST_EXCESS * noise)))
    assert takes_little(_case(little, little)) is None


@pytest.mark.large
def test_a_head_angle_keeps_its_name_with_an_order_that_does_not_matter() -> None:
    """A head angle of 40″ keeps its name: the offsets of the runs contain it, and the RMS of the
    rows does not show it.

    The rows also contain 0.5″ of one order, which the effect does not reduce; only an error of 30
    counts (2.3″) or more matters.
    """

    def error(disc: np.ndarray, temperature: np.ndarray, speed: float) -> np.ndarray:
        return paper_error(disc, temperature, speed) + 0.5 * np.cos(31.0 * disc)

    measured = measurement_set(
        error, head2_only=lambda time, speed: np.full(time.size, 40.0), turns=2, reference=False
    )
    base = [Term(EFFECTS["graduation_harmonics"](), {})]
    found = diagnose(observations_of(measured), base, EFFECTS, matters_counts=30.0)
    assert found.named is not None
    assert found.named.name == "head_angle_error"
