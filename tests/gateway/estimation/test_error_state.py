import numpy as np
import pytest

from gaitway.estimation import (
    ACCEL_BIAS,
    ATT,
    GYRO_BIAS,
    POS,
    VEL,
    ErrorStateFilter,
    ImuNoise,
    Measurement,
    _kernels_twin,
    gravity,
    kernels,
    pivot_velocity,
    zero_rate,
    zero_velocity,
)
from gaitway.estimation.rotation import (
    conjugate,
    from_rotation_vector,
    multiply,
    rotate,
    to_rotation_vector,
)


@pytest.fixture(autouse=True, params=["as installed", "twin"])
def _kernels_in_use(request, monkeypatch):
    """Hold every promise with the compiled kernels and with their twin."""
    if request.param == "twin":
        for name in ("predict", "run", "innovation", "correct"):
            monkeypatch.setattr(kernels, name, getattr(_kernels_twin, name))


ACCEL_D = (1.5, -2.0, 8.7)
GYRO_D = (0.6, -1.1, 0.4)
LEVER_D = (0.1, -0.05, -0.6)


def moving(states):
    """Return a filter in the middle of some movement."""
    kf = ErrorStateFilter(states=states)
    kf.pos_n[:] = (0.3, -0.2, 0.1)
    kf.vel_n[:] = (0.8, 0.2, -0.3)
    kf.q_nd = from_rotation_vector((0.3, -0.4, 1.2))
    kf.gyro_bias_d[:] = (0.02, -0.01, 0.03)
    kf.accel_bias_d[:] = (0.05, 0.1, -0.08)
    return kf


def put(kf, error):
    """Return a filter whose nominal state is that of kf with an error added to it."""
    other = ErrorStateFilter(states=kf.states)
    other.nominal[:] = kf.nominal
    other.pos_n[:] += error[POS]
    other.vel_n[:] += error[VEL]
    other.q_nd = multiply(from_rotation_vector(error[ATT]), kf.q_nd)
    if kf.states == 15:
        other.gyro_bias_d[:] += error[GYRO_BIAS]
        other.accel_bias_d[:] += error[ACCEL_BIAS]
    return other


def error_between(truth, kf):
    theta = to_rotation_vector(multiply(truth.q_nd, conjugate(kf.q_nd)))
    error = [truth.pos_n - kf.pos_n, truth.vel_n - kf.vel_n, theta]
    if kf.states == 15:
        error += [truth.gyro_bias_d - kf.gyro_bias_d, truth.accel_bias_d - kf.accel_bias_d]
    return np.concatenate(error)


@pytest.mark.parametrize("states", [9, 15])
def test_the_transition_is_the_derivative_of_the_navigation(states):
    dt_s, tiny = 1e-3, 1e-5
    no_noise = ImuNoise(0.0, 0.0)
    found = np.empty((states, states))
    for column, unit in enumerate(np.eye(states)):
        kf = moving(states)
        truth = put(kf, tiny * unit)
        for each in (kf, truth):
            each.predict(ACCEL_D, GYRO_D, dt_s, no_noise)
        found[:, column] = error_between(truth, kf) / tiny
    # First order in dt: what is neglected is of the size of dt^2 times the specific force.
    assert transition(states, dt_s) == pytest.approx(found, abs=1e-5)


def transition(states, dt_s):
    """Return F as the covariance shows it: of an error in one state alone F P F^T is its column."""
    F = np.empty((states, states))
    for column in range(states):
        kf = moving(states)
        kf.covariance[column, column] = 1.0
        kf.predict(ACCEL_D, GYRO_D, dt_s, ImuNoise(0.0, 0.0))
        F[:, column] = kf.covariance[:, column] / np.sqrt(kf.covariance[column, column])
    return F


@pytest.mark.parametrize("states", [9, 15])
@pytest.mark.parametrize(
    "measure",
    [
        lambda kf: zero_velocity(kf, 0.01),
        lambda kf: pivot_velocity(kf, GYRO_D, LEVER_D, 0.01),
        lambda kf: gravity(kf, ACCEL_D, 0.1),
    ],
)
def test_h_is_the_derivative_of_the_residual(measure, states):
    """The residual falls by H x when the error x is put into the nominal state."""
    kf, tiny = moving(states), 1e-6
    z, H, _ = measure(kf)
    found = np.column_stack(
        [(z - measure(put(kf, tiny * unit)).z) / tiny for unit in np.eye(states)]
    )
    assert pytest.approx(found, abs=1e-4) == H


def test_h_of_zero_rate_is_the_derivative_of_the_residual():
    kf, tiny = moving(15), 1e-6
    z, H, _ = zero_rate(kf, GYRO_D, 0.01)
    found = np.column_stack(
        [(z - zero_rate(put(kf, tiny * unit), GYRO_D, 0.01).z) / tiny for unit in np.eye(15)]
    )
    assert pytest.approx(found, abs=1e-8) == H


def test_residuals_are_zero_where_the_measurement_holds():
    kf = moving(15)
    rate_d = np.subtract(GYRO_D, kf.gyro_bias_d)
    kf.vel_n[:] = rotate(kf.q_nd, -np.cross(rate_d, LEVER_D))
    up_d = rotate(conjugate(kf.q_nd), (0.0, 0.0, kf.gravity_mps2))
    assert pivot_velocity(kf, GYRO_D, LEVER_D, 0.01).z == pytest.approx(np.zeros(3), abs=1e-12)
    assert gravity(kf, up_d + kf.accel_bias_d, 0.1).z == pytest.approx(np.zeros(3), abs=1e-12)
    assert zero_rate(kf, kf.gyro_bias_d, 0.1).z == pytest.approx(np.zeros(3), abs=1e-12)


