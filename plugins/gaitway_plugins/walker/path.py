"""The path as poses: from the origin, along the direction of the first step."""

import math
from typing import Final

import numpy as np

from gaitway.api import Floats, Pose
from gaitway_plugins.walker.pieces import Piece

_QUARTER: Final = np.array([[0.0, -1.0], [1.0, 0.0]])


class Path:
    """Adds up the ways of the pieces, with what is uncertain in them.

    A heading that is wrong turns the whole way after it, so its share is summed before it is
    squared; what is uncertain in a length is its own.

    Args:
        shared_sigma: Relative standard deviation common to all lengths.
    """

    def __init__(self, shared_sigma: float) -> None:
        self._shared_sigma: Final = shared_sigma
        self._since_ns: int | None = None
        self._ahead_rad = 0.0
        self._pos_n = np.zeros(2)
        self._own = np.zeros((2, 2))
        self._by_heading = np.zeros(2)

    @property
    def net_m(self) -> float:
        """How far the end is from the origin."""
        return float(np.hypot(*self._pos_n))

    def add(self, piece: Piece) -> None:
        """Go on by a piece."""
        if self._since_ns is None:
            self._since_ns = piece.start_ns
            forward = math.copysign(1.0, piece.length_m)
            self._ahead_rad = math.atan2(*(forward * piece.way_n[::-1]).tolist())
        self._pos_n = self._pos_n + piece.way_n
        self._own = self._own + np.eye(2) * piece.sigma_m**2
        self._by_heading = self._by_heading + piece.heading_sigma_rad * (_QUARTER @ piece.way_n)

    def restart(self) -> None:
        """Begin a new path with the next piece: where this one went is lost."""
        self.__init__(self._shared_sigma)  # type: ignore[misc]

    def pose(self, t_ns: int, heading_rad: float, heading_sigma_rad: float) -> Pose:
        """Return where the walker is."""
        c, s = math.cos(self._ahead_rad), math.sin(self._ahead_rad)
        C: Floats = np.array([[c, s], [-s, c]])
        scale = self._shared_sigma * self._pos_n
        of_n = self._own + np.outer(self._by_heading, self._by_heading) + np.outer(scale, scale)
        x_m, y_m = (C @ self._pos_n).tolist()
        var = np.diag(C @ of_n @ C.T)
        turned = heading_rad - self._ahead_rad
        return Pose(
            t_ns=t_ns,
            since_t_ns=t_ns if self._since_ns is None else self._since_ns,
            pos_x_m=x_m,
            pos_x_sigma_m=math.sqrt(var[0]),
            pos_y_m=y_m,
            pos_y_sigma_m=math.sqrt(var[1]),
            heading_rad=(turned + math.pi) % (2.0 * math.pi) - math.pi,
            heading_sigma_rad=heading_sigma_rad,
        )
