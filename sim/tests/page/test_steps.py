"""Tests that the server keeps the steps of a model, each with its own address, and that tabs do not
affect each other."""

from __future__ import annotations

import io
import json
import re
import shutil
from collections.abc import Iterator
from pathlib import Path
from threading import Thread

import pytest
from flask.testing import FlaskClient

from arctrue.base.json_text import plain
from arctrue.measurement import write_measurement_set
from arctrue.page.analyses import analyse_opened
from arctrue.page.app import make_page
from arctrue.page.jobs import AT_ONCE, CANCELLED, Jobs
from arctrue.page.ranking_key import ranking_key
from arctrue.page.session import NoSuchSessionError, Session, Sessions
from arctrue.page.settings import PageSettings
from arctrue.report.ranking import Ranking, ranked
from arctrue.workbench.effects.new_effect import write_new_effect
from arctrue.workbench.effects.registry import built_in, catalogue
from arctrue.workbench.model.model import default_model
from arctrue.workbench.model.model_file import read_model
from tests.workbench.small_sets import measurement_set, paper_error

EFFECT = "hysteresis"
FOLLOWS_NONE = "follows none of the conditions"
START = Jobs.start
"""The method ``Jobs.start``, saved before a fixture replaces it."""


@pytest.fixture(scope="module")
def settings(tmp_path_factory: pytest.TempPathFactory) -> PageSettings:
    folder = tmp_path_factory.mktemp("page")
    made = measurement_set(paper_error, runs=2, cycles=2, turns=1)
    write_measurement_set(folder / "sets" / "one", made)
    return PageSettings(folder / "sets", folder / "state")


