"""What the compiled kernels compute, said in numpy with whole matrices: to read, and to fall back.

Every function works on the two buffers of an ``ErrorStateFilter``, written in place: ``nominal`` of
shape (16,) and ``covariance`` of shape (states, states). Tests hold ``_kernels.c`` against it.
"""

from collections.abc import Iterable
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from gaitway.estimation.noise import ImuNoise
from gaitway.estimation.rotation import (
    cross,
    from_rotation_vector,
    multiply,
    normalized,
    skew,
    to_matrix,
)
from gaitway.estimation.states import (
    ACCEL_BIAS,
    ACCEL_BIAS_NOMINAL,
    ATT,
    GYRO_BIAS,
    GYRO_BIAS_NOMINAL,
    POS,
    Q_ND,
    VEL,
)
from gaitway.samples import Floats


def predict(
    nominal: Floats,
    covariance: Floats,
    accel_d: Iterable[float],
    gyro_d: Iterable[float],
    dt_s: float,
    gravity_mps2: float,
    accel_mps2_rthz: float,
    gyro_radps_rthz: float,
    accel_bias_walk_mps2_rts: float,
    gyro_bias_walk_radps_rts: float,
    /,
) -> None:
    """Go on by one sample: the nominal state, and ``P <- F P F^T + Q``."""
    rate_d = np.subtract(tuple(gyro_d), nominal[GYRO_BIAS_NOMINAL])
    force_d = np.subtract(tuple(accel_d), nominal[ACCEL_BIAS_NOMINAL])
    half_turn = from_rotation_vector((0.5 * dt_s * rate_d).tolist())
    q_middle = multiply(nominal[Q_ND].tolist(), half_turn)
    C_nd = to_matrix(q_middle)
    force_n = C_nd.dot(force_d)
    accel_n = force_n - (0.0, 0.0, gravity_mps2)
    nominal[POS] += nominal[VEL] * dt_s + accel_n * (0.5 * dt_s**2)
    nominal[VEL] += accel_n * dt_s
    nominal[Q_ND] = normalized(multiply(q_middle, half_turn))
    densities = (
        accel_mps2_rthz,
        gyro_radps_rthz,
        accel_bias_walk_mps2_rts,
        gyro_bias_walk_radps_rts,
    )
    F = _transition(C_nd, force_n, dt_s, len(covariance))
    covariance[:] = F.dot(_symmetric(covariance)).dot(F.T)
    covariance += _process_covariance(densities, dt_s, len(covariance))
    covariance[:] = _symmetric(covariance)


def run(
    nominal: Floats,
    covariance: Floats,
    accel_d: Floats,
    gyro_d: Floats,
    dt_s: float,
    gravity_mps2: float,
    accel_mps2_rthz: float,
    gyro_radps_rthz: float,
    accel_bias_walk_mps2_rts: float,
    gyro_bias_walk_radps_rts: float,
    still: NDArray[np.bool_] | None,
    imu_to_pivot_d: Iterable[float],
    sigma_mps: float,
    out: Floats | None,
    /,
) -> None:
    """Go on by many samples, and after those that are still take in that a point stands still."""
    densities = (
        accel_mps2_rthz,
        gyro_radps_rthz,
        accel_bias_walk_mps2_rts,
        gyro_bias_walk_radps_rts,
    )
    n, lever_d, whitened = len(accel_d), tuple(imu_to_pivot_d), np.empty(3)
    if any(len(other) != n for other in (gyro_d, still, out) if other is not None):
        raise ValueError("gyro_d, still and out need as many rows as accel_d")
    for row in range(n):
        predict(nominal, covariance, accel_d[row], gyro_d[row], dt_s, gravity_mps2, *densities)
        if still is not None and still[row]:
            seen = _pivot_velocity(nominal, gyro_d[row], lever_d, sigma_mps, len(covariance))
            correct(nominal, covariance, *seen, whitened)
        if out is not None:
            out[row] = nominal[:10]


def innovation(
    nominal: Floats,  # noqa: ARG001  # the compiled one checks it
    covariance: Floats,
    z: Floats,
    H: Floats,
    R: Floats,
    standardised: Floats,
    /,
) -> float:
    """Write ``L^-1 z`` of ``S = H P H^T + R = L L^T`` and return its sum of squares."""
    S = H.dot(_symmetric(covariance)).dot(H.T) + R
    standardised[:] = np.linalg.solve(_cholesky(S), z)
    return float(standardised.dot(standardised))


def correct(
    nominal: Floats,
    covariance: Floats,
    z: Floats,
    H: Floats,
    R: Floats,
    standardised: Floats,
    /,
) -> float:
    """Do what ``innovation`` does and move the error that shows into the nominal state.

    With ``G = P H^T L^-T`` the gain is ``G L^-1`` and the covariance falls by ``G G^T``: Joseph's
    form with the optimal gain, symmetric as it stands.
    """
    nis = innovation(nominal, covariance, z, H, R, standardised)
    P = _symmetric(covariance)
    G = np.linalg.solve(_cholesky(H.dot(P).dot(H.T) + R), H.dot(P)).T
    covariance[:] = _symmetric(P - G.dot(G.T))
    error = G.dot(standardised)
    nominal[:6] += error[:6]
    turn = from_rotation_vector(error[ATT].tolist())
    nominal[Q_ND] = normalized(multiply(turn, nominal[Q_ND].tolist()))
    if len(covariance) == 15:
        nominal[10:] += error[9:]
    return nis


def _transition(C_nd: Floats, force_n: Floats, dt_s: float, states: int) -> Floats:
    """Return ``F = I + dt A`` of the error dynamics (``gaitway.estimation.error_state``)."""
    F = np.eye(states)
    F[POS, VEL] = np.eye(3) * dt_s
    F[VEL, ATT] = -skew((force_n * dt_s).tolist())
    if states == 15:
        F[ATT, GYRO_BIAS] = F[VEL, ACCEL_BIAS] = -dt_s * C_nd
    return F


def _pivot_velocity(
    nominal: Floats,
    gyro_d: Floats,
    lever_d: tuple[float, ...],
    sigma_mps: float,
    states: int,
) -> tuple[Floats, Floats, Floats]:
    """Return what ``gaitway.estimation.pivot_velocity`` does."""
    C_nd = to_matrix(nominal[Q_ND].tolist())
    rate_d = gyro_d - nominal[GYRO_BIAS_NOMINAL]
    turning_n = C_nd.dot(cross(rate_d.tolist(), lever_d))
    H = np.zeros((3, states))
    H[:, VEL] = np.eye(3)
    H[:, ATT] = -skew(turning_n.tolist())
    if states == 15:
        H[:, GYRO_BIAS] = C_nd.dot(skew(lever_d))
    return -(nominal[VEL] + turning_n), H, np.eye(3) * sigma_mps**2


def _cholesky(S: Floats) -> Floats:
    if np.isnan(S).any():  # goes on as such, as it does in C
        return np.full_like(S, np.nan)
    return np.asarray(np.linalg.cholesky(S), np.float64)


def _symmetric(P: Floats) -> Floats:
    """Return the symmetric matrix of which P has the upper triangle."""
    upper = np.triu(P)
    symmetric: Floats = upper + np.triu(P, 1).T
    return symmetric


@lru_cache(maxsize=32)
def _process_covariance(densities: tuple[float, ...], dt_s: float, states: int) -> Floats:
    Q = ImuNoise(*densities).process_covariance(dt_s, states)
    Q.setflags(write=False)
    return Q
