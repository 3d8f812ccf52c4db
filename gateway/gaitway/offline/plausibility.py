"""Whether numbers are in the unit their column says: told from the walk itself."""

from typing import Final

import numpy as np

from gaitway.samples import Floats, Ints

GRAVITY_MPS2: Final = 9.80665
ACCEL_MIN_MPS2: Final = 5.0
ACCEL_MAX_MPS2: Final = 20.0
"""Half of all samples of a walk have a specific force between these; gravity alone makes 9.8."""
ACCEL_UNITS: Final = (
    ("g", 1.0, GRAVITY_MPS2),
    ("thousandths of g", 1000.0, GRAVITY_MPS2 / 1000.0),
    ("m/s^2 multiplied by 9.80665 once too often", GRAVITY_MPS2**2, 1 / GRAVITY_MPS2),
)
GYRO_MAX_RADPS: Final = 40.0
"""Above the 2000 deg/s (35 rad/s) at which the sensors of walking aids saturate."""
RADPS_PER_DPS: Final = np.pi / 180.0
TURN_S: Final = 0.25
SMOOTHED_S: Final = 0.05
MAX_TURNS: Final = 2000
MIN_TURNS: Final = 20
AT_REST: Final = 0.15
"""A specific force within this share of gravity shows which way is down well enough."""
TURN_MIN: Final = 0.1
"""Turns below this angle (radians, taken at face value) tell nothing."""
WRONG_RAD: Final = 0.7
RIGHT_RAD: Final = 0.4
RATIO: Final = 3.0
"""Turns taken as degrees must fit this much better; a mirrored axis makes a factor of 2.
Walks on people in the right unit miss by 0.15 to 0.38 rad, in the wrong one by 1.3 to 1.75."""
ANGLE_MAX_RAD: Final = 7.0


def accel_complaint(accel_b: Floats) -> str | None:
    """Return what is wrong with the unit of a specific force, None if nothing seems to be.

    Args:
        accel_b: Specific force that should be in m/s^2, shape (n, 3).
    """
    typical = float(np.median(np.linalg.norm(accel_b, axis=1)))
    if ACCEL_MIN_MPS2 < typical < ACCEL_MAX_MPS2:
        return None
    for unit, gravity, factor in ACCEL_UNITS:
        if 0.75 * gravity < typical < 1.3 * gravity:
            return f"looks like {unit}: its median norm is {typical:.4g} (multiply by {factor:.6g})"
    return (
        f"is no specific force in m/s^2: its median norm is {typical:.3g} where gravity alone "
        "makes 9.8 (gravity must not be removed)"
    )


def gyro_complaint(
    gyro_b: Floats, accel_b: Floats | None, index: Ints, period_s: float
) -> str | None:
    """Return what is wrong with the unit of an angular rate, None if nothing seems to be.

    A rate no sensor measures is in degrees. Slow movements are judged by the accelerometer: between
    two moments that show which way is down, the turn of that direction must be the integral of the
    angular rate, in one unit or the other.

    Args:
        gyro_b: Angular rate that should be in rad/s, shape (n, 3).
        accel_b: Specific force in m/s^2, shape (n, 3); None where there is none.
        index: Place of each row on the sample grid, shape (n,).
        period_s: Sample period.
    """
    high = float(np.quantile(np.linalg.norm(gyro_b, axis=1), 0.999))
    if high > GYRO_MAX_RADPS:
        return _in_degrees(f"it reaches {high:.4g}, more than any sensor measures in rad/s")
    if accel_b is None:
        return None
    errors_rad = _turn_errors(gyro_b, accel_b, index, period_s)
    if errors_rad is None:
        return None
    as_rad, as_deg = errors_rad
    if as_rad > WRONG_RAD and as_deg < RIGHT_RAD and as_rad > RATIO * as_deg:
        return _in_degrees("only then do its turns fit those of the accelerometer")
    return None


def angle_complaint(angle_rad: Floats) -> str | None:
    """Return what is wrong with the unit of an angle that should be in radians, or None."""
    high = float(np.quantile(np.abs(angle_rad), 0.999))
    if high <= ANGLE_MAX_RAD:
        return None
    return f"looks like degrees: it reaches {high:.4g} (multiply by {RADPS_PER_DPS:.7f})"


def _in_degrees(why: str) -> str:
    return f"looks like degrees per second: {why} (multiply by {RADPS_PER_DPS:.7f})"


def _turn_errors(
    gyro_b: Floats, accel_b: Floats, index: Ints, period_s: float
) -> tuple[float, float] | None:
    """Return by how much turned gravity misses, median angle in radians, in both units.

    None where the walk has too few turns to tell.
    """
    length = max(2, round(TURN_S / period_s))
    half = round(SMOOTHED_S / period_s / 2)
    norm = np.linalg.norm(accel_b, axis=1)
    still = np.abs(norm / GRAVITY_MPS2 - 1) < AT_REST
    begins = np.arange(half, len(index) - length - half)
    whole = index[begins + length + half] - index[begins - half] == length + 2 * half
    begins = begins[whole & still[begins] & still[begins + length]]
    # Turns at their face value, from the rate's running sum.
    angles = np.cumsum(np.linalg.norm(gyro_b, axis=1)) * period_s
    turns = angles[begins + length] - angles[begins]
    begins = begins[(turns > TURN_MIN) & (turns >= np.median(turns))] if len(begins) else begins
    if len(begins) < MIN_TURNS:
        return None
    begins = begins[:: max(1, len(begins) // MAX_TURNS)]
    before, after = (_down(accel_b, rows, half) for rows in (begins, begins + length))
    as_rad, as_deg = (
        float(np.median(_angle(_turned(before, gyro_b * scale, begins, length, period_s), after)))
        for scale in (1.0, RADPS_PER_DPS)
    )
    return as_rad, as_deg


def _down(accel_b: Floats, rows: Ints, half: int) -> Floats:
    """Return unit vectors of the specific force around rows, shape (m, 3)."""
    smooth = sum(accel_b[rows + shift] for shift in range(-half, half + 1))
    return np.asarray(smooth / np.linalg.norm(smooth, axis=1, keepdims=True))


def _turned(u_b: Floats, gyro_b: Floats, begins: Ints, length: int, period_s: float) -> Floats:
    """Return directions fixed in the world after the sensor has turned, shape (m, 3)."""
    for step in range(length):
        # du/dt = -gyro x u over one period, the rate held at its mean: Rodrigues' formula.
        rate = (gyro_b[begins + step] + gyro_b[begins + step + 1]) / 2
        angle = np.linalg.norm(rate, axis=1, keepdims=True) * period_s
        axis = rate * period_s / np.maximum(angle, 1e-12)
        along = np.sum(axis * u_b, axis=1, keepdims=True) * axis
        u_b = along + (u_b - along) * np.cos(angle) - np.cross(axis, u_b) * np.sin(angle)
    return u_b


def _angle(u: Floats, v: Floats) -> Floats:
    return np.asarray(np.arccos(np.clip(np.sum(u * v, axis=1), -1.0, 1.0)))
