"""Tests that a campaign writes the same lines of results for any number of shards, and that a stop
or a killed worker loses no result."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from arctrue.studies.campaign import (
    Campaign,
    CampaignError,
    Sources,
    Speed,
    StoreError,
    read_results,
    task_key,
)
from arctrue.studies.campaign.code_state import commit, import_closure
from arctrue.studies.campaign.store import Store, merge
from arctrue.studies.campaign.task import canonical

WORK = "sim.tests.studies.campaign.small_work"
ROOT = Path(__file__).resolve().parents[4]
WAIT_S = 120


def campaign(folder: Path, number: int = 12, work: str = "square", **more: Any) -> Campaign:
    tasks = [{"number": item, **more} for item in range(number)]
    return Campaign(f"{WORK}:{work}", tasks, folder, {"kind": "test"})


def wait_for(condition: Callable[[], bool], process: subprocess.Popen[Any] | None = None) -> None:
    end = time.monotonic() + WAIT_S
    while not condition():
        assert process is None or process.poll() is None
        assert time.monotonic() < end, f"no result for {WAIT_S} s"
        time.sleep(0.02)


def squares(folder: Path) -> list[int]:
    return sorted(item.result["square"] for item in read_results([folder]))


def test_key_is_the_content_whatever_the_order_of_its_names() -> None:
    assert task_key({"a": 1, "b": [2, 3]}) == task_key({"b": [2, 3], "a": 1})
    assert task_key({"a": 1}) != task_key({"a": 2})
    with pytest.raises(ValueError, match="JSON compliant"):
        task_key({"a": float("nan")})


def test_shards_and_workers_do_not_change_a_byte(tmp_path: Path) -> None:
    campaign(tmp_path / "one").run(workers=1)
    for place in (1, 2, 3):
        campaign(tmp_path / "three").run(workers=2, shard=(place, 3))
    texts = []
    for name in ("one", "three"):
        assert merge([tmp_path / name], tmp_path / f"merged-{name}") == 12
        texts.append((tmp_path / f"merged-{name}" / "results.jsonl").read_bytes())
    assert texts[0] == texts[1]
    assert squares(tmp_path / "three") == [n**2 for n in range(12)]


def test_shards_in_folders_of_their_own_are_merged(tmp_path: Path) -> None:
    for place in (1, 2):
        campaign(tmp_path / str(place)).run(workers=1, shard=(place, 2))
    assert merge([tmp_path / "1", tmp_path / "2"], tmp_path / "whole") == 12


def test_what_is_done_is_not_done_again_and_a_cut_line_is(tmp_path: Path) -> None:
    place = tmp_path / "runs"
    place.mkdir()
    whole = campaign(tmp_path / "campaign", 4, "noted", place=str(place))
    whole.run(workers=1)
    lines = tmp_path / "campaign" / "results.jsonl"
    lines.write_text(lines.read_text()[:-9])
    whole.run(workers=1)
    whole.run(workers=1)
    assert squares(tmp_path / "campaign") == [0, 1, 4, 9]
    # The folder has four files from the first run, and one file from the task whose line was cut.
    assert len(list(place.iterdir())) == 5


def test_another_state_of_the_code_is_refused(tmp_path: Path, monkeypatch) -> None:  # type: ignore[no-untyped-def]
    campaign(tmp_path).run(workers=1)
    monkeypatch.setattr(Sources, "state", lambda sources: {"arctrue": "another"})
    with pytest.raises(StoreError, match="two states are not mixed"):
        campaign(tmp_path).run(workers=1)


def test_shards_of_two_states_are_not_merged(tmp_path: Path) -> None:
    for name in "ab":
        with Store(tmp_path / name, {"code": {"arctrue": name}}) as store:
            store.add({"number": 1}, {"square": 1}, 0.1)
    with pytest.raises(StoreError, match="different campaigns or states of code"):
        merge([tmp_path / "a", tmp_path / "b"], tmp_path / "whole")


def test_seconds_stand_apart_from_results(tmp_path: Path) -> None:
    campaign(tmp_path, 3).run(workers=1)
    results = [json.loads(line) for line in (tmp_path / "results.jsonl").open(encoding="utf-8")]
    timings = [json.loads(line) for line in (tmp_path / "timings.jsonl").open(encoding="utf-8")]
    assert {tuple(sorted(item)) for item in results} == {("key", "result", "task")}
    assert {item["key"] for item in timings} == {item["key"] for item in results}


def test_other_tasks_do_not_go_into_the_same_folder(tmp_path: Path) -> None:
    campaign(tmp_path, 3).run(workers=1)
    with pytest.raises(StoreError, match="tasks"):
        campaign(tmp_path, 4).run(workers=1)


def test_worker_with_other_code_is_refused_and_what_was_done_is_kept(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    campaign(tmp_path, 3).run(workers=1, shard=(1, 3))
    header = json.loads((tmp_path / "campaign.json").read_text(encoding="utf-8"))
    stale = {**header["code"], "arctrue": "0123456789abcdef"}
    header["code"] = stale
    (tmp_path / "campaign.json").write_text(json.dumps(header), encoding="utf-8")
    # The parent process read the source before the edit; a worker that starts now reads the edited
    # source.
    monkeypatch.setattr(Sources, "state", lambda sources: stale)
    with pytest.raises(CampaignError, match="results of two states are not mixed; results so far"):
        campaign(tmp_path, 3).run(workers=1)
    assert squares(tmp_path) == [0]


def write_package(place: Path, files: dict[str, str]) -> Path:
    package = place / "package"
    for name, text in {"__init__.py": "", **files}.items():
        (package / name).parent.mkdir(parents=True, exist_ok=True)
        (package / name).write_text(text, encoding="utf-8")
    return package


def test_state_of_the_whole_package_follows_every_file(tmp_path: Path) -> None:
    package = write_package(tmp_path, {"module.py": "a = 1\n"})
    before = Sources().state(package)
    (package / "module.py").write_text("a = 2\n", encoding="utf-8")
    assert Sources().state(package) != before


def test_state_of_modules_follows_what_they_import_and_nothing_else(tmp_path: Path) -> None:
    package = write_package(
        tmp_path,
        {
            "rival/__init__.py": "",
            "rival/rule.py": "from package.shared import table\n",
            "shared/__init__.py": "import package.units\n",
            "shared/table.py": "def late():\n    from package.late import x\n",
            "units.py": "",
            "late.py": "import math, package.rival.rule\n",
            "diagnosis.py": "import package.units\n",
        },
    )
    sources = Sources(("package.rival.rule",))
    found = [file.relative_to(package) for file in import_closure(sources.modules, package)]
    everything = [file.relative_to(package) for file in sorted(package.rglob("*.py"))]
    assert found == [file for file in everything if file.name != "diagnosis.py"]
    for file in everything:
        before = sources.state(package)
        with (package / file).open("a", encoding="utf-8") as text:
            text.write("a = 1\n")
        assert (sources.state(package) == before) == (file.name == "diagnosis.py"), file
    with pytest.raises(ModuleNotFoundError):
        import_closure(["package.gone"], package)


def test_libraries_are_stated(tmp_path: Path) -> None:
    package = write_package(tmp_path, {})
    assert "numpy" in Sources().state(package)
    assert set(Sources(libraries=("click",)).state(package)) - set(Sources().state(package)) == {
        "click"
    }


def test_another_commit_of_the_same_source_goes_on(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for number, name in enumerate(("1234567890", "abcdef0123"), start=1):
        monkeypatch.setattr("arctrue.studies.campaign.campaign.commit", lambda name=name: name)
        campaign(tmp_path / "one").run(workers=1, shard=(number, 2))
        campaign(tmp_path / name).run(workers=1, shard=(number, 2))
    assert len(squares(tmp_path / "one")) == 12
    assert merge([tmp_path / "1234567890", tmp_path / "abcdef0123"], tmp_path / "whole") == 12
    header = json.loads((tmp_path / "one" / "campaign.json").read_text(encoding="utf-8"))
    assert header["commit"] == "1234567890"


def test_commit_tells_a_changed_tree_and_none_without_git(tmp_path: Path) -> None:
    package = write_package(tmp_path, {})

    def git(*words: str) -> None:
        who = ("-c", "user.name=a", "-c", "user.email=a@b.c")
        command = ["git", "-C", str(tmp_path), *who, *words]
        subprocess.run(command, check=True, capture_output=True, timeout=60)

    git("init")
    assert commit(package) is None
    git("add", ".")
    git("commit", "-m", "first")
    name = commit(package)
    assert name is not None
    assert len(name) == 10
    (package / "__init__.py").write_text("a = 1\n", encoding="utf-8")
    assert commit(package) == f"{name}-dirty"


def test_contradicting_results_are_refused(tmp_path: Path) -> None:
    with Store(tmp_path, {"kind": "test"}) as store:
        store.add({"number": 1}, {"square": 1}, 0.1)
        store.add({"number": 1}, {"square": 2}, 0.1)
    assert squares(tmp_path) == [1]
    lie = {"key": task_key({"number": 1}), "task": {"number": 1}, "result": {"square": 3}}
    (tmp_path / "results-2-of-2.jsonl").write_text(canonical(lie) + "\n")
    with pytest.raises(StoreError, match="a second, different result"):
        read_results([tmp_path])


def test_a_killed_worker_loses_nothing(tmp_path: Path) -> None:
    reported: list[Speed] = []
    work = campaign(tmp_path / "c", 12, "killed_once", mark=str(tmp_path / "mark"))
    assert work.run(workers=2, report_speed=reported.append) == 12
    assert (tmp_path / "mark").exists()
    assert squares(tmp_path / "c") == [n**2 for n in range(12)]
    assert [item.done for item in reported] == sorted(item.done for item in reported)
    assert reported[-1].seconds_left == 0.0


def test_a_task_that_kills_every_worker_ends_the_campaign(tmp_path: Path) -> None:
    with pytest.raises(CampaignError, match="were killed 3 times"):
        campaign(tmp_path, 2, "always_killed").run(workers=1)


@pytest.mark.parametrize("asked", [signal.SIGINT, signal.SIGTERM])
def test_a_stop_loses_nothing_and_the_same_command_goes_on(
    tmp_path: Path, asked: signal.Signals
) -> None:
    program = (
        "from pathlib import Path\n"
        "from arctrue.studies.campaign import Interrupted\n"
        "from sim.tests.studies.campaign.test_campaign import campaign\n"
        "if __name__ == '__main__':\n"
        f"    work = campaign(Path({str(tmp_path / 'c')!r}), 400, 'slow_square')\n"
        "    try:\n"
        "        print('done', work.run(workers=2))\n"
        "    except Interrupted as stop:\n"
        "        print(stop)\n"
    )
    script = tmp_path / "stopped.py"
    script.write_text(program)
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join([str(ROOT), str(ROOT / "sim")])}
    process = subprocess.Popen(
        [sys.executable, str(script)],
        stdout=subprocess.PIPE,
        text=True,
        env=environment,
        start_new_session=True,
    )
    lines = tmp_path / "c" / "results.jsonl"
    wait_for(lambda: lines.exists() and lines.stat().st_size > 0, process)
    if asked == signal.SIGINT:
        # In a terminal Ctrl+C sends the signal to the workers as well.
        os.killpg(process.pid, asked)
    else:
        process.send_signal(asked)
    said, _ = process.communicate(timeout=60)
    done = int(said.split()[0])
    assert said == f"{done} of 400 are done; the same command continues from there\n"
    assert 0 < done < 400
    assert len(squares(tmp_path / "c")) == done
    assert len({json.loads(line)["key"] for line in lines.read_text().splitlines()}) == done


@pytest.mark.large
def test_workers_end_with_their_parent(tmp_path: Path) -> None:
    place = tmp_path / "runs"
    place.mkdir()
    script = tmp_path / "killed.py"
    script.write_text(
        "from pathlib import Path\n"
        "from sim.tests.studies.campaign.test_campaign import campaign\n"
        "if __name__ == '__main__':\n"
        f"    campaign(Path({str(tmp_path / 'c')!r}), 400, 'noted', "
        f"place={str(place)!r}).run(workers=1)\n"
    )
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join([str(ROOT), str(ROOT / "sim")])}
    process = subprocess.Popen([sys.executable, str(script)], env=environment)
    wait_for(lambda: any(place.iterdir()), process)
    worker = int(next(place.iterdir()).name.split("-")[1])
    process.kill()
    process.wait(timeout=WAIT_S)
    for _ in range(300):
        if not Path(f"/proc/{worker}").exists():
            return
        time.sleep(0.1)
    pytest.fail(f"worker {worker} goes on without its parent")


def test_a_shard_that_is_none_is_refused(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="found 4/3"):
        campaign(tmp_path).run(shard=(4, 3))


@pytest.mark.large
def test_a_dask_worker_killed_in_the_middle_loses_nothing_and_nothing_is_twice(
    tmp_path: Path,
) -> None:
    distributed = pytest.importorskip("distributed")
    place = tmp_path / "runs"
    place.mkdir()
    whole = campaign(tmp_path / "c", 24, "noted", place=str(place))
    with distributed.LocalCluster(
        n_workers=2, threads_per_worker=1, dashboard_address=None, protocol="tcp"
    ) as cluster:

        def kill_one() -> None:
            wait_for(lambda: len(list(place.iterdir())) >= 4)
            os.kill(cluster.workers[0].pid, signal.SIGKILL)

        killer = threading.Thread(target=kill_one)
        killer.start()
        assert whole.run(scheduler=cluster.scheduler_address) == 24
        killer.join(WAIT_S)
    lines = (tmp_path / "c" / "results.jsonl").read_text().splitlines()
    assert len(lines) == len({json.loads(line)["key"] for line in lines}) == 24
    assert squares(tmp_path / "c") == [n**2 for n in range(24)]
    campaign(tmp_path / "pool", 24, "noted", place=str(place)).run(workers=2)
    for name in ("c", "pool"):
        merge([tmp_path / name], tmp_path / f"merged-{name}")
    merged = [(tmp_path / f"merged-{name}/results.jsonl").read_bytes() for name in ("c", "pool")]
    assert merged[0] == merged[1]


def test_a_scheduler_that_does_not_answer_is_an_error_for_people(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    pytest.importorskip("distributed")
    monkeypatch.setattr("arctrue.studies.campaign.dask_cluster.CONNECT_S", 0.5)
    with pytest.raises(CampaignError, match="no Dask scheduler answers at"):
        campaign(tmp_path).run(scheduler="tcp://127.0.0.1:9")
