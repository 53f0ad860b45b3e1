"""Tests the import of logs of PHD2, LinuxCNC and EPICS, which the tests write in the public
formats."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from arctrue.base.units import ARCSEC_PER_TURN
from arctrue.importing import (
    AmbiguousError,
    Choices,
    ReadSettings,
    Settings,
    import_recordings,
    read_recording,
)
from arctrue.importing.file_content import FileContent
from arctrue.measurement import MeasurementError, Reference

HEADER = (
    "Frame,Time,mount,dx,dy,RARawDistance,DECRawDistance,RAGuideDistance,DECGuideDistance,"
    "RADuration,RADirection,DECDuration,DECDirection,XStep,YStep,StarMass,SNR,ErrorCode"
)
SCALE, DECLINATION_DEG, RATE_PX_S = 2.66, 22.6, 5.0


def read(path: Path, name: str = "", **settings: object) -> FileContent:
    return read_recording(path, name, ReadSettings(**settings), Choices())  # type: ignore[arg-type]


def worm(time_s: float) -> float:
    """Return the periodic error of an unguided axis in pixels of the camera."""
    return 1.3 * math.sin(2 * math.pi * time_s / 120.0)


def guide_log(path: Path, *, dither_at: int = -1, begin: str = "") -> None:
    """Write the log of a guided mount, in which each pulse corrects half of the measured error and
    lasts at most 100 ms."""
    lines = [
        "PHD2 version 2.6.9, Log version 2.5. Log enabled at 2026-01-31 20:00:00",
        "",
        "Guiding Begins at 2026-01-31 20:10:00",
        f"Pixel scale = {SCALE} arc-sec/px, Binning = 1, Focal length = 400 mm",
        f"RA = 5.20 hr, Dec = {DECLINATION_DEG} deg, Hour angle = -1.2 hr, Pier side = East",
        f"Mount = M,xAngle = 91.0, xRate = {RATE_PX_S:.3f}, yAngle = 1.0, yRate = {RATE_PX_S:.3f}",
        HEADER,
    ]
    sent = lock = 0.0
    for frame in range(1, 201):
        time_s = 2.0 * frame
        if frame == dither_at:
            lines.append("INFO: DITHER by 1.500, 0.000, new lock pos = 10.0, 20.0")
            lock = 4.0
        if frame == 50:
            lines.append(f'{frame},{time_s:.3f},"DROP",,,,,,,,,,,,,0,0,3,"Star lost"')
            continue
        raw = worm(time_s) - sent - lock
        duration_ms = min(round(abs(0.5 * raw) / RATE_PX_S * 1000.0), 100)
        way = "W" if raw > 0 else "E"
        lines.append(
            f'{frame},{time_s:.3f},"Mount",{raw:.3f},0.0,{raw:.6f},0.0,{0.5 * raw:.6f},0.0,'
            f"{duration_ms},{way},0,,,,1000,20.0,0"
        )
        sent += math.copysign(duration_ms / 1000.0 * RATE_PX_S, raw)
    path.write_text(begin + "\n".join([*lines, "Guiding Ends at 2026-01-31 20:20:00"]) + "\n")


def phd2(path: Path, sign: str = "reading-true") -> Reference:
    found = import_recordings([read(path)], Settings(sign=sign), Choices()).measurement.reference
    assert found is not None
    return found


def test_a_guide_log_gives_the_error_without_guiding(tmp_path: Path) -> None:
    guide_log(tmp_path / "PHD2_GuideLog.txt")
    found = phd2(tmp_path / "PHD2_GuideLog.txt")
    assert found.time_s is not None
    assert found.instrument == "guide star"
    assert found.time_s.size == 199, "the dropped frame is left out"
    on_axis = SCALE / math.cos(math.radians(DECLINATION_DEG))
    expected = np.array([worm(t) for t in found.time_s]) * on_axis
    # The log has six decimals of a pixel.
    np.testing.assert_allclose(found.error_arcsec, expected - expected.mean(), atol=1e-4)
    # At the sidereal rate the axis rotates by 15.041″ per second.
    np.testing.assert_allclose(found.target_deg * 3600.0 / found.time_s, 15.041067, rtol=1e-6)


def test_a_dither_begins_a_new_run(tmp_path: Path) -> None:
    guide_log(tmp_path / "log.txt", dither_at=120, begin="\ufeff")
    found = phd2(tmp_path / "log.txt")
    assert found.run is not None
    assert np.bincount(found.run).tolist() == [118, 81]


def test_the_sign_of_a_guide_log_is_asked_for(tmp_path: Path) -> None:
    guide_log(tmp_path / "log.txt")
    with pytest.raises(AmbiguousError, match="--sign"):
        phd2(tmp_path / "log.txt", sign="")


def test_stretches_of_guiding_have_one_clock_and_one_axis(tmp_path: Path) -> None:
    """If guiding of the same star begins again after 1,000 s, the axis continues at its angle of
    that time. For a star 1 h farther east it stands 15° farther back."""
    for hours, name in ((5.20, "same"), (6.20, "east")):
        guide_log(tmp_path / "log.txt")
        text = (tmp_path / "log.txt").read_text(encoding="utf-8")
        again = text.split("\n\n", 1)[1].replace("20:10:00", "20:26:40")
        again = again.replace("RA = 5.20 hr", f"RA = {hours:.2f} hr")
        (tmp_path / f"{name}.txt").write_text(text + again, encoding="utf-8")
        found = phd2(tmp_path / f"{name}.txt")
        assert found.time_s is not None
        second = found.run == found.run[-1]
        assert found.time_s[second][0] == pytest.approx(1000.0 + found.time_s[~second][0])
        moved = found.target_deg[second][0] - found.target_deg[~second][0]
        expected = 1000.0 * 360.0 / 86164.0905 - (hours - 5.20) * 15.0
        assert moved == pytest.approx(expected, abs=1e-9)


def test_a_change_of_the_side_of_the_pier_turns_the_axis_by_half_a_turn(tmp_path: Path) -> None:
    """A German mount that changes from the west to the east side of its pier turns its axis back by
    180° and then follows the same star again. The error of the axis keeps its sign."""
    guide_log(tmp_path / "log.txt")
    text = (tmp_path / "log.txt").read_text(encoding="utf-8")
    before = text.replace("Pier side = East", "Pier side = West")
    after = text.split("\n\n", 1)[1].replace("20:10:00", "20:26:40")
    (tmp_path / "flip.txt").write_text(before + after, encoding="utf-8")
    found = phd2(tmp_path / "flip.txt")
    second = found.run == found.run[-1]
    moved = found.target_deg[second][0] - found.target_deg[~second][0]
    assert moved == pytest.approx(1000.0 * 360.0 / 86164.0905 - 180.0, abs=1e-9)


def test_a_last_row_that_is_cut_is_left_out(tmp_path: Path) -> None:
    """If the guiding program ended while it wrote a row, the import takes all other rows of the
    log."""
    guide_log(tmp_path / "log.txt")
    whole = phd2(tmp_path / "log.txt")
    text = (tmp_path / "log.txt").read_text(encoding="utf-8").rstrip("\n")
    rows, last = text.rsplit("\n", 1)
    while not last[:1].isdigit():
        rows, last = rows.rsplit("\n", 1)
    for kept in (3, 5):
        cut = ",".join(last.split(",")[:kept])
        (tmp_path / "cut.txt").write_text(f"{rows}\n{cut}", encoding="utf-8")
        found = phd2(tmp_path / "cut.txt")
        assert found.time_s is not None
        assert whole.time_s is not None
        assert found.time_s.tolist() == whole.time_s[:-1].tolist()
    content = read(tmp_path / "cut.txt")
    assert any("the last row is cut" in note for note in content.notes)


def test_a_guide_log_without_declination_is_refused(tmp_path: Path) -> None:
    guide_log(tmp_path / "log.txt")
    text = (tmp_path / "log.txt").read_text().replace(f"Dec = {DECLINATION_DEG} deg, ", "")
    (tmp_path / "log.txt").write_text(text)
    with pytest.raises(MeasurementError, match=r"log\.txt, row 8: the log does not state the star"):
        phd2(tmp_path / "log.txt")


def test_samples_of_linuxcnc_with_an_overrun(tmp_path: Path) -> None:
    rows = [f"{n} {n * 0.36:.4f} {n * 0.36 + 0.01:.4f}" for n in range(40) if n not in (20, 21)]
    rows.insert(20, "overrun")
    path = tmp_path / "samples.txt"
    path.write_text("\n".join(rows) + "\n")
    found = read(path, period_s=0.002)
    assert found.format == "linuxcnc"
    np.testing.assert_allclose(found.columns["time_s"][[0, 19, 20]], [0.0, 0.038, 0.044])
    assert any("2 samples are lost" in note for note in found.notes)
    with pytest.raises(AmbiguousError, match="--period"):
        read(path)
    path.write_text("\n".join(row.partition(" ")[2] or row for row in rows) + "\n")
    with pytest.raises(MeasurementError, match="row 21: samples were lost here"):
        read(path, period_s=0.002)


@pytest.mark.parametrize("period_s", [0.0, -1.0, float("nan")])
def test_a_period_from_python_is_checked(tmp_path: Path, period_s: float) -> None:
    path = tmp_path / "samples.csv"
    path.write_text("target_deg,head1_deg\n" + "".join(f"{n},{n}\n" for n in range(40)))
    with pytest.raises(ValueError, match="--period: expected seconds above 0, found"):
        read(path, period_s=period_s)


def epics_log(path: Path, deg_s: float = 2.0) -> None:
    lines = []
    for n in range(200):
        at = n * 0.1
        second, micro = int(at), round((at % 1.0) * 1e6)
        angle = deg_s * at % 360.0
        lines.append(f"AX:Enc-RB  2026-01-31 12:00:{second:02d}.{micro:06d} {angle:.6f}")
        late = at + 0.05
        second, micro = int(late), round((late % 1.0) * 1e6)
        angle = deg_s * late % 360.0
        lines.append(f"AX:Ref-I   2026-01-31 12:00:{second:02d}.{micro:06d} {angle:.6f} HIGH")
    path.write_text("AX:Enc-RB  *** Not connected (PV not found)\n" + "\n".join(lines) + "\n")


def test_a_log_of_epics_variables(tmp_path: Path) -> None:
    epics_log(tmp_path / "monitor.log")
    with pytest.raises(AmbiguousError, match="--group AX:Enc-RB, --group AX:Ref-I"):
        read(tmp_path / "monitor.log")
    found = read(tmp_path / "monitor.log", group="AX:Ref-I")
    assert found.format == "epics"
    settings = Settings(
        columns={"target": "AX:Ref-I", "head1": "AX:Enc-RB"},
        units={"target": "deg", "head1": "deg"},
    )
    reference = import_recordings([found], settings, Choices()).measurement.reference
    assert reference is not None
    # Interpolation of a straight line is exact; the log has six decimals of a degree.
    assert np.abs(reference.error_arcsec).max() < 1e-6 / 360.0 * ARCSEC_PER_TURN


def test_an_epics_angle_is_not_interpolated_across_the_end_of_a_turn(tmp_path: Path) -> None:
    """At 33°/s the encoder restarts once in 20 s. The import leaves out the row in this step,
    because an interpolated value between 359° and 2° would be wrong."""
    epics_log(tmp_path / "monitor.log", deg_s=33.0)
    found = read(tmp_path / "monitor.log", group="AX:Ref-I")
    away = found.columns["AX:Enc-RB"] - found.columns["AX:Ref-I"]
    # Bound: six decimals of a degree, and the resolution of a time since 1970 in float64.
    assert np.abs(away).max() <= 1e-6 + 33.0 * float(np.spacing(1.77e9))
    assert found.rows == 198  # 200 without the row after the last angle of the encoder
    assert any("AX:Enc-RB steps once by more than half of its range" in n for n in found.notes)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("1,2\n3,x\n5,6\n", "row 2, column 2: expected a number, found 'x'"),
        ("1,2\n3\n5,6\n7,8\n", "row 2: expected 2 fields, found 1"),
        ('{"a": 1}\n{"a": }\n', "row 2: is not JSON"),
        ('{"a": 1}\n{"a": [1]}\n', "row 2, column a: expected a number or a text"),
        ("", "is empty"),
        ("no numbers here\n", "no rows of numbers"),
    ],
)
def test_faults_name_file_row_and_column(tmp_path: Path, text: str, said: str) -> None:
    path = tmp_path / "bad.txt"
    path.write_text(text)
    with pytest.raises(MeasurementError) as caught:
        import_recordings(
            [read(path)],
            Settings(
                columns={"target": "1", "error": "2"},
                units={"target": "deg", "error": "deg"},
                sign="reading-true",
            ),
            Choices(),
        )
    assert str(path) in str(caught.value)
    assert said in str(caught.value)


def test_a_comma_that_may_be_either_is_asked_for(tmp_path: Path) -> None:
    path = tmp_path / "a.txt"
    path.write_text("1,250 2,250\n1,500 2,500\n")
    with pytest.raises(AmbiguousError, match="--decimal point, --decimal comma"):
        read(path)
    assert read(path, decimal="comma").columns["1"].tolist() == [1.25, 1.5]
    assert read(path, decimal="point").columns["1"].tolist() == [1250, 1500]
    path.write_text("1,25 2,250\n1,500 2,500\n")
    assert read(path).columns["1"].tolist() == [1.25, 1.5]
    path.write_text("10.0;1\n20.0;2\n")
    assert read(path).columns["1"].tolist() == [10.0, 20.0]
    path.write_text("1;2\n3;4\n")
    assert read(path).columns["2"].tolist() == [2, 4]


def test_pickled_objects_are_never_loaded(tmp_path: Path) -> None:
    np.save(tmp_path / "a.npy", np.array([{"a": 1}], dtype=object), allow_pickle=True)
    with pytest.raises(MeasurementError, match="cannot be read as NumPy"):
        read(tmp_path / "a.npy")
