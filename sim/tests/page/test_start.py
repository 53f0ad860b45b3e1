"""Tests that the first page opens files, and that a message states why it refuses a file."""

from __future__ import annotations

import io
import re
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from flask.testing import FlaskClient

from arctrue.measurement import read_measurement_set, write_measurement_set
from arctrue.page.app import make_page
from arctrue.page.jobs import Jobs
from arctrue.page.settings import PageSettings
from arctrue.page.uploads import safe_name
from tests.workbench.small_sets import measurement_set

MOST_BYTES = 1_000_000


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Write two sets, of which one is broken, into the returned folder, and a third set outside
    it."""
    write_measurement_set(tmp_path / "sets" / "good", measurement_set(runs=1, cycles=1, turns=1))
    broken = tmp_path / "sets" / "broken"
    broken.mkdir()
    (broken / "measurement.toml").write_text("schema = 9\n", encoding="utf-8")
    write_measurement_set(tmp_path / "secret", measurement_set(runs=1, cycles=1, turns=1))
    return tmp_path / "sets"


@pytest.fixture
def client(folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[FlaskClient]:
    monkeypatch.setattr(Jobs, "start", lambda *_: None)
    settings = PageSettings(folder, tmp_path / "state", most_bytes=MOST_BYTES, hosts={"localhost"})
    with make_page(settings).app.test_client() as made:
        yield made


def problem(html: str, part: str) -> str:
    """Return the error message in the named part of the first page."""
    section = html[html.index(f'id="{part}"') :].split("</section>")[0]
    return " ".join(re.findall(r'class="problem"[^>]*>([^<]*)', section)).strip()


def sent(name: str, content: bytes) -> dict[str, object]:
    return {"file": [(io.BytesIO(content), name)]}


def test_sets_are_listed_and_a_faulty_one_says_why(client: FlaskClient) -> None:
    html = client.get("/").get_data(as_text=True)
    assert 'value="good"' in html
    assert 'value="broken"' not in html
    assert "schema that this program reads, found 9" in problem(html, "choose")


def test_a_set_is_opened_and_named_as_the_command_line_would(
    client: FlaskClient, folder: Path
) -> None:
    answer = client.post("/open", data={"set": "good"})
    assert answer.status_code == 303
    html = client.get(answer.location).get_data(as_text=True)
    assert f"arctrue compare {folder / 'good'} --model model.toml" in html


@pytest.mark.parametrize("name", ["../secret", "..", "/etc", "good/../../secret", "broken", "a\0b"])
def test_nothing_outside_the_folder_is_opened(client: FlaskClient, name: str) -> None:
    answer = client.post("/open", data={"set": name})
    assert answer.status_code == 422
    assert problem(answer.get_data(as_text=True), "choose")


def test_a_link_to_a_file_outside_is_not_followed(
    client: FlaskClient, folder: Path, tmp_path: Path
) -> None:
    capture = folder / "good" / "capture.csv"
    capture.unlink()
    capture.symlink_to(tmp_path / "secret" / "capture.csv")
    answer = client.post("/open", data={"set": "good"})
    said = problem(answer.get_data(as_text=True), "choose")
    assert "capture.csv of good is a link to a file outside" in said
    (folder / "linked").symlink_to(tmp_path / "secret")
    assert 'value="linked"' not in client.get("/").get_data(as_text=True)


@pytest.mark.parametrize(
    ("name", "content", "said"),
    [
        ("empty.csv", b"", "empty.csv: is empty"),
        ("picture.csv", b"\x89PNG\r\n\x1a\n" + bytes(200), "picture.csv"),
        ("measurement.toml", b"schema = 1\n", "neither"),
        ("measurement.toml", b"not toml [", "measurement.toml"),
        ("../../evil.csv", b"", "evil.csv: is empty"),
        ("", b"", "no file was chosen"),
    ],
)
def test_a_bad_upload_says_why_next_to_it(
    client: FlaskClient, tmp_path: Path, name: str, content: bytes, said: str
) -> None:
    answer = client.post("/drop", data=sent(name, content))
    html = answer.get_data(as_text=True)
    assert answer.status_code == 422
    assert said in problem(html, "dropin")
    # The page shows no path of the server's own folders, and the refused upload leaves no file.
    assert str(tmp_path / "state") not in html
    assert list((tmp_path / "state").iterdir()) == []
    assert not list(tmp_path.parent.glob("evil.csv*"))


def test_objects_in_a_numpy_file_are_not_made(client: FlaskClient) -> None:
    """The server refuses Python objects in the file; pickle would read them and would run code."""

    class Trap:
        def __reduce__(self) -> tuple[object, tuple[str]]:
            return (exec, ("raise SystemExit('code in an upload was run')",))

    file = io.BytesIO()
    np.savez(file, head1=np.array([Trap()], dtype=object))
    answer = client.post("/drop", data=sent("trap.npz", file.getvalue()))
    assert answer.status_code == 422
    assert "trap.npz" in problem(answer.get_data(as_text=True), "dropin")


def test_an_hdf5_file_reads_no_other_file(client: FlaskClient, tmp_path: Path) -> None:
    h5py = pytest.importorskip("h5py")
    secret = tmp_path / "secret.bin"
    secret.write_bytes(np.arange(24, dtype=np.float64).tobytes())
    with h5py.File(tmp_path / "trap.h5", "w") as file:
        file["target"] = np.arange(24) * 15.0
        outside = [(str(secret), 0, 24 * 8)]
        file.create_dataset("error", (24,), np.float64, external=outside)
    content = (tmp_path / "trap.h5").read_bytes()
    answer = client.post("/drop", data=sent("trap.h5", content))
    assert answer.status_code == 422
    said = problem(answer.get_data(as_text=True), "dropin")
    assert "trap.h5: /error: its values are stored in another file" in said


def test_a_huge_file_is_refused_with_the_limit(client: FlaskClient, tmp_path: Path) -> None:
    answer = client.post("/drop", data=sent("big.csv", bytes(MOST_BYTES + 1)))
    assert answer.status_code == 413
    assert "larger than 1 MB" in problem(answer.get_data(as_text=True), "dropin")
    assert list((tmp_path / "state").iterdir()) == []


def test_a_set_is_dropped_in(client: FlaskClient, folder: Path) -> None:
    files = [(io.BytesIO(path.read_bytes()), path.name) for path in (folder / "good").iterdir()]
    answer = client.post("/drop", data={"file": files})
    assert answer.status_code == 303
    assert client.get(answer.location).status_code == 200


def test_what_a_recording_leaves_open_is_asked_until_it_is_a_set(
    client: FlaskClient, tmp_path: Path
) -> None:
    rows = "\n".join(f"{15 * n},{np.cos(np.radians(15 * n)):.3f}" for n in range(24))
    answer = client.post("/drop", data=sent("stage.csv", f"target,error\n{rows}\n".encode()))
    known = {"--unit target": "deg", "--unit error": "arcsec", "--sign": "reading-true"}
    html = answer.get_data(as_text=True)
    assert answer.status_code == 422
    # One screen shows all questions together with the first rows.
    assert re.findall(r'<(?:select|input) name="answer:([^"]+)"', html) == list(known)
    assert "<th>1 target</th><th>2 error</th>" in html
    assert "<td>15</td><td>0.966</td>" in html
    kept = re.findall(r'name="kept" value="([^"]+)"', html)[0]
    # The page asks again for the missing answer and keeps the answers that were given.
    first = {"answer:--unit target": "deg", "answer:--sign": "reading-true", "kept": kept}
    html = client.post("/drop", data=first).get_data(as_text=True)
    assert re.findall(r'<select name="answer:([^"]+)"', html) == ["--unit error"]
    held = dict(re.findall(r'type="hidden" name="(answer:[^"]+)" value="([^"]+)"', html))
    assert held["answer:--unit target"] == "deg"
    data = {f"answer:{name}": value for name, value in known.items()}
    answer = client.post("/drop", data={**data, "kept": kept})
    assert answer.status_code == 303, problem(answer.get_data(as_text=True), "dropin")
    (made,) = (tmp_path / "state").glob("*/set")
    error = read_measurement_set(made).reference.error_arcsec  # type: ignore[union-attr]
    assert error[0] - error[12] == pytest.approx(2.0)
    html = client.get(answer.location).get_data(as_text=True)
    for option, value in known.items():
        name, _, key = option.partition(" ")
        assert f"{name} {key + '=' if key else ''}{value}" in html


@pytest.mark.parametrize("seed", ["-1", "x", "99999999999", "1e3"])
def test_a_seed_that_is_none_is_refused(client: FlaskClient, seed: str) -> None:
    answer = client.post("/generate", data={"experiment": "lean", "seed": seed})
    assert answer.status_code == 422
    assert "seed: expected a whole number" in problem(answer.get_data(as_text=True), "made")


@pytest.mark.parametrize(
    ("given", "safe"),
    [
        ("../../etc/passwd", "passwd"),
        ("C:\\temp\\run 1.csv", "run 1.csv"),
        ("..", "file"),
        ("a\x1b[31m\n.csv", "a_x1b_31m_n.csv"),
        (".hidden", "hidden"),
        ("x" * 300 + ".csv", "x" * 76 + ".csv"),
    ],
)
def test_a_name_is_only_a_name(given: str, safe: str) -> None:
    assert safe_name(given) == safe


def test_another_page_cannot_use_the_server(client: FlaskClient) -> None:
    for headers in ({"Origin": "http://evil.example"}, {"Sec-Fetch-Site": "cross-site"}):
        answer = client.post("/open", data={"set": "good"}, headers=headers)
        assert answer.status_code == 403
    # An attacker can let such a host name resolve to 127.0.0.1.
    assert client.get("/", headers={"Host": "evil.example"}).status_code == 403


def test_a_server_for_others_wants_its_token(folder: Path, tmp_path: Path) -> None:
    settings = PageSettings(folder, tmp_path / "state", token="right")
    with make_page(settings).app.test_client() as client:
        assert client.get("/").status_code == 403
        assert client.get("/?token=wrong").status_code == 403
        answer = client.get("/?unit=%C2%B5rad&token=right&unit=deg")
        assert answer.location == "/?unit=%C2%B5rad&unit=deg"
        assert client.get(answer.location).status_code == 200
