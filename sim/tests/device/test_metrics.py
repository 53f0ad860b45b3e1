"""Tests that Prometheus' own parser reads the metrics of the daemon."""

from __future__ import annotations

import urllib.error
import urllib.request
from pathlib import Path

import pytest
from prometheus_client.parser import text_string_to_metric_families
from sim.tests.device.daemon_process import Replay, announcement, daemon, until

from arctrue.device.announcement import Announcement
from arctrue.device.connection import ask
from arctrue.device.console import ConsoleError
from arctrue.device.daemon.metrics import metrics_text
from arctrue.device.daemon.state import DaemonState


def fetched(found: Announcement, token: str, path: str = "/metrics") -> str:
    address = f"http://{found.address}{path}"
    request = urllib.request.Request(address, headers={"Authorization": f"Bearer {token}"})
    with urllib.request.urlopen(request, timeout=20.0) as answer:
        assert answer.headers["Content-Type"].startswith("text/plain; version=0.0.4")
        return str(answer.read().decode())


def samples(text: str) -> dict[tuple[str, str], float]:
    """Return the values of the metrics, keyed by name and by the label ``order`` or ``alarm``."""
    return {
        (s.name, s.labels.get("order", s.labels.get("alarm", ""))): s.value
        for family in text_string_to_metric_families(text)
        for s in family.samples
    }


def test_the_latest_turn_and_the_counters_are_metrics(replay: Replay, tmp_path: Path) -> None:
    harmonics = [[1, 150.0, 0.4, 0.01, 1], [2, 6.25, -2.0, 0.02, 0]]
    with daemon(replay.port, tmp_path, "--no-alarm-capture"):
        found = announcement(replay.port)
        replay.send(b"{spoiled\n")
        replay.turn(7, harmonics=harmonics, alarms=["noise"], noise_arcsec=0.125)
        until(lambda: ask(found, "status")["turns"] == 1)
        ask(found, "life", alarms={"hysteresis.reversal_error": "ALARM: it passes its limit."})
        for wrong in ({"": "no name"}, {"name": 1}, ["name"], {str(n): "" for n in range(101)}):
            with pytest.raises(ConsoleError, match="are not accepted"):
                ask(found, "life", alarms=wrong)
        read = samples(fetched(found, found.token))
        assert read["arctrue_turns_total", ""] == 1.0
        assert read["arctrue_damaged_lines_total", ""] == 1.0
        assert read["arctrue_connected", ""] == read["arctrue_recording", ""] == 1.0
        assert read["arctrue_order_amplitude_arcsec", "2"] == 6.25
        assert read["arctrue_order_phase_radians", "2"] == -2.0
        assert read["arctrue_order_u_arcsec", "1"] == 0.01
        assert read["arctrue_order_applied", "1"] == 1.0
        assert read["arctrue_alarm", "noise"] == 1.0
        assert read["arctrue_machine_alarm", "hysteresis.reversal_error"] == 1.0
        assert read["arctrue_noise_arcsec", ""] == 0.125
        assert read["arctrue_die_temperature_celsius", ""] == 40.5
        assert ("arctrue_table_temperature_celsius", "") not in read
        for token, path, code in (("", "/metrics", 401), (found.token, "/", 404)):
            with pytest.raises(urllib.error.HTTPError) as refused:
                fetched(found, token, path)
            assert refused.value.code == code


def test_a_name_with_quotes_stays_one_label() -> None:
    state = DaemonState('/dev/"odd"\\name\n', alarms=['x"} 1'])
    families = {
        family.name: family for family in text_string_to_metric_families(metrics_text(state))
    }
    assert families["arctrue_turns"].samples[0].labels == {"port": state.port}
    assert families["arctrue_alarm"].samples[0].labels["alarm"] == 'x"} 1'
