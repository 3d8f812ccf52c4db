"""From contact to contact: when the cane is lifted, when it lands, and how far from there."""

from bisect import bisect_left
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum, auto
from typing import Final

import numpy as np
from numpy.typing import NDArray

from gaitway.api import Floats
from gaitway.estimation import ImuBlock, tilts_from_gravity_rad
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
        tilt_rad: Of the shaft, where the way is known.
    """

    index: int
    way: Displacement | None = None
    seen: bool = True
    as_before: bool = False
    tilt_rad: float = 0.0


Record = Lift | Clip | Landing


@dataclass(frozen=True, slots=True)
class Told:
    """A record, and the sample at which it became known.

    Attributes:
        known: Number of that sample.
        record: What happened.
    """

    known: int
    record: Record


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
    ends: until then its zero velocities correct the way behind them. Between such moments samples
    are navigated in one go.

    Args:
        navigator: Of the cane.
        half: Half a quiet window, samples.
        every: From one zero velocity to the next within a stance, samples.
        settle: Samples.
        least: Shortest quiet time of a contact, samples.
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
        least: int,
        max_swing: int,
        stood: bool,
    ) -> None:
        self._navigator = navigator
        self._half: Final = half
        self._every: Final = every
        self._settle: Final = settle
        self._least: Final = least
        self._max_swing: Final = max_swing
        self._first = 0
        self._lift_index = 0
        self._contact_index = 0
        self._stood_index = 0
        self._landing_open = False
        self._since_landing: list[ImuBlock] = []
        self._clipped = False
        self._accel_sum_d = np.zeros(3)
        self.phase = Phase.RESUMING if stood else Phase.SEEKING
        self.records: deque[Told] = deque()

    def extend(self, block: ImuBlock, quiet: NDArray[np.bool_]) -> Floats:
        """Take samples, and which are the middle of a quiet window.

        Returns:
            The navigated tilt of the shaft at each, radians, that of the specific force where
            nothing is navigated, shape (n,).
        """
        poses = np.full((len(block), 10), np.nan)
        loud, calm = np.flatnonzero(~quiet).tolist(), np.flatnonzero(quiet).tolist()
        row = 0
        while row < len(block):
            if self.phase is Phase.STANDING:
                row = self._stand(block, row, _first_from(loud, row, len(block)), poses)
            elif self.phase is Phase.SWINGING:
                row = self._swing(block, row, _first_from(calm, row, len(block)), poses)
            else:
                self._wait(block, row, bool(quiet[row]))
                row += 1
        self._first += len(block)
        w, x, y, z = poses[:, 6:].T
        tilt_rad = 2.0 * np.arctan2(np.sqrt(x * x + y * y), np.sqrt(w * w + z * z))
        return np.where(np.isnan(w), tilts_from_gravity_rad(block.accel_d), tilt_rad)

    def close(self) -> None:
        """Take the way of the last placement as it is known now: no more samples will come."""
        self._close(self._first - 1)

    def _close(self, index: int) -> None:
        if self._landing_open:
            self._landing_open = False
            self._since_landing.clear()
            way, tilt_rad = self._navigator.displacement(), self._navigator.tilt_rad()
            self._tell(index, Landing(self._floor_index(), way, tilt_rad=tilt_rad))

    def _tell(self, index: int, record: Record) -> None:
        self.records.append(Told(index, record))

    def _floor_index(self) -> int:
        """Return the first sample of the quiet window of the last contact."""
        return max(self._contact_index - self._half, self._lift_index)

    def _wait(self, block: ImuBlock, row: int, quiet: bool) -> None:
        """Look at a sample while nothing is navigated."""
        index = self._first + row
        if self.phase is Phase.SEEKING:
            if self._navigator.seek(block.sample(row)) and quiet:
                self._found(index, as_before=False)
            return
        self._accel_sum_d += block.accel_d[row]
        if index < self._half:
            return
        if quiet and self._navigator.resume(self._accel_sum_d / (self._half + 1)):
            self._found(index, as_before=True)
        else:
            self._navigator.lose()
            self.phase = Phase.SEEKING

    def _found(self, index: int, *, as_before: bool) -> None:
        self.phase = Phase.STANDING
        self._stood_index = index
        self._tell(index, Landing(index, seen=False, as_before=as_before))

    def _stand(self, block: ImuBlock, row: int, loud: int, poses: Floats) -> int:
        """Go on in a stance to its next zero velocity or its end; return the row after."""
        if row == loud:
            index = self._first + row
            if self._landing_open and index - self._contact_index < self._least:
                self._take_back()
            else:
                self._lift(index, index - 1 + self._half)
            return row
        stop = min(loud, self._stood_index + self._every - self._first + 1)
        if stop > row:
            self._navigator.move(block[row:stop], poses[row:stop])
            if self._landing_open:
                self._since_landing.append(block[row:stop])
        index = self._first + stop - 1
        if index - self._stood_index < self._every:
            return stop
        if not self._navigator.stand(block.sample(stop - 1), landing=False):
            self._leave(index)
            return stop
        self._stood_index = index
        if index - self._contact_index >= self._settle:
            self._close(index)
        return stop

    def _leave(self, index: int) -> None:
        """Swing again: the cane moves although its window is quiet."""
        if not self._landing_open:
            self._lift(index, index)
            return
        self._take_back()

    def _take_back(self) -> None:
        """Go on with the swing: it never stood.

        A swing that slows down smoothly looks like a contact before its end, a waving hand like one
        where it turns.
        """
        self._navigator.unland(self._since_landing)
        self._since_landing.clear()
        self._landing_open = False
        self.phase = Phase.SWINGING

    def _lift(self, index: int, last_on_floor: int) -> None:
        self._close(index)
        self._navigator.mark()
        self._lift_index = last_on_floor
        self._clipped = False
        self._tell(index, Lift(last_on_floor))
        self.phase = Phase.SWINGING

    def _swing(self, block: ImuBlock, row: int, calm: int, poses: Floats) -> int:
        """Go on in the air to the next quiet sample or too far; return the row after."""
        too_far = self._lift_index + self._max_swing + 1 - self._first
        stop = min(calm + 1, max(too_far, row) + 1, len(block))
        self._navigator.move(block[row:stop], poses[row:stop])
        if not self._clipped and block.clipped[row:stop].any():
            self._clipped = True
            at = self._first + row + int(np.argmax(block.clipped[row:stop]))
            self._tell(at, Clip(at))
        index = self._first + stop - 1
        if index - self._lift_index > self._max_swing:
            self._navigator.lose()
            self.phase = Phase.SEEKING
        elif stop == calm + 1 and self._navigator.stand(block.sample(calm), landing=True):
            self._contact_index = self._stood_index = index
            self._landing_open = True
            self.phase = Phase.STANDING
        return stop


def _first_from(rows: Sequence[int], row: int, otherwise: int) -> int:
    """Return the first of ascending rows that is not before ``row``."""
    at = bisect_left(rows, row)
    return rows[at] if at < len(rows) else otherwise
