"""Readings at the end of a sensor's range, told from the data alone."""

from operator import eq
from typing import Final

from gaitway.estimation.gaps import ImuSample

_CEILING_MIN: Final = (12.0,) * 3 + (4.0,) * 3
"""Lowest reading that can be the end of a range: the narrowest accelerometer in use for gait ends
at 1.5 g (14.7 m/s^2), the narrowest gyroscope at 250 deg/s (4.4 rad/s)."""
_RUN: Final = 3
"""So many equal readings in a row at such a height are a ceiling: noise would move them."""


class ClipDetector:
    """Takes what the device says, and looks for plateaus where it says nothing."""

    def __init__(self) -> None:
        self._last: tuple[float, ...] = (0.0,) * 6
        self._runs = [1] * 6

    def push(self, sample: ImuSample) -> bool:
        """Take the next sample; return whether it is clipped."""
        readings = sample.accel_d + sample.gyro_d
        same = tuple(map(eq, readings, self._last))
        self._last = readings
        if True not in same:
            self._runs = [1] * 6
            return sample.clipped
        self._runs = [run + 1 if equal else 1 for run, equal in zip(self._runs, same, strict=True)]
        plateau = any(
            run >= _RUN and abs(reading) >= least
            for run, reading, least in zip(self._runs, readings, _CEILING_MIN, strict=True)
        )
        return plateau or sample.clipped
