"""How the IMU sits on the walker, from one straight roll (Doan & Pham 2019, Section 2.2).

``z`` is the specific force at rest (Eq. 3). The paper's Eqs. 1-2 turn about the wrong axis; with
the errata ``x`` is the horizontal direction of the roll in IMU axes and ``y = z x x``. The paper
takes the direction from the displacement, double-integrated over the roll; here the velocity, in
axes that the gyroscope carries along, is fitted by the wheels' speed, which also tells forward from
backward, and by a drift: a constant and a growing acceleration, for tilt and bias.
"""

from collections.abc import Callable
from math import degrees, radians
from typing import Any, Final, NamedTuple

import numpy as np

from gaitway.api import CalibrationError, CalibrationResult, Floats
from gaitway.estimation.rotation import IDENTITY, from_rotation_vector, multiply, rotate
from gaitway_plugins.walker.params import WalkerParams
from gaitway_plugins.walker.stretches import Stretch

CROOKED_RAD: Final = radians(4.0)
"""A roll that turns further is not straight."""
UNSURE_RAD: Final = radians(2.0)
"""A direction with a larger standard deviation is refused."""
_MEMORY_S: Final = 1.0
"""How long an error of the integrated velocity lasts: so many values are one."""


class Fit(NamedTuple):
    """What a straight roll says.

    Attributes:
        C_db: From IMU to device components, shape (3, 3).
        scale: Speed that the accelerometer felt relative to that of the wheels.
        sigma_rad: Standard deviation of the direction.
        time_s: Of each sample, shape (n,).
        speed_mps: Of the wheels, shape (n,).
        felt_mps: Forward, left by the IMU, without drift, shape (n, 2).
    """

    C_db: Floats
    scale: float
    sigma_rad: float
    time_s: Floats
    speed_mps: Floats
    felt_mps: Floats


def straight_roll(found: list[Stretch], params: WalkerParams, least_m: float) -> CalibrationResult:
    """Return the mounting that the longest roll shows.

    Args:
        found: Rolls with standing at both ends.
        params: Of the walker.
        least_m: Shortest roll that will do.

    Raises:
        CalibrationError: It was not straight, too short, or IMU and wheels disagree.
    """
    if not found:
        raise CalibrationError(
            "no roll with standing before and after: stand still for 2 s, roll straight ahead, "
            "stand still for 2 s, hands on the walker all the time"
        )
    stretch = max(found, key=lambda s: abs(s.travel_m))
    _refuse_crooked(stretch, params, least_m)
    fit = fit_direction(stretch)
    if not 0.8 < fit.scale < 1.25:
        raise CalibrationError(
            f"the IMU felt {fit.scale:.2f} times the speed of the wheels: check wheel_radius_m and "
            "pulses_per_revolution, and that nothing slid"
        )
    if fit.sigma_rad > UNSURE_RAD:
        raise CalibrationError(
            f"the direction is known to {degrees(fit.sigma_rad):.1f} deg only: set off and stop "
            "more firmly, on a smoother floor"
        )
    return CalibrationResult(
        params={},
        mounting=fit.C_db,
        findings=[
            f"rolled {abs(stretch.travel_m):.2f} m, turned {degrees(stretch.turned_rad):+.1f} deg",
            f"forward in IMU axes: {_vector(fit.C_db[0])}, +- {degrees(fit.sigma_rad):.1f} deg",
            f"up in IMU axes: {_vector(fit.C_db[2])}",
            f"speed of the IMU over that of the wheels: {fit.scale:.3f}",
        ],
        warnings=[] if 0.95 < fit.scale < 1.05 else ["IMU and wheels differ: calibrate the wheels"],
        picture=_picture(fit),
    )


