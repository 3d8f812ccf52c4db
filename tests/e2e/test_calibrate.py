"""A guided calibration as a person does it: a port, prompts answered, a file written."""

import json
import subprocess
import sys
import time
import tomllib

import pytest

WALK_M = 3.0
WITHIN_S = 60


def walked_m(truth):
    """Return how far the simulated person has come."""
    lines = truth.read_text().splitlines() if truth.exists() else []
    return json.loads(lines[-1])["distance_m"] if lines else 0.0


@pytest.fixture
def training(gateway, simulate, tmp_path):
    """Return a running ``gaitway calibrate`` and the truth of the walk that it records."""
    truth = tmp_path / "ankle.jsonl"
    options = ("--distance", str(WALK_M), "--rest", "8", "--walks", "1", "--truth", str(truth))
    gateway.add_device("leg", "ankle", simulate("ankle", *options))
    gateway.config.write_text("# mine\n" + "\n".join(gateway._lines) + "\n")
    command = ["calibrate", str(gateway.config), "leg", "training-walk"]
    process = subprocess.Popen(
        [sys.executable, "-m", "gaitway", *command, "--picture", str(tmp_path / "fit.png")],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    )
    yield process, truth
    process.kill()
    process.communicate()


def test_a_training_walk_is_recorded_fitted_drawn_and_written(training, gateway, tmp_path):
    process, truth = training
    process.stdin.write("\n")  # ready
    process.stdin.flush()
    until = time.monotonic() + WITHIN_S
    while walked_m(truth) < 0.8 * WALK_M:
        assert time.monotonic() < until
        time.sleep(0.1)
    time.sleep(4.0)  # the last step, and standing after it
    told, _ = process.communicate("\ny\n", timeout=WITHIN_S)
    assert process.returncode == 0, told
    assert "lever" in told
    assert (tmp_path / "fit.png").stat().st_size > 10_000
    written = gateway.config.read_text()
    (device,) = tomllib.loads(written)["devices"]
    assert len(device["params"]["lever_arm_m"]) == 3
    assert written.startswith("# mine\n")
