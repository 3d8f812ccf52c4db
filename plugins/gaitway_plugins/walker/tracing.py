"""Per-sample estimates of the walker, for files and plots."""

from bisect import bisect_right
from typing import Final

import numpy as np

from gaitway.api import Stride, Trace
from gaitway_plugins.walker.blocks import Block
from gaitway_plugins.walker.fix import Fix

STYLES: Final = ("continuous", "step-by-step", "full-lift", "back-tips")
PHASES: Final = ("stand", "roll", "air")


class Tracer:
    """Writes each block as it is navigated, and the style of a step once it is known.

    Attributes:
        trace: What is written: position of the body's origin, heading, mean speed of the wheels,
            ``phase`` 0 standing, 1 rolling, 2 in the air, ``style`` 0 none and 1 to 4 continuous,
            step-by-step, full-lift, back-tips.
    """

    def __init__(self) -> None:
        self.trace = Trace(
            "pos_x_m", "pos_y_m", "pos_z_m", "heading_rad", "wheel_speed_mps", "phase", "style"
        )
        self._path_n = np.zeros(3)

    def write(self, block: Block, fix: Fix, phase: str) -> None:
        """Write the samples of a block, position in a straight line from the block before."""
        count = len(block.t_ns)
        for number, t_ns in enumerate(block.t_ns.tolist(), 1):
            pos = self._path_n + number / count * (fix.path_n - self._path_n)
            row = (*pos.tolist(), fix.heading_rad, fix.speed_mps, float(PHASES.index(phase)), 0.0)
            self.trace.append(t_ns, *row)
        self._path_n = fix.path_n

    def style(self, stride: Stride) -> None:
        """Write the style of a step into its samples."""
        code = 1.0 + STYLES.index(stride.style) if stride.style is not None else 0.0
        first = bisect_right(self.trace.t_ns, stride.start_t_ns)
        for row in range(first, bisect_right(self.trace.t_ns, stride.t_ns)):
            self.trace.rows[row] = (*self.trace.rows[row][:-1], code)
