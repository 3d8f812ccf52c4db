"""The unit files say what the documentation promises, and systemd understands them."""

import shutil
import subprocess
from pathlib import Path

import pytest

SYSTEMD = Path(__file__).parents[2] / "systemd"
UNIT = SYSTEMD / "gaitway.service"
needs_systemd = pytest.mark.skipif(
    shutil.which("systemd-analyze") is None, reason="systemd-analyze is not on this machine"
)


def test_the_unit_is_notify_with_a_watchdog_and_restarts_for_ever():
    lines = UNIT.read_text().splitlines()
    for line in ("Type=notify", "Restart=always", "StartLimitIntervalSec=0"):
        assert line in lines
    assert any(line.startswith("WatchdogSec=") for line in lines)


@needs_systemd
def test_systemd_finds_nothing_to_say_about_the_unit(tmp_path):
    unit = tmp_path / "gaitway.service"
    text = UNIT.read_text().replace("/opt/gaitway/bin/gaitway", "/bin/true")
    unit.write_text(text)
    found = subprocess.run(
        ["systemd-analyze", "verify", "--man=no", str(unit)],
        capture_output=True,
        text=True,
        check=False,
    )
    assert [line for line in found.stderr.splitlines() if "gaitway" in line] == []
    assert found.returncode == 0


@needs_systemd
def test_the_unit_is_hardened():
    subprocess.run(
        ["systemd-analyze", "security", "--offline=true", "--threshold=20", str(UNIT)],
        check=True,
        capture_output=True,
    )