def test_constant_force_and_rate_follow_the_closed_form():
    """A quarter turn about the vertical with a force that turns along: v is its exact integral."""
    kf, steps, rate = ErrorStateFilter(), 1000, np.pi / 2
    no_noise = ImuNoise(0.0, 0.0)
    for _ in range(steps):
        kf.predict((1.0, 0.0, kf.gravity_mps2), (0.0, 0.0, rate), 1.0 / steps, no_noise)
    assert kf.vel_n == pytest.approx([1.0 / rate, 1.0 / rate, 0.0], abs=1e-6)
    assert rotate(kf.q_nd, (1.0, 0.0, 0.0)) == pytest.approx((0.0, 1.0, 0.0), abs=1e-12)


def test_rest_gives_no_distance():
    kf = ErrorStateFilter()
    noise = ImuNoise(0.01, 1e-3)
    for _ in range(1000):
        kf.predict((0.0, 0.0, kf.gravity_mps2), (0.0, 0.0, 0.0), 0.01, noise)
    assert not kf.nominal[:6].any()


@pytest.mark.parametrize("states", [9, 15])
def test_a_measurement_sets_right_what_it_sees(states):
    kf = moving(states)
    kf.set_block(VEL, 1.0)
    kf.correct(zero_velocity(kf, 1e-6))
    assert kf.vel_n == pytest.approx(np.zeros(3), abs=1e-9)


@pytest.mark.parametrize("rows", [1, 3, 6])
def test_correcting_is_the_textbook_update(rows):
    rng = np.random.default_rng(5)
    kf = moving(15)
    root = 0.01 * rng.standard_normal((15, 15))
    kf.covariance[:] = P = root @ root.T
    H, z = rng.standard_normal((rows, 15)), 0.01 * rng.standard_normal(rows)
    R = 1e-3 * np.diag(np.arange(1.0, rows + 1.0))
    before = put(kf, np.zeros(15))
    seen = kf.correct(Measurement(z, H, R))
    S = H @ P @ H.T + R
    K = P @ H.T @ np.linalg.inv(S)
    joseph = (np.eye(15) - K @ H) @ P @ (np.eye(15) - K @ H).T + K @ R @ K.T
    assert kf.covariance == pytest.approx(joseph, abs=1e-15)
    assert error_between(kf, before) == pytest.approx(K @ z, abs=1e-12)
    assert seen.nis == pytest.approx(z @ np.linalg.solve(S, z))
    assert seen.standardised @ seen.standardised == pytest.approx(seen.nis)


def test_an_innovation_can_be_looked_at_without_being_taken_in():
    kf = moving(15)
    kf.set_block(VEL, 0.1)
    nominal, covariance = kf.nominal.copy(), kf.covariance.copy()
    looked = kf.innovation(zero_velocity(kf, 0.01))
    assert np.array_equal(kf.nominal, nominal)
    assert np.array_equal(kf.covariance, covariance)
    assert looked.nis == kf.correct(zero_velocity(kf, 0.01)).nis


@pytest.mark.parametrize("seed", [1])
def test_covariance_stays_symmetric_and_positive_over_a_hundred_thousand_steps(seed):
    rng = np.random.default_rng(seed)
    kf = ErrorStateFilter()
    noise = ImuNoise(1e-3, 1e-4, 1e-5, 1e-6)
    for block, sigma in ((VEL, 1e-2), (ATT, 0.1), (GYRO_BIAS, 0.01), (ACCEL_BIAS, 0.1)):
        kf.set_block(block, sigma**2)
    accels = rng.normal((0.0, 0.0, 9.8), 2.0, (1000, 3)).tolist()
    gyros = rng.normal(0.0, 0.5, (1000, 3)).tolist()
    for step in range(100_000 if kernels.predict is not _kernels_twin.predict else 5_000):
        kf.predict(accels[step % 1000], gyros[step % 1000], 0.01, noise)
        if step % 100 > 60:
            kf.vel_n[:] *= 0.5
            kf.correct(zero_velocity(kf, 1e-3))
        if step % 100 == 99:
            kf.correct(zero_rate(kf, gyros[step % 1000], 1e-2))
            kf.pos_n[:] = 0.0
            kf.set_block(POS, 0.0)
    kf.correct(zero_velocity(kf, 1e-3))
    P = kf.covariance
    assert np.array_equal(P, P.T)
    scale = np.sqrt(P.diagonal() + 1e-30)
    assert np.linalg.eigvalsh(P / np.outer(scale, scale)).min() > -1e-9
    assert np.hypot.reduce(kf.q_nd) == pytest.approx(1.0, abs=1e-15)


def test_zero_velocity_after_a_swing_says_nothing_about_heading():
    """In frame n heading is the one direction of the attitude error that no stance shows."""
    kf = ErrorStateFilter()
    kf.set_block(ATT, 0.01)
    no_noise = ImuNoise(0.0, 0.0)
    for step in range(100):
        push = 3.0 * np.sin(2.0 * np.pi * (step + 0.5) / 100)
        kf.predict((push, -0.5 * push, kf.gravity_mps2), (0.0, 0.0, 0.0), 0.01, no_noise)
    kf.correct(zero_velocity(kf, 1e-3))
    assert kf.covariance[8, 8] == pytest.approx(0.01, rel=1e-12)
    assert kf.covariance[6, 6] < 1e-6


def test_a_filter_has_9_or_15_states():
    with pytest.raises(ValueError, match="9 or 15"):
        ErrorStateFilter(states=12)
