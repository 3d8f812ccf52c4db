"""Where each part of the filter's error and of its nominal state is: for people and kernels."""

from typing import Final

POS: Final = slice(0, 3)
"""Position error, frame n, metres."""
VEL: Final = slice(3, 6)
"""Velocity error, frame n, m/s."""
ATT: Final = slice(6, 9)
"""Attitude error, a rotation vector in frame n, radians."""
GYRO_BIAS: Final = slice(9, 12)
"""Error of the gyroscope bias, frame d, rad/s; only with 15 states."""
ACCEL_BIAS: Final = slice(12, 15)
"""Error of the accelerometer bias, frame d, m/s^2; only with 15 states."""

Q_ND: Final = slice(6, 10)
"""Attitude in the nominal state, after position and velocity."""
GYRO_BIAS_NOMINAL: Final = slice(10, 13)
"""Gyroscope bias in the nominal state, rad/s."""
ACCEL_BIAS_NOMINAL: Final = slice(13, 16)
"""Accelerometer bias in the nominal state, m/s^2."""