def _refuse_crooked(stretch: Stretch, params: WalkerParams, least_m: float) -> None:
    left_m, right_m = stretch.wheels_m.sum(axis=0).tolist()
    if left_m * right_m <= 0.0 or min(abs(left_m), abs(right_m)) < 0.5 * max(
        abs(left_m), abs(right_m)
    ):
        raise CalibrationError(
            f"the wheels rolled {left_m:+.2f} m (left) and {right_m:+.2f} m (right): one is stuck, "
            "not counted or counts the other way round"
        )
    if abs(stretch.travel_m) < least_m:
        raise CalibrationError(
            f"the longest roll is {abs(stretch.travel_m):.2f} m; at least {least_m:g} m are needed"
        )
    by_wheels_rad = stretch.apart_m / params.track_m
    turned_rad = max(abs(by_wheels_rad), abs(stretch.turned_rad))
    if turned_rad > CROOKED_RAD:
        raise CalibrationError(
            f"the roll was crooked: the wheels turned {degrees(by_wheels_rad):+.1f} deg, the "
            f"gyroscope {degrees(stretch.turned_rad):+.1f} deg; roll along a line on the floor"
        )


def fit_direction(stretch: Stretch) -> Fit:
    """Return the mounting by least squares in velocity."""
    z = stretch.up_b
    ahead = np.eye(3)[int(np.argmin(np.abs(z)))]
    e1 = np.cross(ahead, z)
    e1 /= np.sqrt(e1.dot(e1))
    across = np.stack([e1, np.cross(z, e1)])
    felt = _velocity(stretch) @ across.T
    time_s = np.arange(1.0, len(felt) + 1.0, dtype=np.float64) * stretch.period_s
    speed = _smooth(stretch.wheels_m.mean(axis=1) / stretch.period_s, stretch.period_s)
    felt = np.stack([_smooth(column, stretch.period_s) for column in felt.T], axis=1)
    terms = np.stack([speed, time_s, time_s**2], axis=1)
    coefficients, *_ = np.linalg.lstsq(terms, felt, rcond=None)
    rest = felt - terms @ coefficients
    direction = coefficients[0]
    scale = float(np.sqrt(direction.dot(direction)))
    x = direction / scale @ across
    y = np.cross(z, x)
    free = max(1.0, len(felt) * stretch.period_s / _MEMORY_S - 3.0)
    spread = np.linalg.inv(terms.T @ terms)[0, 0] * len(felt) / free
    sigma = float(np.sqrt((rest**2).mean() * spread)) / scale
    clean = felt - terms[:, 1:] @ coefficients[1:]
    return Fit(
        C_db=np.stack([x, y, z]),
        scale=scale,
        sigma_rad=sigma,
        time_s=time_s,
        speed_mps=speed,
        felt_mps=clean @ across @ np.stack([x, y]).T,
    )


def _velocity(stretch: Stretch) -> Floats:
    """Return the integrated specific force less gravity in the IMU's axes at the start, (n, 3)."""
    q, out = IDENTITY, np.empty_like(stretch.accel_b)
    for row, (force, rate) in enumerate(
        zip(stretch.accel_b.tolist(), stretch.gyro_b.tolist(), strict=True)
    ):
        half = from_rotation_vector([0.5 * stretch.period_s * w for w in rate])
        q = multiply(q, half)
        out[row] = rotate(q, force)
        q = multiply(q, half)
    return np.asarray(np.cumsum(out - stretch.rest_b, axis=0) * stretch.period_s)


def _smooth(values: Floats, period_s: float) -> Floats:
    """Return a centred mean over 0.1 s: counts are coarse, and both sides are treated alike."""
    size = max(1, round(0.1 / period_s)) | 1
    padded = np.pad(values, size // 2, mode="edge")
    return np.convolve(padded, np.ones(size) / size, mode="valid")


def _vector(unit: Floats) -> str:
    return "(" + ", ".join(f"{value:+.3f}" for value in unit) + ")"


def _picture(fit: Fit) -> Callable[[Any], None]:
    def draw(figure: Any) -> None:
        axes = figure.subplots()
        axes.plot(fit.time_s, fit.speed_mps, label="wheels")
        axes.plot(fit.time_s, fit.felt_mps[:, 0], label="IMU, forward")
        axes.plot(fit.time_s, fit.felt_mps[:, 1], label="IMU, left")
        axes.set_xlabel("time (s)")
        axes.set_ylabel("speed (m/s)")
        axes.set_title(f"forward is known to {degrees(fit.sigma_rad):.1f} deg")
        axes.legend()

    return draw
