"""Whether the filter's covariance is true: many runs on data drawn from its own model."""

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
    Rest,
    align_at_rest,
    gravity,
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

DT_S = 0.01
NOISE = ImuNoise(5e-3, 5e-4, 1e-3, 1e-4)
ZERO_VELOCITY_MPS, ZERO_RATE_RADPS, GRAVITY_MPS2 = 5e-3, 5e-3, 0.05
SIGMAS = ((VEL, 5e-3), (ATT, 0.02), (GYRO_BIAS, 5e-3), (ACCEL_BIAS, 0.05))
SWINGS, SWING, STANCE = 6, 80, 40


class Trial:
    """One true walk with its noisy sensor, and a filter that starts with the error it expects."""

    def __init__(self, seed):
        self.rng = np.random.default_rng(seed)
        self.truth = ErrorStateFilter()
        self.truth.q_nd = from_rotation_vector((0.1, -0.2, 0.4))
        self.kf = ErrorStateFilter()
        self.kf.nominal[:] = self.truth.nominal
        for block, sigma in SIGMAS:
            self.kf.set_block(block, sigma**2)
        error = self.rng.standard_normal(15) * np.sqrt(self.kf.covariance.diagonal())
        self.truth.vel_n[:] = 0.0
        self.kf.vel_n[:] -= error[VEL]
        self.kf.q_nd = multiply(from_rotation_vector(-error[ATT]), self.kf.q_nd)
        self.truth.gyro_bias_d[:], self.truth.accel_bias_d[:] = error[9:12], error[12:]
        self.nis = {"velocity": [], "rate": [], "gravity": []}

    def step(self, push_n, turn_d):
        draw, truth = self.rng.standard_normal, self.truth
        middle = multiply(truth.q_nd, from_rotation_vector(0.5 * DT_S * np.array(turn_d)))
        force_d = rotate(conjugate(middle), np.add(push_n, (0.0, 0.0, truth.gravity_mps2)))
        self.accel_d = force_d + truth.accel_bias_d
        self.gyro_d = turn_d + truth.gyro_bias_d
        truth.predict(self.accel_d, self.gyro_d, DT_S, ImuNoise(0.0, 0.0))
        self.accel_d = self.accel_d + NOISE.accel_mps2_rthz / np.sqrt(DT_S) * draw(3)
        self.gyro_d = self.gyro_d + NOISE.gyro_radps_rthz / np.sqrt(DT_S) * draw(3)
        self.kf.predict(self.accel_d, self.gyro_d, DT_S, NOISE)
        truth.gyro_bias_d[:] += NOISE.gyro_bias_walk_radps_rts * np.sqrt(DT_S) * draw(3)
        truth.accel_bias_d[:] += NOISE.accel_bias_walk_mps2_rts * np.sqrt(DT_S) * draw(3)

    def swing(self):
        self.mark()
        for step in range(SWING):
            push = 2.0 * np.sin(2.0 * np.pi * (step + 0.5) / SWING)
            turn = 0.8 * np.sin(2.0 * np.pi * (step + 0.5) / SWING)
            self.step((push, 0.3 * push, 0.5 * push), np.array([0.2, 1.0, 0.3]) * turn)

    def stand(self):
        kf = self.kf
        for step in range(STANCE):
            self.step((0.0, 0.0, 0.0), np.zeros(3))
            # What the filter is told has to have the noise it is told with.
            seen = zero_velocity(kf, ZERO_VELOCITY_MPS)
            noise = ZERO_VELOCITY_MPS * self.rng.standard_normal(3)
            self.nis["velocity"].append(kf.correct(seen._replace(z=seen.z + noise)).nis)
            if step == STANCE // 2:
                sigma = GRAVITY_MPS2
                up_d = rotate(conjugate(self.truth.q_nd), (0.0, 0.0, kf.gravity_mps2))
                felt = up_d + self.truth.accel_bias_d + sigma * self.rng.standard_normal(3)
                self.nis["gravity"].append(kf.correct(gravity(kf, felt, sigma)).nis)
                sigma = ZERO_RATE_RADPS
                felt = self.truth.gyro_bias_d + sigma * self.rng.standard_normal(3)
                self.nis["rate"].append(kf.correct(zero_rate(kf, felt, sigma)).nis)

    def mark(self):
        for kf in (self.kf, self.truth):
            kf.pos_n[:] = 0.0
        self.kf.set_block(POS, 0.0)

    def nees(self):
        theta = to_rotation_vector(multiply(self.truth.q_nd, conjugate(self.kf.q_nd)))
        linear = self.truth.nominal - self.kf.nominal
        error = np.concatenate([linear[:6], theta, linear[10:]])
        return error @ np.linalg.solve(self.kf.covariance, error)


def mean_of_chi_square(dof, draws):
    """Return what the mean of so many draws is, give or take four standard deviations."""
    return pytest.approx(dof, abs=4.0 * np.sqrt(2.0 * dof / draws))


@pytest.fixture(scope="module", params=[20])
def trials(request):
    trials = [Trial(seed) for seed in range(request.param)]
    for trial in trials:
        for _ in range(SWINGS):
            trial.swing()
            trial.stand()
    return trials


def test_the_error_of_the_state_is_as_large_as_its_covariance_says(trials):
    assert np.mean([trial.nees() for trial in trials]) == mean_of_chi_square(15, len(trials))


@pytest.mark.parametrize("kind", ["velocity", "rate", "gravity"])
def test_innovations_are_as_large_as_the_filter_expects(trials, kind):
    draws = np.concatenate([trial.nis[kind] for trial in trials])
    assert draws.mean() == mean_of_chi_square(3, len(draws))


@pytest.mark.parametrize("states", [9, 15])
def test_an_alignment_knows_how_wrong_its_tilt_is(states):
    """Tilt is wrong by the accelerometer's bias, which 15 states remember as a correlation."""
    rng = np.random.default_rng(7)
    bias_mps2, normalised = 0.05, []
    for _ in range(300):
        q_true = from_rotation_vector(rng.normal(0.0, [0.2, 0.2, 0.0]))
        up_d = np.array(rotate(conjugate(q_true), (0.0, 0.0, 9.80665)))
        felt = up_d + bias_mps2 * rng.standard_normal(3)
        kf = ErrorStateFilter(states=states)
        align_at_rest(
            kf,
            Rest(tuple(felt.tolist()), (0.0, 0.0, 0.0), 0.5),
            accel_bias_sigma_mps2=bias_mps2,
            gyro_bias_sigma_radps=1e-3,
            velocity_sigma_mps=1e-3,
        )
        tilt_error = np.subtract(rotate(kf.q_nd, up_d.tolist()), (0.0, 0.0, 9.80665)) / 9.80665
        normalised.append(tilt_error[1] / np.sqrt(kf.covariance[6, 6]))
    assert np.std(normalised) == pytest.approx(1.0, abs=0.15)
