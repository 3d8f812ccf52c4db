import itertools
import json
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gaitway.mounting import DIRECTIONS, mount, mounting_table, rotation_from_mounting
from gaitway.samples import ACCEL, ATTITUDE, GYRO, SampleBatch, frozen_rows

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
        ({"x": [1, 0, 0], "y": [0.02, 1, 0], "z": "forward"}, "two axes lie on the same line"),
        ({"x": 5, "y": "right", "z": "up"}, "mounting.x: 5 is neither a direction"),
        ({"x": [1, 0], "y": "left", "z": "up"}, "nor three components [forward, left, up]"),
        ({"x": [1, 0, "0"], "y": "left", "z": "up"}, "nor three components"),
        ({"x": [1, 0, math.nan], "y": "left", "z": "up"}, "nor three components"),
        ({"x": [True, 0, 0], "y": "left", "z": "up"}, "nor three components"),
        ({"x": [2, 0, 0], "y": "left", "z": "up"}, "length 2, not 1; as a unit vector [1, 0, 0]"),
        ({"x": [0, 0, 0], "y": "left", "z": "up"}, "length 0, not 1"),
        ({"x": [0.98, 0, 0.17], "y": "left", "z": "up"}, "x [0.98, 0, 0.17] and z up are 80 deg"),
        ({"x": [1, 0, 0], "y": [0, 1, 0], "z": [0, 0, -1]}, "z points up, not [0, 0, -1]"),
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


def random_rotation(seed):
    q, r = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))
    q = q * np.sign(np.diag(r))
    return q if np.linalg.det(q) > 0 else -q


@given(st.integers(0, 10_000))
def test_any_rotation_survives_the_configuration(seed):
    C_db = random_rotation(seed)
    table = json.loads(json.dumps(mounting_table(C_db)))
    found = rotation_from_mounting(table)
    assert found == pytest.approx(C_db, abs=2e-6)
    assert found @ found.T == pytest.approx(np.eye(3), abs=1e-14)


@given(st.integers(0, 10_000))
def test_at_any_rotation_attitude_and_vectors_turn_together(seed):
    C_db = random_rotation(seed)
    rng = np.random.default_rng(seed)
    q_nb, accel_b = rng.normal(size=4), rng.normal(size=3)
    q_nb /= np.linalg.norm(q_nb)
    turned = mount(batch(accel=[accel_b], q_nb=[q_nb]), C_db)
    assert matrix(turned.channels["q_nb"][0]) @ turned.channels["accel"][0] == pytest.approx(
        matrix(q_nb) @ accel_b, abs=1e-12
    )


def test_half_a_turn_about_any_axis_turns_attitude():
    for axis in ([1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 1, 0], [1, -2, 3]):
        u = np.array(axis) / np.linalg.norm(axis)
        C_db = 2 * np.outer(u, u) - np.eye(3)
        turned = mount(batch(accel=[[1.0, 2.0, 3.0]], q_nb=[[1.0, 0.0, 0.0, 0.0]]), C_db)
        assert matrix(turned.channels["q_nb"][0]) == pytest.approx(C_db.T, abs=1e-12)


def test_names_and_components_may_be_mixed_and_rounded_ones_are_made_a_rotation():
    C_db = rotation_from_mounting({"x": [0.98, 0.0, 0.17], "y": "left", "z": [-0.17, 0.0, 0.985]})
    assert C_db @ C_db.T == pytest.approx(np.eye(3), abs=1e-14)
    assert math.degrees(math.atan2(C_db[2, 0], C_db[0, 0])) == pytest.approx(9.8, abs=0.1)


def test_directions_as_components_are_the_same_as_by_name():
    for ways in RIGHT_HANDED:
        named = dict(zip("xyz", ways, strict=True))
        vectors = {axis: list(DIRECTIONS[way]) for axis, way in named.items()}
        assert rotation_from_mounting(vectors) == pytest.approx(
            rotation_from_mounting(named), abs=1e-15
        )


@pytest.mark.parametrize("size", [1, 2, 7])
def test_how_a_batch_is_cut_changes_no_bit_of_an_askew_mounting(size):
    rng = np.random.default_rng(1)
    q_nb = rng.normal(size=(50, 4))
    channels = {
        ACCEL.name: rng.normal(size=(50, 3)),
        GYRO.name: rng.normal(size=(50, 3)),
        ATTITUDE.name: q_nb / np.linalg.norm(q_nb, axis=1, keepdims=True),
    }
    batch = SampleBatch(np.arange(50), 0.01, 0, channels)
    C_db = rotation_from_mounting({"x": [0.98, 0, 0.199], "y": [0, 1, 0], "z": [-0.199, 0, 0.98]})
    parts = [mount(batch[start : start + size], C_db) for start in range(0, 50, size)]
    for name, whole in mount(batch, C_db).channels.items():
        assert np.array_equal(np.concatenate([part.channels[name] for part in parts]), whole)
