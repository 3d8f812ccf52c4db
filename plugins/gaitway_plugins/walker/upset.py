"""A walker that fell, or was borne off, makes no steps until it is somebody's walker again."""

import math
from typing import Final

import numpy as np

from gaitway.api import NS_PER_S
from gaitway_plugins.walker.blocks import Block
from gaitway_plugins.walker.fix import Fix
from gaitway_plugins.walker.params import WalkerParams
from gaitway_plugins.walker.pieces import Piece

FALL_MPS2: Final = 3.0
"""A mean force over a block below this is falling."""
TIPPED: Final = math.cos(math.radians(45.0))
"""At rest, an upright share of the force below this is lying."""
_FALLS_S: Final = 0.2
"""Lifts that are set down quickly fall for a shorter time; so long is 0.2 m."""
_STANDS_S: Final = 1.0
_ROLLS_S: Final = 0.5
"""Nobody rolls a walker that lies or is borne: wheels that turn so long settle it, too."""


class Upset:
    """Follows whether the walker was upset.

    A fall, lying on the side and being carried upset it, and so does a way in the air that is
    longer than any step for certain: a car, a lift, somebody's arm. What moves it then, or sets it
    up again, can look like a lift at any moment, so nothing counts before it has stood, upright,
    for a second, or rolled for half a one.

    Args:
        params: Of the walker.
    """

    def __init__(self, params: WalkerParams) -> None:
        self._params: Final = params
        self._upright = False
        self._upset = False
        self._told = False
        self._falls_s = self._stands_s = self._rolls_s = 0.0

    def push(self, block: Block, fix: Fix) -> None:
        """Take the next block and its fix."""
        force = block.accel_d.mean(axis=0)
        size = float(np.sqrt(force.dot(force)))
        # Only where it rests is the force the vertical: setting down hard feels like lying.
        lies = fix.still and float(force[2]) < TIPPED * size
        self._upright |= fix.still and not lies
        if not self._upright:
            return
        self._falls_s = self._falls_s + fix.duration_s if size < FALL_MPS2 else 0.0
        self._stands_s = self._stands_s + fix.duration_s if fix.still else 0.0
        self._rolls_s = self._rolls_s + fix.duration_s if fix.rolling else 0.0
        if lies or self._falls_s >= _FALLS_S - 1e-6:
            self._upset, self._stands_s = True, 0.0
        elif self._stands_s >= _STANDS_S - 1e-6 or self._rolls_s >= _ROLLS_S - 1e-6:
            self._upset = self._told = False

    def tell(self) -> bool:
        """Return whether this is still to be said since it was upset: once."""
        before, self._told = self._told, True
        return not before

    def refuses(self, piece: Piece) -> bool:
        """Take the next piece; return whether it is no part of a walk."""
        far_m = abs(piece.length_m) - 3.0 * piece.sigma_m
        gone = piece.kind == "lost" and far_m > self._params.max_step_m
        lasting_s = (piece.t_ns - piece.start_ns) / NS_PER_S
        # A shorter one that only seems to have ended elsewhere may be a lift across a gap.
        carried = piece.kind == "carried" and lasting_s > self._params.max_lift_s
        self._upset |= carried or gone
        # By the paper, lifts go astray all the time.
        return self._upset and self._params.method != "published" and piece.kind in ("roll", "lift")
