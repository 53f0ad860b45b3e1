"""Tests the correction tables for other controllers, with models of the controllers' interpolation,
which this module contains.

The models follow the controllers' own sources step by step, one angle at a time: LinuxCNC's
compute_screw_comp (src/emc/motion/control.c) and the sign of type 0 (docs, ini-config: "actual
position"), ecmc's ecmcLookupTable::getValue and ecmcEncoder, moteus' MotorPosition::lerp,
SimpleFOC's CalibratedSensor::getSensorAngle. For closed sources the models follow the manual:
Beckhoff TF5200 (compensation value = actual − nominal, subtracted from the command), Siemens
Extended Functions K3 (added to the actual position: a positive value drives the axis the negative
way), Aerotech's help Axis Calibration (linear, the nearest end outside the rows), with the sign of
a program that measures a rotary axis and writes the negative of actual − commanded.
"""

from __future__ import annotations

import bisect
import itertools
import json
import math
import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from sim.tests.command_line import arctrue as _run
from sim.tests.workbench.small_sets import measurement_set, paper_error

from arctrue.gateware.coefficient_file import read_coefficient_file
from arctrue.measurement import Reference, write_measurement_set
from arctrue.metrology.controllers import FORMATS
from arctrue.metrology.correction import Correction

ARCSEC_RAD = math.pi / 648_000.0
DISC = {1: (90.0, 0.4), 2: (8.0, 1.0), 7: (1.5, -2.0)}
"""Amplitude ″ and phase of each order of g(R), the disc's error as a function of the reading."""
REVERSAL = 3.0


def _g(reading_rad: float) -> float:
    return sum(a * math.cos(n * reading_rad + phase) for n, (a, phase) in DISC.items())


def _correction() -> Correction:
    pairs = [(a * math.cos(p), -a * math.sin(p)) for a, p in DISC.values()]
    return Correction(np.array(list(DISC)), np.array(pairs), REVERSAL, (), ())


def _linuxcnc(text: str, angle_deg: float, way: int) -> float:
    """Return the value that the controller adds to a command, in ″."""
    rows = [[float(cell) for cell in line.split()] for line in text.splitlines()]
    entry = 0
    while entry + 1 < len(rows) - 1 and angle_deg >= rows[entry + 1][0]:
        entry += 1
    (n0, *actual0), (n1, *actual1) = rows[entry], rows[entry + 1]
    side = 0 if way > 0 else 1
    trim0, trim1 = n0 - actual0[side], n1 - actual1[side]
    return (trim0 + (trim1 - trim0) / (n1 - n0) * (angle_deg - n0)) * 3600.0


def _ecmc(text: str, angle_deg: float, way: int) -> float:
    """Return the value that the controller subtracts from a reading, in ″."""
    rows = []
    for line in text.replace(",", " ").splitlines():
        if line and not line.startswith(("#", "PREC=")):
            rows.append(tuple(map(float, line.split())))
    index = [row[0] for row in rows]
    assert len(rows) >= 3
    assert all(b > a for a, b in itertools.pairwise(index))
    x = math.fmod(angle_deg, 360.0)
    i = bisect.bisect_left(index, x)
    if i == 0:
        value = rows[0][1]
    else:
        (x0, v0), (x1, v1) = rows[i - 1], rows[i]
        value = v0 + (v1 - v0) * (x - x0) / (x1 - x0)
    return value * 3600.0


def _moteus(text: str, angle_deg: float, way: int) -> float:
    """Return the value that the controller subtracts from a reading, in ″."""
    config = dict(line.split()[2:] for line in text.splitlines())
    size = sum("table." in key for key in config)
    base = "motor_position.sources.0.compensation_"
    table = [float(config[f"{base}table.{i}"]) for i in range(size)]
    scale = float(config[f"{base}scale"]) / 127.0 if f"{base}scale" in config else 1.0
    if f"{base}scale" in config:
        assert all(abs(value) <= 127 and value == int(value) for value in table)
    ratio = angle_deg / 360.0
    left = min(size - 1, int(ratio * size))
    fraction = (ratio - left / size) * size
    lerp = table[left] * scale * (1.0 - fraction) + table[(left + 1) % size] * scale * fraction
    return -lerp * 1_296_000.0


