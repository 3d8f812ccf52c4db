from itertools import permutations, product

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gaitway.mounting import DIRECTIONS, rotation_from_mounting
from gaitway.simulation import rotation

VECTORS = st.tuples(*[st.floats(-1.7, 1.7)] * 3).map(lambda vec: np.array([vec]))


def cross(phi):
    x, y, z = phi[0]
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])


def exponential(phi):
    """The rotation matrix of a rotation vector, by its power series."""
    term = total = np.eye(3)
    for power in range(1, 40):
        term = term @ cross(phi) / power
        total = total + term
    return total


@given(VECTORS, VECTORS)
def test_rotates_as_the_matrix_exponential(phi, vec):
    q = rotation.from_rotation_vector(phi)
    np.testing.assert_allclose(rotation.rotate(q, vec)[0], exponential(phi) @ vec[0], atol=1e-12)


@given(VECTORS)
def test_rotation_vector_survives_the_round_trip(phi):
    q = rotation.from_rotation_vector(phi)
    np.testing.assert_allclose(rotation.to_rotation_vector(q), phi, atol=1e-9)


@given(VECTORS, VECTORS)
def test_product_turns_by_the_right_factor_first(first, second):
    q = rotation.multiply(
        rotation.from_rotation_vector(first), rotation.from_rotation_vector(second)
    )
    expected = exponential(first) @ exponential(second)
    np.testing.assert_allclose(rotation.rotate(q, np.eye(3)[0])[0], expected[:, 0], atol=1e-12)
    np.testing.assert_allclose(
        rotation.multiply(q, rotation.conjugate(q)), [[1, 0, 0, 0]], atol=1e-12
    )


def mountings():
    for axes in permutations(range(3)):
        for signs in product((1.0, -1.0), repeat=3):
            rows = np.array(
                [sign * np.eye(3)[axis] for axis, sign in zip(axes, signs, strict=True)]
            )
            if np.linalg.det(rows) > 0:
                names = [
                    name for row in rows for name, unit in DIRECTIONS.items() if tuple(row) == unit
                ]
                yield dict(zip("xyz", names, strict=True))


@pytest.mark.parametrize(
    "mounting", list(mountings()), ids=lambda mounting: "-".join(mounting.values())
)
def test_quaternion_of_a_matrix_rotates_like_the_matrix(mounting):
    C_db = rotation_from_mounting(mounting)
    q_db = rotation.from_matrix(C_db)
    assert q_db[0, 0] >= 0.0
    turned = rotation.rotate(np.tile(q_db, (3, 1)), np.eye(3)).T
    np.testing.assert_allclose(turned, C_db, atol=1e-12)


def test_positive_pitch_leans_forward_and_positive_roll_to_the_right():
    up = np.array([0.0, 0.0, 1.0])
    leaned = rotation.rotate(rotation.from_angles(np.array([[0.0, 0.1, 0.0], [0.0, 0.0, 0.1]])), up)
    assert leaned[0, 0] > 0.09
    assert leaned[1, 1] < -0.09


def test_positive_yaw_turns_left():
    ahead = rotation.rotate(rotation.from_angles(np.array([[0.1, 0.3, 0.2]])), np.eye(3)[0])
    assert ahead[0, 1] > 0.09


@given(VECTORS, VECTORS)
def test_angular_rate_is_what_turns_one_attitude_into_the_next(angles, rates):
    step_s = 1e-6
    before = rotation.from_angles(angles - rates * step_s)
    after = rotation.from_angles(angles + rates * step_s)
    turn = rotation.to_rotation_vector(rotation.multiply(rotation.conjugate(before), after))
    np.testing.assert_allclose(
        rotation.rate_from_angles(angles, rates), turn / (2 * step_s), atol=1e-6
    )


@given(VECTORS, VECTORS)
def test_mean_of_turning_is_the_integral_over_the_turn(phi, vec):
    nodes, weights = np.polynomial.legendre.leggauss(8)
    parts = [exponential(phi * u) @ vec[0] for u in 0.5 * (nodes + 1.0)]
    mean = 0.5 * weights @ np.array(parts)
    np.testing.assert_allclose(rotation.mean_of_turning(phi, vec)[0], mean, atol=1e-9)


@given(VECTORS, VECTORS, st.floats(0.0, 1.0))
def test_vector_of_mean_undoes_mean_of_turning(phi, vec, shrink):
    phi = phi * shrink**6
    mean = rotation.mean_of_turning(phi, vec)
    np.testing.assert_allclose(rotation.vector_of_mean(phi, mean), vec, atol=1e-9)
