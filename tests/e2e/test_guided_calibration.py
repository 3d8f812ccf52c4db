"""A calibration led live, as a person would: prompts read, Enter pressed, a port listened to."""

import subprocess
import sys
import threading
import tomllib

import numpy as np
import pytest

from gaitway.contracts import SimulatedWalk
from gaitway.samples import ACCEL, GYRO, frozen_rows
from gaitway.testing.simulated_device import SimulatedDevice
from gaitway.timebase import HostClock
from gaitway_drivers import gaitway_codecs

RATE_HZ = 100.0
GAIN = 1.03


def turns(count=12, still_s=2.0, turn_s=1.5):
    """Return a crutch that is tipped by 90 degrees to and fro, its gyroscope telling too little."""
    t_s = np.arange(0.0, count * (still_s + turn_s), 1.0 / RATE_HZ)
    number, into_s = np.divmod(t_s, still_s + turn_s)
    share = np.clip((into_s - still_s) / turn_s, 0.0, 1.0)
    done = share**2 * (3.0 - 2.0 * share)
    angle = 0.5 * np.pi * np.where(number % 2 == 0, done, 1.0 - done)
    gyro = np.zeros((len(t_s), 3))
    gyro[:, 1] = -np.gradient(angle, t_s) / GAIN  # y of the IMU points right, that of d left
    none = np.zeros(0)
    return SimulatedWalk(
        rate_hz=RATE_HZ,
        channels={
            ACCEL.name: frozen_rows(np.tile([9.80665, 0.0, 0.0], (len(t_s), 1)), 3),
            GYRO.name: frozen_rows(gyro + 0.004, 3),
        },
        stride_start_s=none,
        stride_end_s=none,
        stride_length_m=none,
        pos_n=np.zeros((len(t_s), 3)),
        q_nb=np.zeros((len(t_s), 4)),
    )


@pytest.fixture
def crutch(tmp_path):
    """A crutch on a port, being tipped; the port and what it has played."""
    (xbus,) = gaitway_codecs()
    link = tmp_path / "ports" / "crutch"
    with SimulatedDevice(link, xbus.make_peripheral(RATE_HZ), HostClock()) as device:
        thread = threading.Thread(target=device.play, args=(turns(),))
        thread.start()
        device.link = link
        yield device
        device.stop()
        thread.join()


class Guide:
    """The running command: reads up to a prompt, presses keys."""

    def __init__(self, config):
        self.process = subprocess.Popen(
            [sys.executable, "-m", "gaitway", "calibrate", str(config), "crutch", "gyro-scale",
             "--picture", str(config.parent / "fit.png")],
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, bufsize=0,
        )  # fmt: skip
        self.said = ""

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.process.kill()
        self.process.wait()
        self.process.stdin.close()
        self.process.stdout.close()

    def until(self, prompt):
        since = len(self.said)
        while prompt not in self.said[since:]:
            letter = self.process.stdout.read(1).decode()
            assert letter, self.said
            self.said += letter

    def answer(self, text=""):
        self.process.stdin.write(f"{text}\n".encode())


def play_to(device, period, into_s):
    """Wait until the device is so far into one of its turns and rests."""
    while device.elapsed_s < period * 3.5 + into_s:
        threading.Event().wait(0.02)


def follow(guide, crutch):
    """Record two turns, each from one rest to the next."""
    guide.until("press Enter when ready")
    for again in ("y", "n"):
        period = int(crutch.elapsed_s // 3.5) + 1
        play_to(crutch, period, 0.3)
        guide.answer()
        guide.until("press Enter when done")
        play_to(crutch, period + 1, 1.2)
        guide.answer()
        guide.until("once more?")
        guide.answer(again)
        if again == "y":
            guide.until("press Enter when ready")


@pytest.mark.timeout(90)
def test_a_guided_calibration_writes_what_it_found_into_the_configuration(tmp_path, crutch):
    config = tmp_path / "gateway.toml"
    config.write_text(
        'site = "test"\n'
        "[[devices]]\n"
        'id = "crutch"\n'
        'type = "crutch-tip"\n'
        f'driver = {{ transport = "serial", port = "{crutch.link}", codec = "xbus" }}\n'
    )
    with Guide(config) as guide:
        follow(guide, crutch)
        guide.until("[y/N]")
        guide.answer("y")
        assert guide.process.wait(20) == 0
    params = tomllib.loads(config.read_text())["devices"][0]["params"]
    assert params["gyro_gain"] == pytest.approx(GAIN, abs=0.003)
    assert (tmp_path / "fit.png").exists()