def _csv(text: str, angle_deg: float, way: int) -> float:
    """Return the value that a user of the file subtracts from a reading, in ″."""
    header, *lines = text.splitlines()
    assert header == "reading_deg,forward_arcsec,reverse_arcsec"
    rows = [tuple(map(float, line.split(","))) for line in lines]
    i = min(bisect.bisect_right([row[0] for row in rows], angle_deg), len(rows) - 1)
    side = 1 if way > 0 else 2
    part = (angle_deg - rows[i - 1][0]) / (rows[i][0] - rows[i - 1][0])
    return rows[i - 1][side] * (1 - part) + rows[i][side] * part


def _siemens(text: str, angle_deg: float, way: int) -> float:
    """Return the value that the controller subtracts from a reading, in ″."""
    points: dict[int, float] = {}
    parameter: dict[str, float] = {}
    for line in text.splitlines():
        found = re.fullmatch(r"\$AA_ENC_COMP(_\w+)?\[0,(?:(\d+),)?AX1\]=(\S+)", line)
        if found is None:
            assert line.startswith((";", "%_N_", "CHANDATA(1)", "M17")), line
        elif found[1]:
            parameter[found[1]] = float(found[3])
        else:
            points[int(found[2])] = float(found[3])
    assert parameter["_IS_MODULO"] == 1
    assert parameter["_MAX"] - parameter["_MIN"] == 360.0
    step = parameter["_STEP"]
    assert step * (len(points) - 1) == pytest.approx(360.0)
    i = min(int((angle_deg - parameter["_MIN"]) / step), len(points) - 2)
    part = angle_deg / step - i
    return -3600.0 * (points[i] * (1.0 - part) + points[i + 1] * part)


def _twincat(text: str, angle_deg: float, way: int) -> float:
    """Return the value that the controller adds to a command, in ″."""
    kept = [line.split() for line in text.splitlines() if not line.startswith("#")]
    entry = {key: int(value) for key, value in kept}
    assert entry["kw.ssfk.bilateral"] == entry["kw.ssfk.modulo"] == entry["kw.ssfk.unit"] == 1
    number, interval = entry["kw.ssfk.kw_nr_max"], entry["kw.ssfk.interval"]
    assert number * interval == 3_600_000, "the table of a modulo axis spans the turn"
    place = angle_deg * 10_000 / interval
    left, part = int(place) % number, place - int(place)
    side = "pos" if way > 0 else "neg"
    value = [entry[f"kw.ssfk.table[{i % number}].{side}"] for i in (left, left + 1)]
    return -0.36 * (value[0] * (1.0 - part) + value[1] * part)


def _aerotech(text: str, angle_deg: float, way: int) -> float:
    """Return the value that the controller adds to a command, in ″."""
    head = [line for line in text.splitlines() if line.startswith(":START")]
    (step,) = re.findall(r"SAMPLEDIST=(\S+)", head[0])
    assert head == [f":START 1 SAMPLEDIST={step} POSUNIT=PRIMARY CORUNIT=PRIMARY/3600"]
    body = text.split(head[0])[1]
    values = [float(word) for word in body.split(":END")[0].split()]
    assert (len(values) - 1) * float(step) == pytest.approx(360.0)
    place = min(max(angle_deg / float(step), 0.0), float(len(values) - 1))
    left = min(int(place), len(values) - 2)
    part = place - left
    return values[left] * (1.0 - part) + values[left + 1] * part


