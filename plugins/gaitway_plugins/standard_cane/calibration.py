"""Where the tip is: the cane held on one spot and leaned about, a least-squares fit."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from gaitway.api import (
    ACCEL,
    GYRO,
    CalibrationError,
    CalibrationPart,
    CalibrationResult,
    Floats,
    SampleBatch,
)
from gaitway.estimation import STANDARD_GRAVITY_MPS2, half_window
from gaitway_plugins.standard_cane.params import StandardCaneParams, TipOptions

_WINDOW_S: Final = 0.05
"""Over which specific force and angular rate are smoothed alike."""
_MIN_DURATION_S: Final = 8.0
_MAX_SIGMA_M: Final = 0.01
_MAX_RESIDUAL_MPS2: Final = 0.2
_SCALE: Final = 0.002
"""Relative error of a length by what is wrong with the sensor's scales."""
_CORRELATED_S: Final = 0.1
"""Neighbouring residuals are alike for so long: so many samples count as one."""
_ITERATIONS: Final = 12
_CONDITION_MAX: Final = 1e10
_PRIOR: Final = np.diag([0.0, 0.0, 0.0, 4.0, 4.0, 4.0])
"""A bias of the accelerometer is a few hundredths: without that, it and the tip trade places."""
_REACH_M: Final = (0.05, 1.3)


@dataclass(frozen=True, slots=True)
class TipFit:
    """Result of the least squares.

    Attributes:
        imu_to_tip_b: Metres, in axes of the IMU, shape (3,).
        covariance: Of it, shape (3, 3).
        measured: What turning adds to the norm of the specific force, m/s^2, shape (n,).
        fitted: The same by the fit, shape (n,).
    """

    imu_to_tip_b: Floats
    covariance: Floats
    measured: Floats
    fitted: Floats

    @property
    def residual_mps2(self) -> float:
        """Return the root mean square of what the fit does not explain."""
        return float(np.sqrt(np.mean((self.measured - self.fitted) ** 2)))


def fit_tip(
    _params: StandardCaneParams, _options: TipOptions, parts: Sequence[CalibrationPart]
) -> CalibrationResult:
    """Find the tip from a recording in which it stood while the shaft was leaned about.

    Raises:
        CalibrationError: Too short, too little motion, or the tip did not stand.
    """
    batches = [item for part in parts for item in part.items if isinstance(item, SampleBatch)]
    fit = solve(batches)
    sigma_m = np.sqrt(fit.covariance.diagonal())
    told = ", ".join(f"{x:.3f}" for x in fit.imu_to_tip_b)
    length_m = float(np.linalg.norm(fit.imu_to_tip_b))
    along = fit.imu_to_tip_b / length_m
    along_sigma_m = math.hypot(math.sqrt(along @ fit.covariance @ along), _SCALE * length_m)
    findings = [
        f"imu_to_tip_m = [{told}] m, +- {', '.join(f'{x:.4f}' for x in sigma_m)} m",
        f"distance of the tip {length_m:.3f} +- {along_sigma_m:.4f} m; the fit leaves "
        f"{fit.residual_mps2:.3f} m/s^2",
    ]
    params = {
        "imu_to_tip_m": [round(float(x), 4) for x in fit.imu_to_tip_b],
        "imu_to_tip_sigma_m": round(along_sigma_m, 4),
    }
    return CalibrationResult(params=params, findings=findings, picture=_picture(fit))


def solve(batches: Sequence[SampleBatch]) -> TipFit:
    """Return the least-squares tip of ``|y_a + A p| = g`` with ``A = [w' x] + [w x]^2``.

    With the tip fixed, ``y_a = C g - A p`` (Dang & Suh 2018, Eq. 27 corrected). The attitude is
    not needed, as the length of gravity does not depend on it; Gauss and Newton find p, a bias of
    the accelerometer with it, from the start ``p = 0``.

    Raises:
        CalibrationError: Too short, too little motion, or the tip did not stand.
    """
    rows = [_smoothed(batch) for batch in batches]
    accel = np.concatenate([accel for accel, _ in rows])
    A = np.concatenate([matrix for _, matrix in rows])
    period_s = batches[0].period_s if batches else 1.0
    if len(accel) * period_s < _MIN_DURATION_S:
        raise CalibrationError(
            f"only {len(accel) * period_s:.1f} s without gaps: lean the cane about for 20 s"
        )
    state, J = _adjusted(accel, A)
    normal = J.T @ J + _PRIOR
    force = accel + np.einsum("nij,j->ni", A, state[:3]) - state[3:]
    residual = STANDARD_GRAVITY_MPS2 - np.linalg.norm(force, axis=1)
    variance = float(residual @ residual) / len(residual) * max(1.0, _CORRELATED_S / period_s)
    turning = J[:, :3] @ state[:3]
    covariance = variance * np.linalg.inv(normal)[:3, :3]
    fit = TipFit(state[:3], covariance, turning + residual, turning)
    _judge(fit)
    return fit


