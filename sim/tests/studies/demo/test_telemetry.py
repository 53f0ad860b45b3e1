"""Tests that the demo reads the figures of a turn from the console's lines, and that a message
names each fault in these lines."""

import json

import pytest

from arctrue.studies.demo.files import ConsoleLine
from arctrue.studies.demo.telemetry import console_faults, telemetry_turns

TURN = {
    "turn": 1,
    "samples": 2131,
    "result": "applied",
    "reason": "none",
    "separation_deg": 33.001,
    "u_separation_arcsec": 2.0,
    "noise_arcsec": 5.5,
    "active_arcsec": 800.0,
    "candidate_arcsec": 0.5,
    "harmonics": [[1, 1150.0, 0.5, 0.4, 1], [2, 0.1, -1.5, 0.3, 0]],
    "alarms": [],
}
REFUSED = {"turn": 2, "samples": 2131, "result": "refused", "reason": "noise", "alarms": []}
STATUS = """head1_index_errors 0
head1_illegals 0
head1_overspeeds 0
head2_index_errors 0
head2_illegals 0
head2_overspeeds 0
overruns 0
stuck_captures 0
ok"""


def lines(*texts: str) -> list[ConsoleLine]:
    return [ConsoleLine(7, False, line) for text in texts for line in text.splitlines()]


def test_turns_with_their_harmonics() -> None:
    typed = ConsoleLine(0, True, "{")
    (turn,) = telemetry_turns([typed, *lines(json.dumps(TURN), json.dumps(REFUSED), STATUS)])
    assert (turn.clock, turn.samples, turn.result) == (7, 2131, "applied")
    assert [(h.order, h.amplitude_arcsec, h.applied) for h in turn.harmonics] == [
        (1, 1150.0, True),
        (2, 0.1, False),
    ]


def test_a_run_without_fault() -> None:
    assert console_faults(lines(json.dumps(TURN), STATUS)) == []


@pytest.mark.parametrize(
    ("console", "words"),
    [
        (lines(json.dumps(TURN | {"alarms": ["overrun"]}), STATUS), "turn 1: alarm overrun"),
        (lines(json.dumps(REFUSED), STATUS), "turn 2: refused, noise"),
        (lines(STATUS.replace("head2_illegals 0", "head2_illegals 3")), "head2_illegals"),
        (
            lines(STATUS.replace("overruns 0\n", "")),
            "overruns: expected 0, the firmware reported noth",
        ),
    ],
)
def test_each_fault_has_its_words(console: list[ConsoleLine], words: str) -> None:
    (fault,) = console_faults(console)
    assert words in fault