def _simplefoc(text: str, angle_deg: float, way: int) -> float:
    """Return the value that the controller subtracts from a reading, in ″."""
    size = int(re.search(r"float calibrationLut\[(\d+)\] = {", text)[1])  # type: ignore[index]
    table = [float(value) for value in re.findall(r"(\S+)f,", text)]
    assert len(table) == size
    resolution = 2.0 * math.pi / size
    raw = math.radians(angle_deg)
    index = int(raw / resolution)
    distance = (raw - index * resolution) / resolution
    return ((1.0 - distance) * table[index] + distance * table[(index + 1) % size]) / ARCSEC_RAD


CONTROLLERS: dict[str, Callable[[str, float, int], float]] = {
    "linuxcnc": _linuxcnc,
    "ecmc": _ecmc,
    "moteus": _moteus,
    "moteus-256": _moteus,
    "csv": _csv,
    "siemens": _siemens,
    "twincat": _twincat,
    "aerotech": _aerotech,
    "simplefoc": _simplefoc,
}
OF_A_WORM = ("onstep",)
"""Formats that contain only harmonics of a worm; separate tests below cover them."""
OF_THE_TURN = tuple(name for name in FORMATS if name not in OF_A_WORM)
OF_THE_COMMAND = ("linuxcnc", "twincat", "aerotech")
"""Controllers that change the command: the servo then moves the table until the reading equals the
changed command."""


def _left(name: str, text: str, angle_deg: float, way: int) -> float:
    """Return the controller's angle minus the true angle, in ″."""
    changed = CONTROLLERS[name](text, angle_deg, way)
    if name in OF_THE_COMMAND:
        reading = math.radians(angle_deg) + changed * ARCSEC_RAD
        return changed - (_g(reading) + way * REVERSAL / 2)
    return _g(math.radians(angle_deg)) + way * REVERSAL / 2 - changed


def _chord(points: int) -> float:
    """Return an upper bound of the error of linear interpolation between ``points`` exact rows:
    h²/8 times Σ a·n², which is at least the largest |g″|."""
    step = 2.0 * math.pi / points
    return step**2 / 8.0 * sum(a * n**2 for n, (a, _) in DISC.items())


@pytest.mark.parametrize("name", OF_THE_TURN)
def test_the_controller_leaves_what_is_said(name: str) -> None:
    form, correction = FORMATS[name], _correction()
    text = form.text(correction, form.points, "my table")
    said = form.left(text, correction)
    angles = np.random.default_rng(5).uniform(0.0, 360.0, 1500)
    left = [_left(name, text, angle, way) for angle in angles.tolist() for way in (1, -1)]
    assert np.abs(left).max() <= said.largest_arcsec + 1e-4
    assert np.sqrt(np.mean(np.square(left))) == pytest.approx(said.rms_arcsec, rel=0.05)
    # The bound has three parts: linear interpolation between exact rows, half a step where the file
    # has whole numbers, and half the reversal error.
    rounding = {"moteus-256": 0.5 / 127.0 * 102.0, "twincat": 0.5 * 0.36}.get(name, 1e-4)
    direction = 0.0 if form.knows_direction else REVERSAL / 2
    assert said.largest_arcsec <= _chord(form.points) * 1.02 + rounding + direction
    assert said.largest_arcsec >= direction
    assert said.rms_arcsec < 0.05 * np.sqrt(sum(a**2 for a, _ in DISC.values()) / 2)


def test_a_table_in_whole_units_of_twincat_divides_the_turn() -> None:
    with pytest.raises(ValueError, match="Choose a divisor of 3600000"):
        FORMATS["twincat"].text(_correction(), 7, "")


