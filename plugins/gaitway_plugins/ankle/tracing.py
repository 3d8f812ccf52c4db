"""Per-sample estimates of the ankle, for files and plots."""

import numpy as np

from gaitway.api import Floats, Trace
from gaitway_plugins.ankle.lever import Lever
from gaitway_plugins.ankle.motion import pivot_speed_mps
from gaitway_plugins.ankle.navigator import Anchor
from gaitway_plugins.ankle.track import Track

_ON_FLOOR_MPS = 0.3


class Tracer:
    """Writes each sample once, when its way is known.

    Attributes:
        trace: Position and velocity of the IMU in n, its attitude, the speed of the pivot,
            ``contact`` 1 on the floor. What an anchor corrects is spread over the way before it.
    """

    def __init__(self) -> None:
        self.trace = Trace(
            "pos_x_m", "pos_y_m", "pos_z_m", "vel_x_mps", "vel_y_mps", "vel_z_mps",
            "q_w", "q_x", "q_y", "q_z", "pivot_speed_mps", "contact",
        )  # fmt: skip
        self._next = 0

    def unknown(self, track: Track, begin: int, end: int) -> None:
        """Write samples of which nothing is known, unless they were written."""
        for index in range(max(begin, self._next), end):
            self.trace.append(track.t_ns(index), *[float("nan")] * 11, 0.0)
        self._next = 0

    def write(self, track: Track, path: Floats, anchor: Anchor, lever: Lever) -> None:
        """Write the samples that lead to an anchor, its own included."""
        first = anchor.index + 1 - len(path)
        for index in range(max(self._next, track.first), first):
            self.trace.append(track.t_ns(index), *[float("nan")] * 11, 0.0)
        gyro = track.gyro_d(first, anchor.index + 1)
        speed = pivot_speed_mps(path, gyro, lever)
        columns = np.column_stack([path, speed, speed < _ON_FLOOR_MPS])
        for row, values in enumerate(columns.tolist()):
            self.trace.append(track.t_ns(first + row), *values)
        self._next = anchor.index + 1
