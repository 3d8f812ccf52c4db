import numpy as np
import pytest

from gaitway.samples import ACCEL, GYRO

GRAVITY_MPS2 = 9.80665
HEADER = ",".join(["t_s", *ACCEL.columns, *GYRO.columns])


def rocking(n=1000, rate_hz=100.0, amplitude_rad=0.3, frequency_hz=0.8, seed=0):
    """A sensor rocked about its y axis: time, specific force and angular rate that agree."""
    rng = np.random.default_rng(seed)
    t_s = np.arange(n) / rate_hz
    swing = 2 * np.pi * frequency_hz
    pitch_rad = amplitude_rad * np.sin(swing * t_s)
    accel = GRAVITY_MPS2 * np.column_stack([-np.sin(pitch_rad), 0 * t_s, np.cos(pitch_rad)])
    gyro = np.column_stack([0 * t_s, amplitude_rad * swing * np.cos(swing * t_s), 0 * t_s])
    noise = rng.normal(size=(n, 6))
    return t_s, accel + 0.3 * noise[:, :3], gyro + 0.02 * noise[:, 3:]


@pytest.fixture
def walk():
    return rocking


@pytest.fixture
def write_csv(tmp_path):
    """Returns a function that writes a walk, or lines as they are, and returns the path."""

    def write(*lines, table=None, header=HEADER, fmt="%.4f"):
        path = tmp_path / "walk.csv"
        rows = (
            [",".join(fmt % value for value in row) for row in table] if table is not None else []
        )
        path.write_text("\n".join([header, *rows, *lines]) + "\n", encoding="utf-8")
        return path

    return write


@pytest.fixture
def good_csv(write_csv, walk):
    """Returns a function that writes a good walk; its keywords are those of ``rocking``."""
    return lambda **changes: write_csv(table=np.column_stack(walk(**changes)))
