"""Tests that an error or a wrong result of a user's own effect is reported with file, method and
line."""

from __future__ import annotations

import _thread
import contextlib
import re
import signal
import threading
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from sim.tests.workbench.small_sets import measurement_set

from arctrue.cli import main
from arctrue.measurement import write_measurement_set
from arctrue.workbench.effects.base import Effect, FitContext
from arctrue.workbench.effects.guarded import EffectFileError
from arctrue.workbench.effects.registry import from_folder
from arctrue.workbench.effects.time_limit import TookTooLongError, call_within
from arctrue.workbench.observations import Observations
from arctrue.workbench.observations.build import observations_of

SOURCE = """
import numpy as np
from arctrue.workbench.effects.base import Effect, Lane, Parameter, SearchParameter

class Mine(Effect):
    name = "mine"
    physics = equation = source = capture_sees = reference_sees = "text"
    separated_by = next_measurement = plausible = "text"
    {declared}
    def column_names(self, observations):
        {names}
    def capture_columns(self, rows, nonlinear, context):
        {columns}
    def missing(self, observations):
        {missing}
"""
GOOD = {
    "declared": "pass",
    "names": "return ['a', 'b']",
    "columns": "return np.ones((rows.run.size, 2))",
    "missing": "return []",
}
COLUMNS_LINE = 13


@pytest.fixture(scope="module")
def observations() -> Observations:
    return observations_of(measurement_set(cycles=1, turns=1))


def _effect(folder: Path, **changed: str) -> Effect:
    (folder / "mine.py").write_text(SOURCE.format(**{**GOOD, **changed}), encoding="utf-8")
    return from_folder(folder)["mine"]()


def _columns(effect: Effect, observations: Observations) -> object:
    assert observations.capture is not None
    effect.column_names(observations)
    return effect.capture_columns(observations.capture, {}, FitContext())


def test_a_right_effect_is_left_alone(tmp_path: Path, observations: Observations) -> None:
    columns = _columns(_effect(tmp_path), observations)
    assert isinstance(columns, np.ndarray)
    assert columns.shape == (observations.capture.run.size, 2)  # type: ignore[union-attr]


def test_former_names_are_read(tmp_path: Path, observations: Observations) -> None:
    former = "def told(self, nonlinear, observations): return 'of the data'"
    source = SOURCE.format(**{**GOOD, "declared": former})
    source = source.replace("separated_by", "told_apart_by")
    (tmp_path / "mine.py").write_text(source, encoding="utf-8")
    effect = from_folder(tmp_path)["mine"]
    assert effect.separated_by == "text"
    assert effect().describe_data({}, observations) == "of the data"


FAULTS = {
    "return 1 / 0": "ZeroDivisionError: division by zero",
    "raise SystemExit(0)": "SystemExit: 0",
    "raise KeyboardInterrupt": "KeyboardInterrupt",
    "raise GeneratorExit('out')": "GeneratorExit: out",
    "import sys; sys.exit('all is well')": "SystemExit: all is well",
    "rows.time_s[:] = 0.0": "ValueError: assignment destination is read-only",
    "rows.difference_arcsec.sort()": "ValueError: sort array is read-only",
    "rows.time_s = 0": "FrozenInstanceError",
    "return np.ones(rows.run.size)": r"expected an array of shape \(\d+, coeff",
    "return np.ones((1, 2))": r"shape \(\d+, coefficients\), found shape \(1, 2\)",
    "return np.ones((rows.run.size, 1))": "expected as many columns as column_names has names .2.",
    "return np.full((rows.run.size, 2), np.nan)": r"found \[nan nan\] in row 0",
    "return np.full((rows.run.size, 2), 'x')": "expected numbers",
    "return 'x'": "found str",
}


@pytest.mark.parametrize(("columns", "said"), FAULTS.items())
def test_a_fault_of_columns_is_named(
    tmp_path: Path, observations: Observations, columns: str, said: str
) -> None:
    effect = _effect(tmp_path, columns=columns)
    with pytest.raises(EffectFileError, match=said) as caught:
        _columns(effect, observations)
    place = re.escape(f"{tmp_path / 'mine.py'}: capture_columns, line ")
    line = re.match(place + r"(\d+): ", str(caught.value))
    assert line is not None, caught.value
    # The check finds a wrong result after the call; therefore it states the line of the method.
    assert int(line.group(1)) in (COLUMNS_LINE, COLUMNS_LINE - 1)


