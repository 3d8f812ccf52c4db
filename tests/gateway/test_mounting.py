import itertools

import numpy as np
import pytest

from gaitway.mounting import DIRECTIONS, mount, rotation_from_mounting
from gaitway.samples import SampleBatch, frozen_rows

RIGHT_HANDED = []
for ways in itertools.product(DIRECTIONS, repeat=3):
    try:
        rotation_from_mounting(dict(zip("xyz", ways, strict=True)))
    except ValueError:
        continue
    RIGHT_HANDED.append(ways)


def matrix(q):
    w, x, y, z = q
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


def batch(**channels):
    rows = {name: frozen_rows(value, np.shape(value)[1]) for name, value in channels.items()}
    n = len(next(iter(rows.values())))
    return SampleBatch(np.arange(n, dtype=np.int64), 0.01, 0, rows)


def test_there_are_twenty_four_ways_to_mount_a_sensor():
    assert len(RIGHT_HANDED) == 24


def test_the_cane_mounting_takes_the_shaft_axis_to_up():
    C_db = rotation_from_mounting({"x": "up", "y": "right", "z": "forward"})
    turned = mount(batch(accel=[[9.8, 1.0, 2.0]], gyro=[[0.1, 0.2, 0.3]]), C_db)
    assert turned.channels["accel"].tolist() == [[2.0, -1.0, 9.8]]
    assert turned.channels["gyro"].tolist() == [[0.3, -0.2, 0.1]]


@pytest.mark.parametrize("ways", RIGHT_HANDED, ids="-".join)
def test_attitude_and_vectors_turn_together(ways):
    C_db = rotation_from_mounting(dict(zip("xyz", ways, strict=True)))
    q_nb = np.array([0.5, -0.1, 0.7, 0.2]) / np.linalg.norm([0.5, -0.1, 0.7, 0.2])
    accel_b = np.array([1.0, 2.0, 3.0])
    turned = mount(batch(accel=[accel_b], q_nb=[q_nb]), C_db)
    expected = matrix(q_nb) @ accel_b
    actual = matrix(turned.channels["q_nb"][0]) @ turned.channels["accel"][0]
    assert actual == pytest.approx(expected)


@pytest.mark.parametrize(
    ("mounting", "message"),
    [
        ({"x": "up", "y": "right"}, "missing ['z']"),
        ({"x": "up", "y": "right", "z": "fwd"}, "mounting.z: 'fwd' is no direction"),
        ({"x": "up", "y": "left", "z": "forward"}, "z points backward, not forward"),
        ({"x": "up", "y": "down", "z": "forward"}, "two axes lie on the same line"),
    ],
)
def test_an_impossible_mounting_is_refused_with_the_remedy(mounting, message):
    with pytest.raises(ValueError, match=r".") as caught:
        rotation_from_mounting(mounting)
    assert message in str(caught.value)


def test_mounted_samples_are_read_only():
    C_db = rotation_from_mounting({"x": "forward", "y": "left", "z": "up"})
    turned = mount(batch(accel=[[0.0, 0.0, 9.8]]), C_db)
    with pytest.raises(ValueError, match="read-only"):
        turned.channels["accel"][0, 0] = 1.0
