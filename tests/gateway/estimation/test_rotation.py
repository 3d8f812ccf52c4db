import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gaitway.estimation.rotation import (
    IDENTITY,
    conjugate,
    cross,
    from_gravity,
    from_matrix,
    from_rotation_vector,
    multiply,
    normalized,
    rotate,
    skew,
    tilt_rad,
    to_matrix,
    to_rotation_vector,
)

component = st.floats(-3.0, 3.0)
vectors = st.tuples(component, component, component)
quaternions = (
    st.tuples(component, component, component, component)
    .filter(lambda q: math.hypot(*q) > 0.1)
    .map(normalized)
)
scales = st.sampled_from([1e-12, 1e-8, 9e-5, 1.1e-4, 1e-2, 1.0])


def close(a, b, atol=1e-12):
    return np.allclose(a, b, rtol=0.0, atol=atol)


@given(quaternions, quaternions)
def test_the_matrix_of_a_product_is_the_product_of_the_matrices(p, q):
    assert close(to_matrix(multiply(p, q)), to_matrix(p) @ to_matrix(q))


@given(quaternions, vectors)
def test_rotating_is_multiplying_by_the_matrix(q, v):
    assert close(rotate(q, v), to_matrix(q) @ v)


@given(quaternions)
def test_the_conjugate_rotates_back(q):
    assert close(multiply(q, conjugate(q)), IDENTITY)


@given(quaternions)
def test_a_quaternion_survives_its_matrix(q):
    back = from_matrix(to_matrix(q))
    assert back[0] >= 0.0
    assert close(to_matrix(back), to_matrix(q))


@given(vectors, scales)
def test_a_rotation_vector_survives_its_quaternion(v, scale):
    rotation = np.array(v) * scale
    if np.linalg.norm(rotation) > math.pi:
        rotation *= 3.0 / np.linalg.norm(rotation)
    assert close(to_rotation_vector(from_rotation_vector(rotation)), rotation)


@given(vectors, scales)
def test_a_rotation_vector_turns_by_its_length_about_its_direction(v, scale):
    rotation = np.array(v) * scale
    q = from_rotation_vector(rotation)
    angle = np.linalg.norm(rotation)
    assert math.hypot(*q) == pytest.approx(1.0, abs=1e-14)
    assert close(rotate(q, rotation), rotation)
    assert np.trace(to_matrix(q)) == pytest.approx(1.0 + 2.0 * math.cos(angle), abs=1e-12)


@pytest.mark.parametrize("angle_rad", [1e-9, 9e-5, 1.1e-4, 1.0])
def test_half_the_sine_is_exact_on_both_sides_of_the_small_angle_branch(angle_rad):
    _, x, _, _ = from_rotation_vector((angle_rad, 0.0, 0.0))
    assert x == pytest.approx(math.sin(0.5 * angle_rad), rel=1e-15, abs=0.0)
    back, _, _ = to_rotation_vector((math.cos(0.5 * angle_rad), x, 0.0, 0.0))
    assert back == pytest.approx(angle_rad, rel=1e-14, abs=0.0)


@given(quaternions, vectors)
def test_a_small_turn_in_the_body_is_the_kinematic_equation(q, rate):
    step_s = 1e-6
    turned = multiply(q, from_rotation_vector(np.array(rate) * step_s))
    derivative = 0.5 * np.array(multiply(q, (0.0, *rate)))
    assert close((np.array(turned) - q) / step_s, derivative, atol=1e-4)


@given(vectors, vectors)
def test_skew_and_cross_are_the_cross_product(u, v):
    assert close(skew(u) @ v, np.cross(u, v))
    assert close(cross(u, v), np.cross(u, v))


@given(quaternions)
def test_gravity_gives_the_tilt_and_no_heading(q):
    felt = rotate(conjugate(q), (0.0, 0.0, 9.8))
    found = from_gravity(felt)
    assert close(rotate(found, felt), (0.0, 0.0, 9.8), atol=1e-9)
    assert tilt_rad(found) == pytest.approx(tilt_rad(q), abs=1e-7)
    w, _, _, z = found
    assert abs(z * w) < 1e-9 or tilt_rad(q) > 3.0


@pytest.mark.parametrize("felt", [(0.0, 0.0, -9.8), (1e-9, 0.0, -9.8), (0.1, -0.2, -9.8)])
def test_gravity_finds_a_device_upside_down(felt):
    found = from_gravity(felt)
    assert close(rotate(found, felt), (0.0, 0.0, math.hypot(*felt)), atol=1e-9)
    assert math.hypot(*found) == pytest.approx(1.0)
