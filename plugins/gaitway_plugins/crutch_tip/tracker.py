"""What follows the pitch of a crutch."""

from typing import NamedTuple, Protocol

from gaitway.api import Floats
from gaitway_plugins.crutch_tip.stream import Rows


class Settled(NamedTuple):
    """Pitches that won't change any more.

    Attributes:
        pitch_rad: Shape (n,).
        sigma_rad: Shape (n,).
    """

    pitch_rad: Floats
    sigma_rad: Floats


class Tracker(Protocol):
    """Follows the pitch of one unbroken stretch of samples; indexes count from its beginning."""

    def extend(self, rows: Rows) -> None:
        """Go on by samples."""
        ...

    def loaded(self, index: int) -> None:
        """Take that the crutch is loaded since a sample."""
        ...

    def relieved(self, index: int) -> None:
        """Take that it is not any more since a sample."""
        ...

    def pitch(self, index: int) -> tuple[float, float]:
        """Return the pitch where the load changed before a sample, and its standard deviation."""
        ...

    def settle(self, *, all_of_them: bool = False) -> Settled:
        """Return the pitches that won't change any more, each once, in order."""
        ...

    def broken(self, duration_s: float) -> None:
        """Take that samples are missing; indexes begin at 0 again."""
        ...