def _adjusted(accel: Floats, A: Floats) -> tuple[Floats, Floats]:
    """Return tip and bias, shape (6,), and how they show in the norm, shape (n, 6)."""
    state = np.zeros(6)
    J = np.zeros((len(accel), 6))
    for _ in range(_ITERATIONS):
        force = accel + np.einsum("nij,j->ni", A, state[:3]) - state[3:]
        norm = np.linalg.norm(force, axis=1)
        unit = force / norm[:, None]
        J = np.hstack([np.einsum("ni,nij->nj", unit, A), -unit])
        normal = J.T @ J + _PRIOR
        if np.linalg.cond(normal) > _CONDITION_MAX:
            raise CalibrationError(_POOR)
        step = np.linalg.solve(normal, J.T @ (STANDARD_GRAVITY_MPS2 - norm) - _PRIOR @ state)
        state = state + step
    return state, J


_POOR: Final = (
    "the cane was hardly turned: keep the tip on one spot and lean the shaft to and fro and to "
    "both sides, quickly, by about 30 degrees"
)


def _judge(fit: TipFit) -> None:
    if not np.isfinite(fit.imu_to_tip_b).all() or fit.residual_mps2 > _MAX_RESIDUAL_MPS2:
        raise CalibrationError(
            f"the tip did not stand on one spot (the fit leaves {fit.residual_mps2:.2f} m/s^2): "
            "press it down on a mat that does not slip, and do not lift it"
        )
    worst_m = float(np.sqrt(fit.covariance.diagonal().max()))
    if worst_m > _MAX_SIGMA_M:
        raise CalibrationError(f"uncertain by {1e3 * worst_m:.0f} mm: {_POOR}")
    length_m = float(np.linalg.norm(fit.imu_to_tip_b))
    if not _REACH_M[0] <= length_m <= _REACH_M[1]:
        raise CalibrationError(f"a tip {length_m:.2f} m from the sensor is no cane's: {_POOR}")


def _smoothed(batch: SampleBatch) -> tuple[Floats, Floats]:
    """Return specific force, shape (n, 3), and A, shape (n, 3, 3), both over the same window."""
    half = max(1, half_window(_WINDOW_S, batch.period_s))
    if len(batch) <= 2 * half + 2:
        return np.empty((0, 3)), np.empty((0, 3, 3))
    accel, gyro = batch.channels[ACCEL.name], batch.channels[GYRO.name]
    slope = (gyro[2:] - gyro[:-2]) / (2.0 * batch.period_s)
    A = _skews(slope) + _skews(gyro[1:-1]) @ _skews(gyro[1:-1])
    flat = np.hstack([accel[1:-1], A.reshape(-1, 9)])
    sums = np.cumsum(np.vstack([np.zeros(12), flat]), axis=0)
    width = 2 * half + 1
    means = (sums[width:] - sums[:-width]) / width
    return means[:, :3], means[:, 3:].reshape(-1, 3, 3)


def _skews(vectors: Floats) -> Floats:
    """Return ``[v x]`` of each row, shape (n, 3, 3)."""
    x, y, z = vectors.T
    zero = np.zeros_like(x)
    return np.array([[zero, -z, y], [z, zero, -x], [-y, x, zero]]).transpose(2, 0, 1)


def _picture(fit: TipFit) -> Callable[[Any], None]:
    def draw(figure: Any) -> None:
        axes = figure.add_subplot()
        axes.plot(fit.fitted, fit.measured, ".", markersize=2, alpha=0.4)
        ends = [float(fit.fitted.min()), float(fit.fitted.max())]
        axes.plot(ends, ends, "k", linewidth=1)
        axes.set_xlabel("what turning about the fitted tip adds to the specific force, m/s$^2$")
        axes.set_ylabel("measured, m/s$^2$")
        axes.set_title(f"tip {np.linalg.norm(fit.imu_to_tip_b):.3f} m from the sensor")

    return draw
