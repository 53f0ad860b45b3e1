"""Makes the page about the benchmark's sets: the worlds of both generators, and how independent the
generators are."""

from __future__ import annotations

from arctrue.studies.benchmark.independent.world import independent_worlds
from arctrue.studies.benchmark.worlds import WORLDS

MADE = "<!-- Made by scripts/make_docs.py from the worlds. Do not edit: make docs -->"
WORLDS_TEXT = """## The first generator, of the simulated table

A set has 24,000 rows: four runs (up, down, three times as fast, warm) and ten polygon cycles.
Each world has sets with nothing in them, one cause of the catalogue, a product of parts that is
not in the catalogue, a stranger outside the grammar of parts, and two or three causes at once.
Causes and sizes are drawn from the ranges of `arctrue simulate --list`; draws that look like each
other are not avoided.

| world | what is wrong in it |
|---|---|
"""

SECOND_TEXT = """## The second generator

The second generator (`--generator independent`; `both`: a fifth of the sets) was written from the
physics by somebody who had read neither the effects of the workbench nor the first generator, and
imports nothing of them. Its noise is white, of Student's t, a relaxation, a random walk, 1/f by
fractional integration, or a driven oscillator. A set states which answers are right: names that
mean the same, verdicts that its design allows (where temperature rises with time, `ambiguous`:
*left open, rightly*), and where a line lies: a name at another place is false. A damped
oscillator in the noise counts as a cause that the catalogue lacks: `unknown` is right if its
frequency is stated within the half width at half power. Its oracle projects each cause off 20
orders, the offsets of the runs and all other causes, and whitens by the noise drawn.

| world | what is measured, and what may be hidden |
|---|---|
"""
INDEPENDENCE_TEXT = """## How independent the first generator is of the effects

It moves discs, brackets and counters by exact plane geometry and solves for the reading; it
shares no code with the workbench. Where a cause's own formula *is* the effect's, agreement shows
that the search and the statistics work, not that the physics is right.

| effect | the same formula? |
|---|---|
"""
INDEPENDENCE = {
    "high_order_graduation": "The same: a wave of one order on the graduation.",
    "head_angle_error": (
        "To first order: the bracket is turned about the axis and the ray from the disc's centre "
        "is exact; the effect is a constant and the slope of the fitted error."
    ),
    "subdivision_error": (
        "No: offset, gain and phase of sine and cosine through atan2; the effect is a series of "
        "the electrical phase."
    ),
    "radial_error_motion": (
        "To first order: the axis moves on an ellipse, the rays are exact; the effect is the "
        "motion over the radius."
    ),
    "bearing_ball_pass": (
        "To first order, as radial motion, at an order that is not whole and is searched."
    ),
    "vibration": (
        "The same: a sine of one frequency with a phase of its own each run. The head is turned "
        "about the axis by it and the ray is exact; the effect leaves the slope of the error out."
    ),
    "hysteresis": (
        "No: the shaft winds up on a loop of Dahl's friction, over a stroke after each reversal; "
        "the effect is a constant a direction."
    ),
    "timing_skew": (
        "To first order: head 2 is read at the later position of the table, with the error there; "
        "the effect is delay times speed."
    ),
    "latency": "The same: the reading is that of the angle one delay earlier.",
    "thermal_head_drift": (
        "To first order: the bracket is turned about the axis in proportion to the warming and "
        "the ray is exact; the effect leaves the slope of the error out."
    ),
    "thermal_eccentricity": (
        "To first order: the disc's centre moves in proportion to the warming, the rays are exact; "
        "the effect is a first order times the warming."
    ),
    "count_slip": (
        "The same: a step at an instant of one run. The step is a whole number of counts; that of "
        "the effect has any size."
    ),
    "graduation_defect": (
        "No: dirt has edges of any steepness and may be lopsided; the effect is a bell."
    ),
    "drive_gear_error": (
        "No: the pitch wobbles once a turn, which modulates the phase of the teeth's wave: lines "
        "on both sides of it whose sizes and phases are related. The effect is that wave with "
        "as many of its multiples and neighbouring lines as the data show, each free."
    ),
    "polygon_face_error": "The same: a constant a face.",
    "polygon_eccentricity": (
        "Nearly: tilt, roll and hollow faces are put in as such, and come to a wave of the first "
        "order and a gain of cos 1° − 1 = −0.015 %; the effect is the wave."
    ),
    "autocollimator_gain": (
        "The same: a share of the table's error. The effect takes the share of the fitted error."
    ),
    "reference_drift": (
        "No: a rate plus a temperature that walks at random; the effect is in proportion to time."
    ),
    "warm_ovality": "The same product: warming times a wave of the second order on the disc.",
    "centrifugal_lobes": "The same product: speed squared times a wave of the third order on it.",
    "half_order": (
        "To first order: the axis moves on a line at a half-integer order, the rays are exact; the "
        "parts are a wave of any order fixed to the stator."
    ),
    "settling_bracket": (
        "The same: an exponential since the start or since the run began, whose time constant is "
        "searched; the bracket is turned about the axis and the ray is exact."
    ),
}
"""Texts that state, for every cause of the catalogue and every product of parts, what an agreement
of the two generators proves."""
NOISE_TEXT = """The strangers have no formula in the workbench. Most noise has the form that a
diagnosis fits, which is white noise and up to seven relaxations (Ornstein–Uhlenbeck) of given
time constants, with a scale a run and 36 scales around the turn: *ornstein_uhlenbeck* and
*wandering_reference* are one relaxation of another time constant, *pink* and *power_law* sums of
many, *autoregressive* is one in rows instead of seconds that begins anew in each run. *by_angle*
has a cosine instead of 36 steps. Outliers are Student's t of two degrees of freedom, shifts of an
index mark uniform whole counts; the workbench has neither distribution. It takes the temperature
as the sensor shows it, and the speed from the angle and the time of the rows.
"""


def benchmark_sets_page() -> str:
    """Return the page as Markdown, from the descriptions of the worlds."""
    lines = [MADE, "", "# The sets of the benchmark", "", WORLDS_TEXT.rstrip()]
    lines += [
        f"| {name} | {' '.join((make.__doc__ or '').split())} |" for name, make in WORLDS.items()
    ]
    lines += ["", SECOND_TEXT.rstrip()]
    lines += [f"| {name} | {world.about} |" for name, world in independent_worlds().items()]
    lines += ["", INDEPENDENCE_TEXT.rstrip()]
    lines += [f"| `{name}` | {text} |" for name, text in INDEPENDENCE.items()]
    return "\n".join([*lines, "", NOISE_TEXT])
