"""Computes the simulated table of the demo and the edges of its heads."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from arctrue.base.units import RAD_PER_ARCSEC
from arctrue.studies.demo.settings import DemoSettings
from arctrue.table import (
    HEAD_SEPARATION_RAD,
    CountEdges,
    DiscEccentricity,
    GraduationHarmonics,
    Motion,
    PinEvents,
    RotaryTable,
    clocked_pins,
    count_edges,
    two_heads,
)

# The error before compensation in the paper spans −150.0″ to 137.9″ (section 4): an eccentricity of
# 37.7 µm causes 144″ at a radius of 53.975 mm, and a second order of 6″ shifts both ends of the
# range by −6″.
PAPER_ECCENTRICITY_M = 37.7e-6
ECCENTRICITY_DIRECTION_RAD = 2.1
PAPER_GRADUATION_ORDERS = (2, 3, 4)
PAPER_GRADUATION_ARCSEC = (6.0, 1.2, 0.7)
GRADUATION_PHASES_RAD = (4.2, 2.9, 5.0)

RUN_UP_RAD = float(np.deg2rad(1.0))


@dataclass(frozen=True, slots=True)
class Scene:
    """Table of the demo, its motion, and the pin changes of its heads."""

    table: RotaryTable
    motion: Motion
    heads: tuple[CountEdges, CountEdges]
    pins: PinEvents


def demo_table(settings: DemoSettings) -> RotaryTable:
    """Return the table with the paper's disc; the errors of the disc are enlarged, because the
    demo's counts are larger."""
    scale = settings.disc_scale
    return RotaryTable(
        heads=two_heads(),
        causes=(
            DiscEccentricity(scale * PAPER_ECCENTRICITY_M, ECCENTRICITY_DIRECTION_RAD),
            GraduationHarmonics(
                PAPER_GRADUATION_ORDERS,
                tuple(scale * arcsec * RAD_PER_ARCSEC for arcsec in PAPER_GRADUATION_ARCSEC),
                GRADUATION_PHASES_RAD,
            ),
        ),
        counts_per_rev=settings.counts_per_rev,
        noise_rad=settings.noise_arcsec * RAD_PER_ARCSEC,
    )


def demo_motion(settings: DemoSettings) -> Motion:
    """Return a motion that starts from rest, passes the index of head 2, then the index of head 1,
    and continues."""
    speed = settings.speed_rad_s
    start = -HEAD_SEPARATION_RAD - 2 * RUN_UP_RAD
    ramp_s = 2 * RUN_UP_RAD / speed
    duration_s = settings.turns * 2 * np.pi / speed
    return Motion.steady(
        speed,
        duration_s,
        ramp_s=ramp_s,
        start_rad=start,
        ripple_rad=settings.ripple_rad,
        ripple_order=settings.ripple_order,
    )


def build_scene(settings: DemoSettings) -> Scene:
    """Compute the time of every edge of both heads, and assign the edges to clocks of the
    gateware."""
    table, motion = demo_table(settings), demo_motion(settings)
    random = np.random.default_rng(settings.seed)
    first = count_edges(table, 0, motion, random)
    second = count_edges(table, 1, motion, random)
    pins = clocked_pins((first, second), table.counts_per_rev, settings.clock_hz)
    return Scene(table, motion, (first, second), pins)