@pytest.fixture(scope="module")
def client(settings: PageSettings) -> Iterator[FlaskClient]:
    """Return the client of a page that starts no ranking."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Jobs, "start", lambda *_: None)
        with make_page(settings).app.test_client() as made:
            yield made


@pytest.fixture(scope="module")
def opened(client: FlaskClient) -> str:
    """Return the address of the first step in a session that many tests share."""
    return str(client.post("/open", data={"set": "one"}).location)


@pytest.fixture
def first(client: FlaskClient) -> str:
    """Return the address of the first step in a new session."""
    return str(client.post("/open", data={"set": "one"}).location)


def names(client: FlaskClient, address: str, tmp_path: Path) -> list[str]:
    """Return the names of the effects in the model of this step."""
    file = tmp_path / "downloaded.toml"
    file.write_bytes(client.get(f"{address}model.toml").data)
    return read_model(file).names()


def step(location: str) -> str:
    return location.split("#")[0].split("?")[0]


def test_adding_gives_a_new_address_and_leaves_the_old_one(
    client: FlaskClient, first: str, tmp_path: Path
) -> None:
    answer = client.post(f"{first}add?unit=urad", data={"effect": EFFECT})
    assert answer.status_code == 303
    assert answer.location.endswith("/2/?unit=urad#ladder")
    assert names(client, first, tmp_path) == ["graduation_harmonics"]
    assert names(client, step(answer.location), tmp_path) == ["graduation_harmonics", EFFECT]
    html = client.get(answer.location).get_data(as_text=True)
    assert re.search(r'id="undo" href="[^"]*/1/\?unit=urad"', html)
    assert f"arctrue add {EFFECT} " in html


def test_two_tabs_go_their_own_ways(client: FlaskClient, opened: str, tmp_path: Path) -> None:
    one = step(client.post(f"{opened}add", data={"effect": EFFECT}).location)
    other = step(client.post(f"{opened}add", data={"effect": "timing_skew"}).location)
    third = step(client.post(f"{one}drop", data={"effect": EFFECT}).location)
    assert names(client, one, tmp_path)[1:] == [EFFECT]
    assert names(client, other, tmp_path)[1:] == ["timing_skew"]
    assert names(client, third, tmp_path)[1:] == []
    history = read_model(tmp_path / "downloaded.toml").history
    assert [item.action for item in history] == ["fit", "add", "drop"]
    assert all(item.date and item.measurement_sha256 for item in history)


def test_steps_outlive_the_server(client: FlaskClient, opened: str, settings: PageSettings) -> None:
    after = step(client.post(f"{opened}add", data={"effect": EFFECT}).location)
    before = client.get(f"{after}figure/ladder.json").json
    with make_page(settings).app.test_client() as again:
        assert again.get(f"{after}figure/ladder.json").json == before


def test_what_cannot_be_done_is_said_next_to_its_button(client: FlaskClient, opened: str) -> None:
    for action, effect, said in (
        ("add", "graduation_harmonics", "the model has graduation_harmonics already"),
        ("add", "drive_gear_error", "cannot be tested with this set: it lacks"),
        ("add", "__import__('os')", "no effect is named"),
        ("drop", "graduation_harmonics", "nothing would be left"),
    ):
        answer = client.post(f"{opened}{action}", data={"effect": effect})
        assert answer.status_code == 422
        assert said in answer.get_data(as_text=True).replace("&#39;", "'")


def test_a_model_is_downloaded_and_loaded(client: FlaskClient, opened: str, tmp_path: Path) -> None:
    after = step(client.post(f"{opened}add", data={"effect": EFFECT}).location)
    file = client.get(f"{after}model.toml").data
    other = str(client.post("/open", data={"set": "one"}).location)
    answer = client.post(f"{other}model", data={"model": (io.BytesIO(file), "m.toml")})
    assert names(client, step(answer.location), tmp_path) == ["graduation_harmonics", EFFECT]
    assert len(read_model(tmp_path / "downloaded.toml").history) == 2


@pytest.mark.parametrize(
    ("content", "said"),
    [
        ("schema = 1\n", "expected one [[effect]] or more"),
        ("\x00", "m.toml: "),
        ('schema = 1\n[[effect]]\nname = "nothing_known"\n', "no effect is named"),
        (
            'schema = 1\n[table]\ncounts_per_rev = 4096\n[[effect]]\nname = "hysteresis"\n',
            "of another table: 4096 counts a turn, the set 16777216",
        ),
    ],
)
def test_a_bad_model_file_says_why(
    client: FlaskClient, opened: str, content: str, said: str
) -> None:
    answer = client.post(f"{opened}model", data={"model": (io.BytesIO(content.encode()), "m.toml")})
    assert answer.status_code == 422
    assert said in answer.get_data(as_text=True).replace("&#39;", "'")


def test_a_model_file_brings_no_code(client: FlaskClient, opened: str, tmp_path: Path) -> None:
    """A model file cannot bring an effect file, which contains code. The server runs only the
    effect files in the folder that the command line names."""
    trap = tmp_path / "effects"
    trap.mkdir()
    (trap / "trap.py").write_text(
        f"open({str(tmp_path / 'was_run')!r}, 'w').close()\n", encoding="utf-8"
    )
    text = f'schema = 1\neffect_folders = ["{trap}"]\n[[effect]]\nname = "graduation_harmonics"\n'
    answer = client.post(f"{opened}model", data={"model": (io.BytesIO(text.encode()), "m.toml")})
    assert answer.status_code == 303
    assert not (tmp_path / "was_run").exists()
    assert "effect_folders" not in client.get(f"{step(answer.location)}model.toml").text


@pytest.mark.parametrize(
    "address",
    ["/s/0123456789abcdef/1/", "/s/../1/", "/s/..%2f..%2fetc/1/", "{}99/", "{}figure/x.json",
     "{}figure/..%2f..%2fsession.json", "{}diagnosis.json", "{}coefficients.toml"],
)  # fmt: skip
def test_what_is_not_there_is_said(client: FlaskClient, opened: str, address: str) -> None:
    answer = client.get(address.format(opened.removesuffix("1/") if "99" in address else opened))
    assert answer.status_code == 404
    assert "problem" in answer.text


def test_a_session_can_be_deleted(client: FlaskClient, first: str) -> None:
    name = first.split("/")[2]
    start = client.get("/").text
    assert "Delete the session of" in start.split(f'action="/forget/{name}" data-confirm="')[1]
    answer = client.post(f"/forget/{name}")
    assert (answer.status_code, answer.location) == (303, "/")
    assert client.get(first).status_code == 404


@pytest.mark.parametrize("action", ["add", "drop", "model", "load"])
def test_the_address_of_a_form_leads_to_its_step(
    client: FlaskClient, opened: str, action: str
) -> None:
    answer = client.get(f"{opened}{action}")
    assert answer.status_code == 303
    assert step(answer.location) == opened


def test_a_page_is_not_kept_by_the_browser(client: FlaskClient, opened: str) -> None:
    for address in ("/", opened):
        assert client.get(address).headers["Cache-Control"] == "no-store"


def test_a_temperature_that_cannot_be_used_is_shown_with_the_reason(
    client: FlaskClient, opened: str
) -> None:
    answer = client.get(f"{opened}?temperature=abc").text
    assert "abc: expected a temperature from -200 to 200 °C" in answer


def test_numbers_of_steps_are_given_once(tmp_path: Path) -> None:
    folder = Sessions(tmp_path).make()
    session = Session(folder)

    def grow() -> None:
        session.grow(
            default_model(), parent=None, action="add", effect="x", command="", seconds=0.0
        )

    threads = [Thread(target=grow) for _ in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert [step.number for step in session.steps()] == list(range(1, 9))
    with pytest.raises(NoSuchSessionError):
        session.step(9)


def test_a_ranking_is_ended_and_says_so(settings: PageSettings, first: str) -> None:
    session = Sessions(settings.state)[first.split("/")[2]]
    jobs = Jobs(())
    START(jobs, session, 1)
    assert jobs.state(session, 1)["state"] == "running"
    jobs.cancel(session, 1)
    jobs.wait()
    assert jobs.state(session, 1)["state"] == "cancelled"
    assert (session.step_folder(1) / CANCELLED).exists()


@pytest.mark.parametrize(
    "queued", [pytest.param(False, marks=pytest.mark.large), True], ids=["running", "waiting"]
)
def test_a_deleted_session_stays_deleted(
    settings: PageSettings, first: str, rankings: list[Ranking], queued: bool
) -> None:
    """The page ends the ranking of a session before it deletes the session, whether the ranking
    runs or waits for a place; a process that writes later makes no folder."""
    made = make_page(settings)
    session = made.analyses.sessions[first.split("/")[2]]
    for _ in range(AT_ONCE if queued else 0):
        made.jobs._places.acquire()
    START(made.jobs, session, 1)
    with made.app.test_client() as client:
        assert client.post(f"/forget/{session.name}").status_code == 303
    made.jobs.wait()
    with pytest.raises(FileNotFoundError):
        session.write_ranking(1, rankings[0])
    assert not session.folder.exists()


def test_a_ranking_that_fails_says_why(settings: PageSettings, first: str) -> None:
    session = Sessions(settings.state)[first.split("/")[2]]
    (session.step_folder(1) / "model.toml").write_text("schema = 7\n", encoding="utf-8")
    jobs = Jobs(())
    START(jobs, session, 1)
    jobs.wait()
    state = jobs.state(session, 1)
    assert state["state"] == "failed"
    assert "expected 1, found 7" in state["doing"]


@pytest.fixture(scope="module")
def rankings(settings: PageSettings, client: FlaskClient, opened: str) -> list[Ranking]:
    """Return the rankings (comparisons of all effects) that a job writes for the first step: first
    the partial ranking, then the complete one.

    The model of the step contains only graduation_harmonics.
    """
    session = Sessions(settings.state)[opened.split("/")[2]]
    analysis = analyse_opened(session.opened, session.model(1), built_in())
    found: list[Ranking] = []
    whole = ranked(analysis, partly=lambda part: found.append(plain({**part, "whole": False})))
    return [*found, plain({**whole, "whole": True})]


def section(html: str, name: str) -> str:
    return html.split(f'<section id="{name}"')[1].split("</section>")[0]


def test_what_is_not_judged_yet_is_not_denied(
    client: FlaskClient, first: str, settings: PageSettings, rankings: list[Ranking]
) -> None:
    session = Sessions(settings.state)[first.split("/")[2]]
    partly, whole = rankings
    for found in (partly, whole):
        found["diagnosis"]["lack_of_fit"]["reference"]["p_value"] = 1e-9
    session.write_ranking(1, partly)
    where = section(client.get(first).text, "where")
    assert FOLLOWS_NONE not in where
    assert "diagnosis will state" in where

    # The ranking now contains the share of the residual that each condition explains. In the first
    # case every share is 0; in the second, every share is 24 %, which the page shows but which is
    # too small to name a condition as the cause.
    quiet = [{**item, "share": 0.0} for item in whole["regressors"]]
    session.write_ranking(1, {**whole, "findings": [], "regressors": quiet})
    assert f"{FOLLOWS_NONE} below:" in section(client.get(first).text, "where")
    some = [{**item, "share": 0.24} for item in whole["regressors"]]
    session.write_ranking(1, {**whole, "findings": [], "regressors": some})
    where = section(client.get(first).text, "where")
    assert "24 %" in where
    assert f"{FOLLOWS_NONE} below closely:" in where


def test_a_set_that_is_opened_again_is_not_ranked_again(
    client: FlaskClient, settings: PageSettings, rankings: list[Ranking], tmp_path: Path
) -> None:
    def open_it() -> tuple[Session, str]:
        address = str(client.post("/open", data={"set": "again"}).location)
        return Sessions(settings.state)[address.split("/")[2]], address

    folder = settings.folder / "again"
    write_measurement_set(folder, measurement_set(paper_error, seed=5, runs=1, cycles=1, turns=1))
    before, address = open_it()
    before.write_ranking(1, rankings[0])
    assert open_it()[0].ranking(1) is None, "a partial ranking is not used again"
    before.write_ranking(1, rankings[1])
    again, _ = open_it()
    assert again.ranking(1) == rankings[1]
    # The test reaches the same model again by adding and removing an effect.
    client.post(f"{address}add", data={"effect": EFFECT})
    client.post(f"/s/{before.name}/2/drop", data={"effect": EFFECT})
    assert before.ranking(2) is None
    assert before.ranking(3) == rankings[1]

    # The server does not reuse the ranking if the mask or a byte of the set has changed.
    (folder / "mask.csv").write_text("capture_row,mask\n5,1\n", "utf-8")
    assert open_it()[0].ranking(1) is None
    (folder / "mask.csv").unlink()
    assert open_it()[0].ranking(1) is not None
    with (folder / "measurement.toml").open("a", encoding="utf-8") as file:
        file.write("# seen\n")
    assert open_it()[0].ranking(1) is None


def test_a_changed_set_leaves_no_result_of_its_earlier_state(
    client: FlaskClient, settings: PageSettings, rankings: list[Ranking]
) -> None:
    """After the mask of an opened set changed, the page drops the fit and the diagnosis of the
    earlier set at the same address. It also drops a diagnosis that a running job still writes."""
    folder = settings.folder / "changed"
    write_measurement_set(folder, measurement_set(paper_error, seed=6, runs=1, cycles=1, turns=1))
    address = str(client.post("/open", data={"set": "changed"}).location)
    session = Sessions(settings.state)[address.split("/")[2]]
    key = session.ranking_key(1)
    session.write_ranking(1, rankings[1])
    assert client.get(f"{address}diagnosis.json").status_code == 200
    before = client.get(f"{address}figure/residual_against.json").data
    (folder / "mask.csv").write_text("capture_row,mask\n5,1\n", "utf-8")
    assert client.get(f"{address}diagnosis.json").status_code == 404
    assert client.post(f"{address}load").status_code == 404
    assert client.get(f"{address}figure/residual_against.json").data != before
    assert not session.ranking_is_whole(1)
    session.write_ranking(1, rankings[1], key)
    assert client.get(f"{address}diagnosis.json").status_code == 404
    shutil.rmtree(folder)
    gone = client.get(address)
    assert gone.status_code == 422
    assert "measurement.toml" in gone.text


def test_the_key_of_a_ranking_changes_with_the_code_of_an_own_effect(
    settings: PageSettings, tmp_path: Path
) -> None:
    keys = []
    for name, reading in (("one", ""), ("two", ""), ("three", "# read again\n")):
        (tmp_path / name).mkdir()
        write_new_effect("own", tmp_path / name)
        with (tmp_path / name / "own.py").open("a", encoding="utf-8") as file:
            file.write(reading)
        effects = catalogue([tmp_path / name])
        keys.append(ranking_key(settings.folder / "one", "", default_model(), effects))
    assert keys[0] == keys[1] != keys[2]


def test_the_view_is_in_the_address(client: FlaskClient, opened: str) -> None:
    html = client.get(f"{opened}?unit=urad&whitened=1&against=time").get_data(as_text=True)
    assert "µrad" in html
    urls = re.findall(r'data-url="([^"]+)"', html)
    assert len(urls) >= 6
    assert all("unit=urad" in url and "against=time" in url for url in urls)
    chart = client.get(urls[0].replace("&amp;", "&")).json
    assert "standard deviations" in json.dumps(chart["layout"]["yaxis"])
