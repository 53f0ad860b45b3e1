"""Runs the first act of the demo, from the edges of the simulated heads to the page."""

from __future__ import annotations

import math
import shutil
import subprocess
import sys
import time
from pathlib import Path

import numpy as np

from arctrue.base.printable import time_left
from arctrue.base.progress import ReportStep
from arctrue.base.source_tree import ROOT
from arctrue.base.typed_content import read_json
from arctrue.instrument.turn_score import MOST_ORDER, TurnScore
from arctrue.studies.demo.bench_stage import BenchStage
from arctrue.studies.demo.files import DemoFiles, ProcessorRun
from arctrue.studies.demo.judgement import (
    decode_recording,
    faults,
    index_offset_counts,
    output_score,
    pin_to_pin_latency,
)
from arctrue.studies.demo.result import DemoResult, LoadedHarmonic, UnitLatency
from arctrue.studies.demo.scene import Scene, build_scene
from arctrue.studies.demo.settings import DemoSettings
from arctrue.studies.demo.source_tree import DemoError, check_source_tree, child_environment
from arctrue.studies.demo.telemetry import ReportedTurn, console_faults, telemetry_turns
from arctrue.table import PinEvents

# Latencies in clocks from Table 1 of the paper.
PAPER_LATENCY_CLOCKS = {
    "phase calculation": 5,
    "harmonic calculation": 20,
    "error compensation": 4,
}
_PROGRESS_EVERY_S = 5.0


def run_demo(settings: DemoSettings, folder: Path, report_step: ReportStep) -> DemoResult:
    """Simulate the table, run the gateware with the firmware, and score the output; write
    intermediate files into ``folder``, and pass progress to ``report_step``.

    Raises DemoError if the demo cannot run, and RecordingError if the output of the gateware cannot
    be scored.
    """
    check_source_tree()
    started = time.monotonic()
    files = DemoFiles(folder)
    folder.mkdir(parents=True, exist_ok=True)
    for old in (files.recorded, files.capture, files.run, files.latency, files.progress):
        old.unlink(missing_ok=True)

    report_step("Table: solving for the edges of both heads")
    scene = build_scene(settings)
    settings.write(files.settings)
    scene.pins.write(files.played)
    report_step(
        f"  {scene.pins.clock.size:,} pin changes, {settings.counts_per_rev:,} counts a turn, "
        f"an edge of each head every {settings.clocks_per_count:g} clocks"
    )

    report_step(
        f"Gateware: building the core with {settings.lanes} lanes for GHDL (LLVM); "
        f"firmware: compiling its C for this machine"
    )
    simulating = time.monotonic()
    latency = _start("latency", files)
    _follow(_start("core", files), files, settings, report_step)
    simulation_s = time.monotonic() - simulating
    _finish(latency, "latency", files)

    run = ProcessorRun.read(files.run)
    output = decode_recording(PinEvents.read(files.recorded))
    pin_clocks = pin_to_pin_latency(scene, settings, output)
    turns = telemetry_turns(run.console)
    if not turns or turns[0].result != "applied":
        raise DemoError("the firmware applied no coefficients after the first turn")
    before = output_score(scene, settings, output, _index_clock(scene, settings), pin_clocks)
    after = output_score(scene, settings, output, run.settled_clock, pin_clocks)
    index_offset = index_offset_counts(scene, settings, output, pin_clocks)
    measured = read_json(files.latency, dict[str, int])
    return DemoResult(
        settings=settings,
        before=before,
        after=after,
        faults=(
            *faults(after, index_offset, settings),
            *_latency_faults(measured),
            *console_faults(run.console),
        ),
        latencies=tuple(
            UnitLatency(unit, measured[unit], paper) for unit, paper in PAPER_LATENCY_CLOCKS.items()
        ),
        pin_to_pin_clocks=pin_clocks,
        index_offset_counts=index_offset,
        harmonics=_harmonics(turns[0], settings, before, after),
        turns=tuple(turns),
        console=tuple(run.console),
        words_moved=run.words_moved,
        edges_played=_edges_until(scene, run.end_clock),
        clocks_simulated=run.end_clock,
        simulation_s=simulation_s,
        total_s=time.monotonic() - started,
        simulator=_simulator_name(),
    )