def test_simplefoc_in_single_precision_loses_what_its_class_says() -> None:
    """SimpleFOC loses less than two units in the last place of raw − offset, because the library
    uses single precision."""
    text = FORMATS["simplefoc"].text(_correction(), 200, "")
    table = np.array(re.findall(r"(\S+)f,", text), dtype=np.float32)
    raw = np.radians(np.linspace(0.0, 359.9, 977)).astype(np.float32)
    resolution = np.float32(2.0 * math.pi) / np.float32(200)
    index = (raw / resolution).astype(int)
    distance = (raw - index.astype(np.float32) * resolution) / resolution
    offset = (np.float32(1) - distance) * table[index] + distance * table[(index + 1) % 200]
    single = (raw - offset).astype(float)
    exact = [
        math.radians(angle) - _simplefoc(text, angle, 1) * ARCSEC_RAD
        for angle in np.degrees(raw.astype(float)).tolist()
    ]
    assert np.abs(single - exact).max() / ARCSEC_RAD < 0.2


def test_limits_of_the_controllers() -> None:
    text = FORMATS["linuxcnc"].text(_correction(), 255, "")
    assert len(text.splitlines()) == 256, "the controller holds 256 triplets a joint"
    assert len(FORMATS["moteus"].text(_correction(), 32, "").splitlines()) == 32


def test_a_set_with_a_reference_alone_gives_every_table(tmp_path: Path) -> None:
    """The 24 stations of a reference instrument suffice for the table of each controller; the set
    has no second head."""
    made = measurement_set(cycles=5, runs=1, turns=1)
    table = replace(made.table, counts_per_rev=None, head_separation_deg=None)
    write_measurement_set(tmp_path / "set", replace(made, table=table, capture=None))
    for name in OF_THE_TURN:
        form = FORMATS[name]
        answer = _run(
            "export", tmp_path / "set", "--format", name, "--out", tmp_path / name,
            "--json", tmp_path / "e.json",
        )  # fmt: skip
        assert answer.exit_code == 0, answer.output
        text = (tmp_path / name / form.file_name).read_text()
        written = json.loads((tmp_path / "e.json").read_text())
        assert written["format"] == name
        assert f"at most {written['left_arcsec']['largest']:.3f}″" in answer.output
        # Compare with the error of the disc itself, which no part of the package has computed.
        for angle_deg in np.arange(0.0, 360.0, 7.3).tolist():
            angle = math.radians(angle_deg)
            error = float(paper_error(np.array(angle), np.array(20.0), 0.0))
            at = angle_deg if name in OF_THE_COMMAND else (angle_deg + error / 3600.0) % 360.0
            taken = CONTROLLERS[name](text, at, 1)
            # The bound is five standard deviations of the fit's noise: 0.15″ per row, 240 rows, 23
            # columns.
            noise = 5 * 0.15 * math.sqrt(23 / 240)
            assert taken == pytest.approx(error, abs=noise + written["left_arcsec"]["largest"]), (
                name
            )


def test_stations_that_leave_a_gap_are_refused(tmp_path: Path) -> None:
    """The export refuses stations in only one half of the turn; if the stations cover the whole
    turn, it writes the orders 1, 2, 3 and 5."""
    made = measurement_set(cycles=2, runs=1, turns=1)
    assert made.reference is not None
    half = made.reference.where(made.reference.target_deg < 180.0)
    write_measurement_set(tmp_path / "half", replace(made, capture=None, reference=half))
    for name in ("gateware", "csv"):
        answer = _run("export", tmp_path / "half", "--format", name, "--out", tmp_path / "out")
        assert answer.exit_code == 2, answer.output
        assert "has no target over 195.0° of the turn" in answer.stderr
    write_measurement_set(tmp_path / "whole", replace(made, capture=None))
    answer = _run("export", tmp_path / "whole", "--out", tmp_path)
    assert answer.exit_code == 0, answer.output
    held = read_coefficient_file(tmp_path / "coefficients.toml")
    assert held.orders[held.amplitudes != 0].tolist() == [1, 2, 3, 5]


