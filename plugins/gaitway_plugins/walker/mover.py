"""From fixes to pieces: standing, rolling, in the air."""

from gaitway_plugins.walker.fix import Fix
from gaitway_plugins.walker.params import WalkerParams
from gaitway_plugins.walker.pieces import Flight, Piece, Roll


class Mover:
    """Follows the walker from standing to standing.

    Args:
        params: Of the walker.
    """

    def __init__(self, params: WalkerParams) -> None:
        self._params = params
        self._before: Fix | None = None
        self._roll: Roll | None = None
        self._flight: Flight | None = None
        self._rest_pitch_rad: float | None = None

    @property
    def phase(self) -> str:
        """``stand``, ``roll`` or ``air``."""
        return "roll" if self._roll is not None else "air" if self._flight is not None else "stand"

    @property
    def carried(self) -> bool:
        """Whether it is in the air for longer than a step, told once."""
        flight = self._flight
        if flight is None or flight.told or flight.duration_s <= self._params.max_lift_s:
            return False
        flight.told = True
        return flight.lifted

    def push(self, fix: Fix) -> list[Piece]:
        """Take the next fix; return the pieces that are now known."""
        before, self._before = self._before or fix, fix
        if fix.still:
            self._rest_pitch_rad = fix.pitch_rad
        if self._roll is not None:
            return self._rolling(self._roll, fix)
        if self._flight is not None:
            return self._flying(self._flight, before, fix)
        self._leave(before, fix)
        return []

    def finish(self) -> list[Piece]:
        """Return what the end of the stream decides."""
        pieces = [] if self._roll is None else [self._roll.finish()]
        if self._flight is not None and self._flight.settled:
            pieces += _one(self._flight.finish())
        self._roll = self._flight = None
        return pieces

    def _leave(self, before: Fix, fix: Fix) -> None:
        if fix.rolling:
            self._roll = Roll(self._params, before, self._rest_pitch_rad)
            self._roll.push(fix)
        elif not fix.still:
            self._flight = Flight(self._params, before)
            self._flight.push(fix)

    def _rolling(self, roll: Roll, fix: Fix) -> list[Piece]:
        pieces = roll.push(fix)
        if roll.stopped_s < self._params.stop_s - 1e-6:
            return pieces
        self._roll = None
        if not fix.still:
            self._flight = Flight(self._params, fix)
        return [*pieces, roll.finish()]

    def _flying(self, flight: Flight, before: Fix, fix: Fix) -> list[Piece]:
        if fix.rolling:
            self._flight = None
            self._leave(before, fix)
            return _one(flight.finish())
        if flight.paused and not fix.still:
            self._flight = Flight(self._params, before)
            self._flight.push(fix)
            return _one(flight.finish())
        flight.push(fix)
        if not flight.settled:
            return []
        self._flight = None
        return _one(flight.finish())


def _one(piece: Piece | None) -> list[Piece]:
    return [] if piece is None else [piece]