ENDLESS = {
    "while True: pass": "capture_columns, line 13",
    "[0 for _ in iter(int, 1)]": "capture_columns, line 13",
    # The bare except in this effect catches every error that is raised to end the loop.
    "import threading\n        while not threading.end_of_test.is_set():\n"
    "            try: rows.run.sum()\n            except: pass": "capture_columns, line 1[4567]",
    # No error can be raised in a thread that waits.
    "import threading; threading.end_of_test.wait()": "capture_columns, line 13",
}


@pytest.mark.parametrize(("columns", "place"), ENDLESS.items())
def test_a_loop_without_an_end_is_ended_and_named(
    tmp_path: Path,
    observations: Observations,
    monkeypatch: pytest.MonkeyPatch,
    columns: str,
    place: str,
) -> None:
    end_of_test = threading.Event()
    monkeypatch.setattr(threading, "end_of_test", end_of_test, raising=False)
    effect = _effect(tmp_path, columns=columns, declared="longest_call_s = 0.2")
    said = f"{re.escape(str(tmp_path / 'mine.py'))}: .*{place}: took longer than 0.2 s"
    try:
        with pytest.raises(EffectFileError, match=said):
            _columns(effect, observations)
    finally:
        end_of_test.set()


def test_a_loop_is_ended_in_any_thread(tmp_path: Path, observations: Observations) -> None:
    effect = _effect(tmp_path, columns="while True: pass", declared="longest_call_s = 0.2")
    with ThreadPoolExecutor(1) as pool:
        ended = pool.submit(_columns, effect, observations)
        with pytest.raises(EffectFileError, match="took longer"):
            ended.result()


