"""From contact to contact: when the tip is lifted, when it lands, and how far from there."""

import math
from collections import deque
from dataclasses import dataclass
from enum import Enum, auto
from typing import Final

import numpy as np

from gaitway.api import Floats
from gaitway.estimation import STANDARD_GRAVITY_MPS2
from gaitway_plugins.standard_cane.navigator import Navigator, Way
from gaitway_plugins.standard_cane.tip import TipRow


@dataclass(frozen=True, slots=True)
class Lift:
    """The tip leaves the floor.

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
    """The tip stands.

    Attributes:
        index: Number of the first sample on the floor, or of that which told that it stands.
        way: From the stance before; None where it could not be measured.
    """

    index: int
    way: Way | None = None


@dataclass(frozen=True, slots=True)
class Lost:
    """A swing did not end, or its end contradicted the navigation.

    Attributes:
        index: Number of the sample.
        speed_mps: How fast the tip seems to move.
        force_mps2: Root mean square of what its specific force differed from gravity in the swing.
    """

    index: int
    speed_mps: float
    force_mps2: float


_SHAKEN_M: Final = 0.03
"""A tip that moved less between two contacts was not lifted in between."""
_STEADY_MPS2: Final = 0.7
"""A specific force in n that changes by less is that of a tip that stands."""

Record = Lift | Clip | Landing | Lost


class Phase(Enum):
    """What the cane does, as far as it is known."""

    SEEKING = auto()
    """Attitude or velocity unknown: waiting for a stance."""
    STANDING = auto()
    """The tip is on the floor, the shaft leans over it."""
    SWINGING = auto()
    """In the air since the last stance, navigated."""


@dataclass(frozen=True, slots=True)
class Timing:
    """Counts of samples.

    Attributes:
        half: Half a contact window: all of it is on the floor.
        every: From one velocity of the pendulum to the next within a stance.
        settle: After a contact its velocities still improve the way behind it.
        max_swing: Longest swing that is navigated.
        stance: A shorter one is none: the swing goes on.
        insist: So long a contact may be contradicted.
        start: Stance it takes to begin.
        resume: Stance it takes to begin when the biases are known.
    """

    half: int
    every: int
    settle: int
    max_swing: int
    stance: int
    insist: int
    start: int
    resume: int


class Placements:
    """Cuts the navigation of a cane into placements.

    Args:
        navigator: Of the cane.
        timing: Of the samples.

    Attributes:
        phase: Of the last sample.
        records: What happened, in order; the owner takes from the left.
    """

    def __init__(self, navigator: Navigator, timing: Timing) -> None:
        self._navigator: Final = navigator
        self._timing: Final = timing
        self._recent: deque[TipRow] = deque(maxlen=timing.start)
        self._index = -1
        self._run = 0
        self._lift_index = 0
        self._contact_index = 0
        self._stood_index = 0
        self._refused = 0
        self._refused_n = np.zeros(3)
        self._since_landing: list[TipRow] = []
        self._force_sum = 0.0
        self._touched: tuple[int, Floats] | None = None
        self._open = False
        self._clipped = False
        self.phase = Phase.SEEKING
        self.records: deque[Record] = deque()

    def push(self, row: TipRow, quiet: bool) -> None:
        """Take the next sample, and whether its tip may stand."""
        self._index += 1
        self._recent.append(row)
        self._run = self._run + 1 if quiet else 0
        if self.phase is Phase.SEEKING:
            self._seek()
        elif self.phase is Phase.STANDING:
            self._stand(row, quiet)
        else:
            self._swing(row, quiet)

    def close(self) -> None:
        """Take the way of the last landing as it is now known."""
        if self._open:
            self._open = False
            touched = self._contact_index - self._timing.half
            self.records.append(Landing(touched, self._navigator.way()))

    def _seek(self) -> None:
        known = self._navigator.biases_known
        needed = self._timing.resume if known else self._timing.start
        if self._run < needed or (self._run - needed) % self._timing.every:
            return
        if self._navigator.start(list(self._recent)[-needed:]):
            self._stood_index = self._contact_index = self._index
            self.phase = Phase.STANDING
            self.records.append(Landing(self._index))

    def _stand(self, row: TipRow, quiet: bool) -> None:
        self._navigator.move(row)
        if self._open:
            self._since_landing.append(row)
        if not quiet:
            self._lift()
        elif self._index - self._stood_index >= self._timing.every:
            if self._navigator.stand(row, landing=False):
                self._stood_index = self._index
            else:
                self._lift()
        if self._index - self._contact_index >= self._timing.settle:
            self.close()

    def _lift(self) -> None:
        if self._open and self._index - self._contact_index < self._timing.stance:
            self._touched = (self._contact_index, self._navigator.tip_n)
            self._open = False
            self._navigator.unland(self._since_landing)
            self.phase = Phase.SWINGING
            return
        self.close()
        self._navigator.mark()
        self._lift_index = self._index - 1
        self._clipped = False
        self._refused = 0
        self._force_sum = 0.0
        self._touched = None
        self.records.append(Lift(self._lift_index + self._timing.half))
        self.phase = Phase.SWINGING

    def _swing(self, row: TipRow, quiet: bool) -> None:
        self._navigator.move(row)
        self._force_sum += (row.force_mps2 - STANDARD_GRAVITY_MPS2) ** 2
        if row.sample.clipped and not self._clipped:
            self._clipped = True
            self.records.append(Clip(self._index))
        if self._index - self._lift_index > self._timing.max_swing:
            self._lose(row)
        elif not quiet:
            self._refused = 0
        elif self._navigator.stand(row, landing=True):
            self._navigator.on_floor()
            self._stood_index = self._index
            self._since_landing.clear()
            self._contact_index = self._first_touch()
            self._open = True
            self.phase = Phase.STANDING
        else:
            self._contradict(row)

    def _contradict(self, row: TipRow) -> None:
        """Count how long the forces say that the tip stands and the velocity that it does not.

        In the middle of a swing their length says so too; but then their direction turns. If it
        does not, it is the velocity that is wrong.
        """
        force_n = self._navigator.force_n(row)
        if not self._refused or np.abs(force_n - self._refused_n).max() > _STEADY_MPS2:
            self._refused, self._refused_n = 0, force_n
        self._refused += 1
        if self._refused > self._timing.insist:
            self._lose(row)

    def _first_touch(self) -> int:
        """Return when this stance began: it may have been shaken since."""
        if self._touched is None:
            return self._index
        index, tip_n = self._touched
        moved_m = float(np.linalg.norm(self._navigator.tip_n - tip_n))
        return index if moved_m < _SHAKEN_M else self._index

    def _lose(self, row: TipRow) -> None:
        speed_mps = float(np.linalg.norm(self._navigator.tip_velocity_n(row)))
        force_mps2 = math.sqrt(self._force_sum / max(1, self._index - self._lift_index))
        self.records.append(Lost(self._index, speed_mps, force_mps2))
        self._navigator.lose()
        self.phase = Phase.SEEKING
