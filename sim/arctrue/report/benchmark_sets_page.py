"""Makes the page about the benchmark's sets: the worlds of both generators (the simulated table and
the package ``independent``), and how independent the generators are."""

from __future__ import annotations

from collections.abc import Callable

from arctrue.studies.benchmark.independent.world import independent_worlds
from arctrue.studies.benchmark.worlds import WORLDS

MADE = "<!-- Made by scripts/make_docs.py from the worlds. Do not edit: make docs -->"
WORLDS_TEXT = """## The first generator, based on the simulated table

A *world* is a kind of measurement with its disturbances. Unless the world says otherwise, a set has
24,000 rows of two heads in four runs (up, down, three times as fast, warm) and ten cycles over a
polygon. Each world has five kinds of sets: sets without a cause; with one cause of the catalogue;
with a product of parts (a condition times a wave, such as temperature × order 2) that is not in the
catalogue; with a *stranger*, a cause that no product of parts can represent; and with two or three
causes at once. Causes and sizes are drawn at random from the ranges that `arctrue simulate --list`
shows; causes that look like each other may be drawn too.

| world | disturbances of the measurement |
|---|---|
"""

SECOND_TEXT = """## The second generator

The option `--generator independent` selects the second generator; with `--generator both` it makes
a fifth of the sets. Its author wrote it from the physics, without having read the effects of the
workbench or the first generator, and it imports no code of them. Its noise is white noise, noise
with Student's t distribution, a relaxation (exponentially correlated noise), a random walk, 1/f
noise by fractional integration, or a driven oscillator.

Each set states which answers are right: names with the same meaning, and verdicts that the design
of the measurement allows (for example `ambiguous` if the temperature rises with time; the score
counts this as *left open, rightly*). For a periodic error the set also states the order or the
frequency: the right name at another order or frequency is a false name. A damped oscillator in the
noise counts as a cause that the catalogue does not have: `unknown` is right if the diagnosis states
the oscillator's frequency within the half width at half power.

The oracle is an ideal test that uses the true form of the cause and the noise. The oracle of the
second generator removes from each cause, by projection, 20 orders, the offsets of the runs and all
other causes, and whitens the result with the spectrum of the drawn noise.

| world | what is measured, and what may be hidden |
|---|---|
"""
INDEPENDENCE_TEXT = """## How independent the first generator is of the effects

The first generator moves discs and heads by exact plane geometry and solves for the reading; it
shares no code with the workbench. If the formula of a cause equals the formula of the
workbench's effect, a right diagnosis shows that the search and the statistics work, but not that
the physics is right.

| effect | do cause and effect have the same formula? |
|---|---|
"""
INDEPENDENCE = {
    "high_order_graduation": "Yes: both are a sine of one order on the graduation.",
    "head_angle_error": (
        "To first order. The generator turns the bracket about the axis and computes the exact ray "
        "from the disc's centre; the effect is a constant plus the slope of the fitted error."
    ),
    "subdivision_error": (
        "No. The generator computes atan2 of sine and cosine with errors of offset, gain and "
        "phase; the effect is a Fourier series in the electrical phase."
    ),
    "radial_error_motion": (
        "To first order. The generator moves the axis on an ellipse and computes exact rays; the "
        "effect is the motion divided by the radius."
    ),
    "bearing_ball_pass": (
        "To first order, as for radial motion; the order is not an integer, and the workbench "
        "searches for it."
    ),
    "vibration": (
        "Yes: both are a sine of one frequency, with a separate phase in each run. The generator "
        "turns the head about the axis by this sine and computes the exact ray; the effect omits "
        "the slope of the error."
    ),
    "hysteresis": (
        "Yes for one of the effect's transitions: both are Dahl's model after a reversal. The "
        "generator twists the shaft; the effect fits a separate size of the transition."
    ),
    "timing_skew": (
        "To first order. The generator reads head 2 at the later position of the table, with the "
        "error at this position; the effect is delay times speed."
    ),
    "latency": "Yes: the reading belongs to the angle one delay earlier.",
    "thermal_head_drift": (
        "To first order. The generator turns the bracket about the axis in proportion to the "
        "temperature change and computes the exact ray; the effect omits the slope of the error."
    ),
    "thermal_eccentricity": (
        "To first order. The generator moves the disc's centre in proportion to the temperature "
        "change and computes exact rays; the effect is order 1 times the temperature change."
    ),
    "count_slip": (
        "Yes: both are a step at one instant of one run. The generator's step is a whole number of "
        "counts, the effect's step has any size."
    ),
    "graduation_defect": (
        "No. The generator's defect has edges of any steepness and may be asymmetric; the effect "
        "is a symmetric bell."
    ),
    "drive_gear_error": (
        "No. The generator's tooth pitch varies once per turn. This modulates the phase of the "
        "tooth order and causes orders on both sides of it with related sizes and phases. The "
        "effect is the tooth order with as many multiples and neighbouring orders as the data "
        "show; their sizes and phases are independent."
    ),
    "polygon_face_error": "Yes: both are a constant for each face.",
    "polygon_eccentricity": (
        "Nearly. The generator computes tilt, roll and concave faces by geometry; the result is "
        "an order 1 and a gain of cos 1° − 1 = −0.015 %. The effect is the order 1."
    ),
    "autocollimator_gain": (
        "Yes: both are a share of the error; the generator uses the table's true error, the effect "
        "the fitted error."
    ),
    "reference_drift": (
        "No. The generator adds a constant rate and a temperature that is a random walk; the "
        "effect is proportional to time."
    ),
    "warm_ovality": "Yes: both are temperature change times a sine of order 2 on the disc.",
    "centrifugal_lobes": "Yes: both are speed squared times a sine of order 3 on the disc.",
    "half_order": (
        "To first order. The generator moves the axis along a line at a half-integer order and "
        "computes exact rays; the product of parts is a sine of any order, fixed to the stator."
    ),
    "settling_bracket": (
        "Yes: both are an exponential in the time from the start of the measurement or of the run; "
        "the workbench searches for the time constant. The generator turns the bracket about the "
        "axis and computes the exact ray."
    ),
}
"""Texts that state, for every cause of the catalogue and every product of parts, whether the
generator's cause and the workbench's effect have the same formula."""
NOISE_TEXT = """The workbench has no formula for the strangers.

The diagnosis fits noise as the sum of white noise and up to seven relaxations (Ornstein–Uhlenbeck
processes) with given time constants; one factor per run and 36 factors around the turn scale this
noise. Most noise of the first generator has a similar form:

- *ornstein_uhlenbeck* and *wandering_reference* are one relaxation with a different time constant.
- *pink* and *power_law* are sums of many relaxations.
- *autoregressive* is a relaxation whose time constant is a number of rows instead of seconds; it
  starts again in each run.
- *by_angle* scales the noise with a cosine of the angle instead of 36 steps.

Outliers have Student's t distribution with two degrees of freedom; the shift of an index mark is a
whole number of counts with uniform distribution. The workbench models neither distribution. The
workbench uses the temperature that the sensor shows, and computes the speed from the angle and the
time of the rows.
"""


def _about(make: Callable[..., object]) -> str:
    """Return the disturbances that the docstring of a world's function states, as a sentence."""
    said = " ".join((make.__doc__ or "").split()).removeprefix("Draw disturbances in which ")
    return said[:1].upper() + said[1:]


def benchmark_sets_page() -> str:
    """Return the page as Markdown, from the descriptions of the worlds."""
    lines = [MADE, "", "# The sets of the benchmark", "", WORLDS_TEXT.rstrip()]
    lines += [f"| {name} | {_about(make)} |" for name, make in WORLDS.items()]
    lines += ["", SECOND_TEXT.rstrip()]
    lines += [f"| {name} | {world.about} |" for name, world in independent_worlds().items()]
    lines += ["", INDEPENDENCE_TEXT.rstrip()]
    lines += [f"| `{name}` | {text} |" for name, text in INDEPENDENCE.items()]
    return "\n".join([*lines, "", NOISE_TEXT])