def test_a_loop_at_loading_is_ended(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("arctrue.workbench.effects.registry.LOAD_S", 0.2)
    (tmp_path / "mine.py").write_text("x = 1\nwhile x:\n    x += 1\n")
    with pytest.raises(EffectFileError, match=r"mine.py: line [23]: took longer than 0.2 s"):
        from_folder(tmp_path)


def test_no_error_comes_after_the_call(tmp_path: Path, observations: Observations) -> None:
    """A call that ends near its time limit either raises the error of the limit or returns its
    columns; no error comes later."""
    limit = 0.15
    text = f"import time; time.sleep({limit}); return np.ones((rows.run.size, 2))"
    effect = _effect(tmp_path, columns=text, declared=f"longest_call_s = {limit}")
    for _ in range(4):
        with contextlib.suppress(EffectFileError):
            _columns(effect, observations)
        for _ in range(100_000):
            pass


def test_limits_within_each_other_name_the_one_that_is_over() -> None:
    def inner() -> None:
        with pytest.raises(TookTooLongError, match=r"longer than 0\.1 s"):
            call_within(0.1, threading.Event().wait)

    call_within(30.0, inner)


def test_the_thread_of_a_loop_that_was_left_ends() -> None:
    before = set(threading.enumerate())

    def endless() -> None:
        while True:
            pass

    with pytest.raises(TookTooLongError):
        call_within(0.1, endless)
    for thread in set(threading.enumerate()) - before:
        thread.join(60.0)
        assert not thread.is_alive()


def test_settings_of_numpy_hold_within_the_call() -> None:
    with np.errstate(divide="raise"), pytest.raises(FloatingPointError):
        call_within(30.0, lambda: np.ones(1) / np.zeros(1))


def test_ctrl_c_within_an_effect_is_no_fault_of_it(
    tmp_path: Path, observations: Observations, monkeypatch: pytest.MonkeyPatch
) -> None:
    effect = _effect(tmp_path, columns="import _thread; _thread.ctrl_c()\n        while True: pass")
    # The effect sends the signal of Ctrl-C while it runs.
    monkeypatch.setattr(_thread, "ctrl_c", _thread.interrupt_main, raising=False)
    # Tests that a shell starts in the background inherit an ignored SIGINT; therefore this test
    # sets the default handler.
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        with pytest.raises(KeyboardInterrupt):
            _columns(effect, observations)
    finally:
        signal.signal(signal.SIGINT, before)


@pytest.mark.parametrize(
    ("changed", "said"),
    [
        ({"names": "return 'ab'"}, "column_names, line 10: expected a list of printable texts"),
        ({"names": r"return ['\x1b[2J']"}, "column_names, line 10: expected a list of printable"),
        ({"missing": "return None"}, "missing, line 14: expected a list of printable texts"),
        ({"missing": "exit()"}, "missing, line 15: SystemExit"),
    ],
)
def test_a_wrong_answer_is_named(
    tmp_path: Path, observations: Observations, changed: dict[str, str], said: str
) -> None:
    effect = _effect(tmp_path, **changed)
    asked = effect.missing if "missing" in changed else effect.column_names
    with pytest.raises(EffectFileError, match=said):
        asked(observations)


@pytest.mark.parametrize("answer", ["None", "'1'", "float('nan')", "float('inf')", "-1.0", "True"])
def test_a_wrong_constant_between_the_heads_is_named(tmp_path: Path, answer: str) -> None:
    declared = f"def constant_between_heads_arcsec(self, coefficients): return {answer}"
    effect = _effect(tmp_path, declared=declared)
    said = "mine.py: constant_between_heads_arcsec, line 9: expected a finite number of 0 or more"
    with pytest.raises(EffectFileError, match=said):
        effect.constant_between_heads_arcsec(np.zeros(2))


def test_a_constant_between_the_heads_may_be_any_number(tmp_path: Path) -> None:
    declared = "def constant_between_heads_arcsec(self, coefficients): return abs(coefficients[0])"
    effect = _effect(tmp_path, declared=declared)
    assert effect.constant_between_heads_arcsec(np.array([-2.0, 0.0])) == 2.0


def test_a_wrong_description_is_named(tmp_path: Path) -> None:
    effect = _effect(tmp_path, declared="def describe(self, parameters): return None")
    with pytest.raises(EffectFileError, match="describe, line 9: expected one line of printable"):
        effect.describe({})


@pytest.mark.parametrize(
    ("declared", "said"),
    [
        ("name = 'Ä b'", "Mine.name: expected small letters"),
        ("physics = None", "Mine.physics: expected a text"),
        (
            "compensation = 'much'",
            "Mine.compensation: expected 'lanes' or 'offset' or 'modulators' or 'local_table' or "
            "'none' or 'reference'",
        ),
        ("search = 'order'", "Mine.search: expected a tuple of SearchParameter"),
        ("search_kind = 'luck'", "Mine.search_kind: expected 'grid' or 'disc_order'"),
        ("search_kind = 'frequency'", "expected frequency for search_kind 'frequency'"),
        ("def scan(self, residuals): pass", "Mine.scan: expected none: search_kind states"),
        ("defaults = None", "Mine.defaults"),
        ("longest_call_s = 0", "Mine.longest_call_s: expected seconds above 0"),
        ("fixed_to_polygon = 'no'", "Mine.fixed_to_polygon: expected True or False, found 'no'"),
        ("depends_on_model = 1", "Mine.depends_on_model: expected True or False, found 1"),
        ("step_at = 'run'", "Mine.step_at: expected two names of search or None, found 'run'"),
        ("step_at = ('a', 'b')", "Mine.step_at: expected two names of search or None"),
        ("in_parts = 'direction'", "Mine.in_parts: expected a tuple of texts"),
    ],
)
def test_a_wrong_declaration_is_named(tmp_path: Path, declared: str, said: str) -> None:
    with pytest.raises(EffectFileError, match=re.escape(said)):
        _effect(tmp_path, declared=declared)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("import sys\nsys.exit(0)\n", "line 2: SystemExit: 0"),
        ("x = 1\nraise KeyboardInterrupt\n", "line 2: KeyboardInterrupt"),
        ("import nothing_of_this_name\n", "line 1: ModuleNotFoundError"),
        ("def (\n", "line 1: SyntaxError"),
        ("\0", "cannot be loaded|SyntaxError"),
    ],
)
def test_a_file_that_ends_the_program_is_an_error_of_that_file(
    tmp_path: Path, text: str, said: str
) -> None:
    (tmp_path / "mine.py").write_text(text)
    with pytest.raises(EffectFileError, match=said) as caught:
        from_folder(tmp_path)
    assert str(tmp_path / "mine.py") in str(caught.value)


def test_an_exit_in_an_effect_is_no_success_of_the_command(tmp_path: Path) -> None:
    write_measurement_set(tmp_path / "set", measurement_set(cycles=1, turns=1))
    (tmp_path / "own").mkdir()
    text = SOURCE.format(**{**GOOD, "columns": "raise SystemExit(0)"})
    (tmp_path / "own" / "mine.py").write_text(text)
    words = ["add", "mine", tmp_path / "set", "--effects", tmp_path / "own", "--model"]
    done = CliRunner().invoke(main, [*map(str, words), str(tmp_path / "m.toml")])
    assert done.exit_code == 2
    assert "mine.py: capture_columns, line 13: SystemExit: 0" in done.output.replace("\n", " ")
    assert not (tmp_path / "m.toml").exists()


def test_rows_are_read_only_wherever_they_come_from(observations: Observations) -> None:
    for rows in (observations.capture, observations.reference):
        assert rows is not None
        for part in (rows, rows.part(slice(0, 5))):
            for name, values in vars(part).items():
                if isinstance(values, np.ndarray):
                    assert not values.flags.writeable, name
