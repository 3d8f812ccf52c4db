"""From contact to contact: when the cane is lifted, when it lands, and how far from there."""

from collections import deque
from dataclasses import dataclass
from enum import Enum, auto
from typing import Final

import numpy as np

from gaitway.estimation import ImuSample
from gaitway_plugins.quad_cane.navigator import Displacement, Navigator


@dataclass(frozen=True, slots=True)
class Lift:
    """The cane leaves the floor.

    Attributes:
        index: Number of the last sample on the floor.
    """

    index: int


@dataclass(frozen=True, slots=True)
class Clip:
    """For the first time in this swing an axis of the sensor is at the end of its range.

    Attributes:
        index: Number of the sample.
    """

    index: int


@dataclass(frozen=True, slots=True)
class Landing:
    """The cane stands.

    Attributes:
        index: Number of the first sample on the floor, or of that which told that it stands.
        way: From the stance before; None where it could not be measured.
        seen: The contact itself was seen.
        as_before: After missing samples: it stands as it stood before them.
    """

    index: int
    way: Displacement | None = None
    seen: bool = True
    as_before: bool = False


Record = Lift | Clip | Landing


class Phase(Enum):
    """What the cane does, as far as it is known."""

    SEEKING = auto()
    """Attitude or velocity unknown: waiting for a rest."""
    RESUMING = auto()
    """It stood when samples went missing: does it still?"""
    STANDING = auto()
    """On the floor, velocity zero."""
    SWINGING = auto()
    """In the air since the last stance, navigated."""


class Placements:
    """Cuts the navigation of a cane into placements.

    A quiet window is on the floor as a whole, but only its middle is taken for zero velocity. The
    way of a placement is taken when the stance that ends it has lasted ``settle`` samples, or
    ends: until then its zero velocities correct the way behind them.

    Args:
        navigator: Of the cane.
        half: Half a quiet window, samples.
        every: From one zero velocity to the next within a stance, samples.
        settle: Samples.
        max_swing: Longest swing that is navigated, samples.
        stood: The cane stood when the samples before these ended.

    Attributes:
        phase: Of the last sample.
        records: What happened, in order; the owner takes from the left.
    """

    def __init__(
        self,
        navigator: Navigator,
        *,
        half: int,
        every: int,
        settle: int,
        max_swing: int,
        stood: bool,
    ) -> None:
        self._navigator = navigator
        self._half: Final = half
        self._every: Final = every
        self._settle: Final = settle
        self._max_swing: Final = max_swing
        self._index = -1
        self._lift_index = 0
        self._contact_index = 0
        self._stood_index = 0
        self._landing_open = False
        self._since_landing: list[ImuSample] = []
        self._clipped = False
        self._accel_sum_d = np.zeros(3)
        self.phase = Phase.RESUMING if stood else Phase.SEEKING
        self.records: deque[Record] = deque()

    def push(self, sample: ImuSample, quiet: bool) -> None:
        """Take the next sample and whether it is the middle of a quiet window."""
        self._index += 1
        if self.phase is Phase.SEEKING:
            self._seek(sample, quiet)
        elif self.phase is Phase.RESUMING:
            self._resume(sample, quiet)
        elif self.phase is Phase.STANDING:
            self._stand(sample, quiet)
        else:
            self._swing(sample, quiet)

    def close(self) -> None:
        """Take the way of the last placement as it is known now: no more samples will come."""
        if self._landing_open:
            self._landing_open = False
            self._since_landing.clear()
            self.records.append(Landing(self._floor_index(), self._navigator.displacement()))

    def _floor_index(self) -> int:
        """Return the first sample of the quiet window of the last contact."""
        return max(self._contact_index - self._half, self._lift_index)

    def _seek(self, sample: ImuSample, quiet: bool) -> None:
        if self._navigator.seek(sample) and quiet:
            self.phase = Phase.STANDING
            self._stood_index = self._index
            self.records.append(Landing(self._index, seen=False))

    def _resume(self, sample: ImuSample, quiet: bool) -> None:
        self._accel_sum_d += sample.accel_d
        if self._index < self._half:
            return
        if quiet and self._navigator.resume(self._accel_sum_d / (self._half + 1)):
            self.phase = Phase.STANDING
            self._stood_index = self._index
            self.records.append(Landing(self._index, seen=False, as_before=True))
        else:
            self._navigator.lose()
            self.phase = Phase.SEEKING

    def _stand(self, sample: ImuSample, quiet: bool) -> None:
        if not quiet:
            self._lift(self._index - 1 + self._half)
            self._swing(sample, quiet)
            return
        self._navigator.move(sample)
        if self._landing_open:
            self._since_landing.append(sample)
        if self._index - self._stood_index < self._every:
            return
        if not self._navigator.stand(sample, landing=False):
            self._leave()
            return
        self._stood_index = self._index
        if self._index - self._contact_index >= self._settle:
            self.close()

    def _leave(self) -> None:
        """Swing again: the cane moves although its window is quiet."""
        if not self._landing_open:
            self._lift(self._index)
            return
        # It never stood: a swing that slows down smoothly looks like a contact before its end.
        self._navigator.unland(self._since_landing)
        self._since_landing.clear()
        self._landing_open = False
        self.phase = Phase.SWINGING

    def _lift(self, index: int) -> None:
        self.close()
        self._navigator.mark()
        self._lift_index = index
        self._clipped = False
        self.records.append(Lift(index))
        self.phase = Phase.SWINGING

    def _swing(self, sample: ImuSample, quiet: bool) -> None:
        self._navigator.move(sample)
        if sample.clipped and not self._clipped:
            self._clipped = True
            self.records.append(Clip(self._index))
        if self._index - self._lift_index > self._max_swing:
            self._navigator.lose()
            self.phase = Phase.SEEKING
        elif quiet and self._navigator.stand(sample, landing=True):
            self._contact_index = self._stood_index = self._index
            self._landing_open = True
            self.phase = Phase.STANDING
