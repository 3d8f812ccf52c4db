"""The quiet middle of each stance, found in the energy of the motion, at any pace.

The energy of a sample is ``|w|^2 + (w_f (|f| - g))^2`` (``f`` specific force, ``w_f`` makes a rate
of it), its mean over a tenth of a second the paper's (Wu, Wang & Pottie, II-D-1) with the
accelerometer's share added, without which the turning points of a swing look quiet. It falls and
rises by an order of magnitude from swing to stance, in a shuffle as in a run: so a valley is told
by its depth below the peaks to its sides, not by a threshold.
"""

import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Final

from gaitway.estimation import STANDARD_GRAVITY_MPS2, CentredMean, half_window
from gaitway_plugins.ankle.params import AnkleParams

_QUIET_RATIO: Final = 3.0
"""The quiet part has less than so many times the lowest energy."""


@dataclass(frozen=True, slots=True)
class Quiet:
    """A quiet stretch between two swings.

    Attributes:
        begin: Number of the first sample of its quiet part.
        end: Number of its last.
        valley: First and last sample of all of the stretch that is no swing.
        energy: Lowest energy in it, rad^2/s^2.
    """

    begin: int
    end: int
    valley: tuple[int, int]
    energy: float

    @property
    def middle(self) -> int:
        """Return the sample in its middle."""
        return (self.begin + self.end) // 2


class QuietDetector:
    """Follows the energy from peak to valley to peak.

    Args:
        params: Of the ankle.
        period_s: Of the samples.

    Attributes:
        lag: How many samples after its own the energy of a sample is known.
        moving: Whether it is on a peak now.
    """

    def __init__(self, params: AnkleParams, period_s: float) -> None:
        self.lag: Final = half_window(params.energy_window_s, period_s)
        self.moving = False
        self._mean = CentredMean(self.lag)
        self._weight = params.force_weight_radps_mps2
        self._ratio: Final = params.valley_ratio
        self._split: Final = params.valley_split_ratio
        self._leave: Final = params.valley_end_ratio
        self._floor: Final = params.standing_rate_radps**2
        self._ceiling: Final = params.quiet_rate_max_radps**2
        self._index = -1
        self._extreme = math.inf
        self._bump = 0.0
        self._valley: list[float] = []
        self._first = 0
        self._still_since = 0

    @property
    def index(self) -> int:
        """Return the number of the last sample whose energy is known."""
        return self._index

    @property
    def quiet_since(self) -> int:
        """Return since which sample it has been as quiet as standing; one ahead when it is not."""
        return self._still_since

    def push(self, accel: Iterable[float], gyro: Iterable[float]) -> Quiet | None:
        """Take the next sample; return the valley that is over with it, if one is."""
        fx, fy, fz = accel
        wx, wy, wz = gyro
        force = self._weight * (math.sqrt(fx * fx + fy * fy + fz * fz) - STANDARD_GRAVITY_MPS2)
        energy = self._mean.push(wx * wx + wy * wy + wz * wz + force * force)
        return None if energy is None else self._follow(energy)

    def finish(self) -> None:
        """Take what the window still holds, at the end of the stream."""
        for energy in self._mean.finish():
            self._follow(energy)

    def _follow(self, energy: float) -> Quiet | None:
        self._index += 1
        if energy > self._floor:
            self._still_since = self._index + 1
        if self.moving:
            self._descend(energy)
            return None
        self._valley.append(energy)
        lowest = max(self._extreme, self._floor)
        if energy < self._extreme:
            self._extreme = self._bump = energy
            return None
        self._bump = max(self._bump, energy)
        if energy > self._leave * lowest:
            return self._leave_valley(energy, moving=True)
        if self._bump > self._split * lowest and energy < self._bump / self._ratio:
            return self._leave_valley(energy, moving=False)
        return None

    def _leave_valley(self, energy: float, *, moving: bool) -> Quiet:
        """Return the valley that is over; on a peak now, or past a small one in the next valley."""
        quiet = self._quiet_part()
        self.moving, self._extreme, self._bump = moving, energy, energy
        self._first = self._index
        self._valley = [] if moving else [energy]
        return quiet

    def _descend(self, energy: float) -> None:
        self._extreme = max(self._extreme, energy)
        if energy < self._extreme / self._ratio and energy < self._ceiling:
            self.moving = False
            self._first, self._extreme, self._bump = self._index, energy, energy
            self._valley = [energy]

    def _quiet_part(self) -> Quiet:
        """Return the run about the minimum that is hardly less quiet."""
        begin, end = self._below(_QUIET_RATIO)
        return Quiet(begin, end, self._below(self._leave), self._extreme)

    def _below(self, ratio: float) -> tuple[int, int]:
        """Return first and last sample about the minimum below so many times its energy."""
        begin = end = self._valley.index(self._extreme)
        limit = max(ratio * self._extreme, self._floor)
        while begin > 0 and self._valley[begin - 1] <= limit:
            begin -= 1
        while end + 1 < len(self._valley) and self._valley[end + 1] <= limit:
            end += 1
        return self._first + begin, self._first + end