def _start(part: str, files: DemoFiles) -> subprocess.Popen[bytes]:
    with (files.folder / f"{part}.log").open("wb") as log:
        return subprocess.Popen(
            [sys.executable, "-m", "tb.demo.simulator", part, str(files.folder)],
            cwd=ROOT,
            env=child_environment(),
            stdout=log,
            stderr=subprocess.STDOUT,
        )


def _finish(process: subprocess.Popen[bytes], part: str, files: DemoFiles) -> None:
    if process.wait() != 0:
        log = files.folder / f"{part}.log"
        end = "\n".join(log.read_text(encoding="utf-8", errors="replace").splitlines()[-15:])
        raise DemoError(f"the {part} simulation failed; the end of {log}:\n{end}")


def _follow(
    process: subprocess.Popen[bytes],
    files: DemoFiles,
    settings: DemoSettings,
    report_step: ReportStep,
) -> None:
    # The total is an estimate (the run-in, two turns and the read-out); the firmware determines the
    # true end.
    expected = int(2.5 * settings.counts_per_rev * settings.clocks_per_count)
    begun = time.monotonic()
    last: BenchStage | None = None
    spoken = begun
    while process.poll() is None:
        time.sleep(0.2)
        now = time.monotonic()
        seen = BenchStage.read(files.progress)
        if seen is None or (now - spoken < _PROGRESS_EVERY_S and last and last.stage == seen.stage):
            continue
        spoken, last = now, seen
        share = min(99, 100 * seen.clock // expected)
        left = time_left((now - begun) * (100 - share) / share if share else math.inf)
        spent = f"{now - begun:4.0f} s  {share:3d} %  {left} left"
        report_step(f"  {spent}  clock {seen.clock:>7,}  {seen.stage}")
    _finish(process, "core", files)


def _latency_faults(measured: dict[str, int]) -> list[str]:
    found = [
        f"{unit}: measured {measured.get(unit)} clocks, Table 1 has {paper}"
        for unit, paper in PAPER_LATENCY_CLOCKS.items()
        if measured.get(unit) != paper
    ]
    both = measured["phase calculation"] + measured["harmonic calculation"]
    if measured["delay line"] != both:
        found.append(
            f"delay line: measured {measured['delay line']} clocks, phase and harmonic take {both}"
        )
    return found


def _harmonics(
    turn: ReportedTurn, settings: DemoSettings, before: TurnScore, after: TurnScore
) -> tuple[LoadedHarmonic, ...]:
    arcsec = settings.arcsec_per_count
    return tuple(
        LoadedHarmonic(
            order=harmonic.order,
            amplitude_counts=harmonic.amplitude_arcsec / arcsec,
            phase_deg=float(np.rad2deg(np.angle(np.exp(1j * harmonic.phase_rad)))),
            standard_uncertainty_counts=harmonic.standard_uncertainty_arcsec / arcsec,
            before_counts=float(before.amplitude_arcsec[harmonic.order - 1]) / arcsec,
            after_counts=float(after.amplitude_arcsec[harmonic.order - 1]) / arcsec,
        )
        for harmonic in turn.harmonics
        if harmonic.applied and harmonic.order <= MOST_ORDER
    )


def _index_clock(scene: Scene, settings: DemoSettings) -> int:
    """Return the clock of head 1's index, at which the captured turn begins."""
    head = scene.heads[0]
    return int(np.ceil(head.time_s[np.argmax(head.count >= 0)] * settings.clock_hz))


def _edges_until(scene: Scene, clock: int) -> int:
    return int(np.searchsorted(scene.pins.clock, clock))


def _simulator_name() -> str:
    ghdl = shutil.which("ghdl")
    if ghdl is None:
        return "GHDL"
    reply = subprocess.run([ghdl, "--version"], capture_output=True, text=True, check=False)
    words = reply.stdout.split()
    return f"GHDL {words[1]} (LLVM)" if len(words) > 1 else "GHDL (LLVM)"