def test_a_table_that_adds_to_the_error_is_refused(tmp_path: Path) -> None:
    made = measurement_set(cycles=2, runs=1, turns=1)
    assert made.reference is not None
    write_measurement_set(tmp_path / "set", replace(made, capture=None))
    model = tmp_path / "model.toml"
    assert _run("add", "hysteresis", tmp_path / "set", "--model", model).exit_code == 0
    turned = replace(made.reference, error_arcsec=-made.reference.error_arcsec)
    write_measurement_set(tmp_path / "other", replace(made, capture=None, reference=turned))
    words = ("export", tmp_path / "other", "--model", model, "--format", "csv", "--out", tmp_path)
    answer = _run(*words)
    assert answer.exit_code == 1, answer.output
    assert "rises" in answer.stderr
    assert not (tmp_path / "correction.csv").exists()
    assert _run(*words, "--force").exit_code == 0
    assert (tmp_path / "correction.csv").exists()


def test_rows_that_a_controller_does_not_hold_are_refused(tmp_path: Path) -> None:
    write_measurement_set(tmp_path / "set", measurement_set(cycles=1, runs=1, turns=1))
    for name, points in (("linuxcnc", 300), ("moteus", 64)):
        answer = _run("export", tmp_path / "set", "--format", name, "--points", points)
        assert answer.exit_code == 2
        assert "--points" in answer.stderr


TEETH = 180
WORM_S = 480
STEPS_PER_SECOND = 96.0
STEP_ARCSEC = 15.0 / STEPS_PER_SECOND
WORM = {180: (8.6, 0.7), 360: (1.9, -1.1)}
"""Amplitude ″ and phase of each order in the error of a worm."""


def _onstep_steps(text: str, turns: int) -> tuple[np.ndarray, np.ndarray]:
    """Return the motor position in steps that Pec::poll of OnStepX causes, and the time in sidereal
    seconds, at each tenth of a sidereal second."""
    buffer = [0] * WORM_S
    *writes, keep = text.split()
    assert keep == ":$QZ!#", "the table is written to the controller's memory"
    for line in writes:
        n, steps = map(int, re.fullmatch(r":WR(\d+),([+-]\d+)#", line).groups())  # type: ignore[union-attr]
        assert -128 <= steps <= 127
        buffer[n] = steps
    position, positions = 0.0, [0.0]
    for tenth in range(10 * WORM_S * turns):
        index = (tenth // 10) % WORM_S
        played = buffer[index - 1]  # index −1 is the last entry, as in the firmware
        rate = max(-STEPS_PER_SECOND, min(STEPS_PER_SECOND, played)) / STEPS_PER_SECOND
        position += STEPS_PER_SECOND * (1.0 + rate) / 10.0
        positions.append(position)
    return np.array(positions), np.arange(10 * WORM_S * turns + 1) / 10.0


def _worm_correction() -> Correction:
    pairs = [(a * math.cos(p), -a * math.sin(p)) for a, p in WORM.values()]
    return Correction(np.array(list(WORM)), np.array(pairs), 0.0, (), ())


def test_onstep_plays_the_worm_s_error_back() -> None:
    """OnStep corrects the worm's error ε: the mount points at the motor position minus ε(motor
    position), and the sky turns by 15″ per second."""
    form = FORMATS["onstep"].for_axis(TEETH, STEPS_PER_SECOND)
    text = form.text(_worm_correction(), form.points, "my mount")
    steps, seconds = _onstep_steps(text, turns=3)
    motor_rad = steps * STEP_ARCSEC * ARCSEC_RAD
    error = sum(a * np.cos(n * motor_rad + phase) for n, (a, phase) in WORM.items())
    left = steps * STEP_ARCSEC - error - 15.0 * seconds
    rounding = left.mean() - left[0]
    left -= left.mean()
    before = np.sqrt(sum(a**2 for a, _ in WORM.values()) / 2.0)
    # The bound is half a motor step of rounding. Linear interpolation over a second adds only
    # h²/8·Σ a·(2πk/480)² = 0.0004″.
    assert np.abs(left).max() < 0.5 * STEP_ARCSEC + 0.001 + abs(rounding)
    assert abs(left[-1] - left[0]) < 1e-7, "nothing accumulates over turns of the worm"
    assert before > 6.0
    assert form.left(text, _worm_correction()).largest_arcsec == pytest.approx(
        np.abs(left).max(), abs=0.02
    )


def test_onstep_holds_harmonics_of_the_worm_only() -> None:
    form = FORMATS["onstep"].for_axis(TEETH, STEPS_PER_SECOND)
    orders = np.array([1, 2, 180, 360])
    mixed = Correction(orders, np.ones((4, 2)), 0.0, ("a",), ())
    kept = form.part_of(mixed)
    assert kept.orders.tolist() == [180, 360]
    assert kept.left_out == ("a", "orders 1, 2: the table holds harmonics of the worm only")


@pytest.mark.parametrize(
    ("teeth", "steps", "words"),
    [
        (None, 96.0, "drive_gear_teeth"),
        (180, None, "--steps-per-second"),
        (130, 96.0, "664.62 sidereal seconds"),
        (2160, 96.0, "at least 61"),
    ],
)
def test_onstep_names_what_it_lacks(teeth: float | None, steps: float | None, words: str) -> None:
    with pytest.raises(ValueError, match=words):
        FORMATS["onstep"].for_axis(teeth, steps)


def test_onstep_refuses_a_correction_that_stops_the_tracking() -> None:
    form = FORMATS["onstep"].for_axis(TEETH, 3.0)
    steep = Correction(np.array([1800]), np.array([[300.0, 0.0]]), 0.0, (), ())
    with pytest.raises(ValueError, match="must not stop or reverse the tracking"):
        form.text(steep, form.points, "")


def test_a_log_of_a_mount_gives_a_table_for_onstep(tmp_path: Path) -> None:
    """The table reproduces the worm's error, from a log of five turns of the worm with a row every
    3.1 s and 0.5″ of noise."""
    made = measurement_set(cycles=1, runs=1, turns=1)
    assert made.reference is not None
    seconds = np.arange(0.0, 5.0 * WORM_S, 3.1)
    angle = seconds / 86_400.0 * 2.0 * np.pi
    noise = np.random.default_rng(8).normal(0.0, 0.5, seconds.size)
    worm = sum(a * np.cos(n * angle + phase) for n, (a, phase) in WORM.items())
    reference = Reference(
        target_deg=np.degrees(angle),
        error_arcsec=worm + noise,
        direction=np.ones(seconds.size, dtype=np.int64),
    )
    table = replace(
        made.table, counts_per_rev=None, head_separation_deg=None, drive_gear_teeth=float(TEETH)
    )
    write_measurement_set(
        tmp_path / "log", replace(made, table=table, capture=None, reference=reference)
    )
    model = tmp_path / "model.toml"
    entry = 'name = "drive_gear_error"\nsettings = { multiples = [1, 2] }\n'
    model.write_text(f"schema = 1\n\n[[effect]]\n{entry}")
    words = ("export", tmp_path / "log", "--model", model, "--format", "onstep", "--out", tmp_path)
    answer = _run(*words, "--steps-per-second", STEPS_PER_SECOND)
    assert answer.exit_code == 0, answer.output
    steps, _ = _onstep_steps((tmp_path / "pec.onstep").read_text(), turns=1)
    added = (steps - STEPS_PER_SECOND * np.arange(steps.size) / 10.0) * STEP_ARCSEC
    clock = np.arange(steps.size) / 10.0 / 86_400.0 * 2.0 * np.pi
    wanted = sum(a * np.cos(n * clock + phase) for n, (a, phase) in WORM.items())
    left = added - added.mean() - (wanted - wanted.mean())
    # The bound is five standard deviations of the noise, for four coefficients on 775 rows, plus
    # half a step.
    assert np.sqrt(np.mean(left**2)) < 5.0 * 0.5 * math.sqrt(4 / seconds.size) + STEP_ARCSEC / 2
    missing = _run(*words)
    assert missing.exit_code == 2
    assert ":VS#" in missing.stderr
