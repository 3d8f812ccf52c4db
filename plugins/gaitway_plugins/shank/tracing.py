"""Per-sample estimates of the shank, for files and plots."""

import numpy as np

from gaitway.api import Floats, Trace
from gaitway_plugins.shank.stride import Way
from gaitway_plugins.shank.track import Track


class Tracer:
    """Writes each sample once, when its stride is known, or in standing when it is let go.

    Attributes:
        trace: What is written. ``pos_x_m`` runs along the way of each stride, ``pitch_rad`` is the
            lean of the shank, forward positive, ``stance`` 1 on the floor.
    """

    def __init__(self) -> None:
        self.trace = Trace("pos_x_m", "pos_z_m", "vel_x_mps", "pitch_rad", "stance")
        self._pos_x_m = 0.0
        self._up_c: Floats = np.full(3, np.nan)

    def hold(self, track: Track, begin: int, end: int) -> None:
        """Write the samples from ``begin`` up to ``end``, that one not, as standing."""
        if end > begin:
            rest = np.zeros(end - begin)
            self._write(track, begin, rest, rest, rest, rest + 1.0)

    def way(self, track: Track, begin: int, way: Way, toe_off: int, contact: int) -> None:
        """Write the samples of a stride that begins at ``begin``, the last one not."""
        self._up_c = way.C_nc[2]
        forward_m = way.pos_n[:-1, :2] @ way.direction
        index = begin + np.arange(len(forward_m))
        stance = np.where((index >= toe_off) & (index < contact), 0.0, 1.0)
        speed_mps = way.vel_n[:-1, :2] @ way.direction
        self._write(track, begin, forward_m, way.pos_n[:-1, 2], speed_mps, stance)
        self._pos_x_m += way.length_m

    def _write(
        self, track: Track, begin: int, forward_m: Floats, up_m: Floats, speed_mps: Floats,
        stance: Floats,
    ) -> None:  # fmt: skip
        w, x, y, z = track.attitudes(begin, begin + len(stance) - 1).T
        ahead_c = (1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y + w * z), 2.0 * (x * z - w * y))
        pitch_rad = -np.arcsin(np.clip(self._up_c @ np.stack(ahead_c), -1.0, 1.0))
        columns = [self._pos_x_m + forward_m, up_m, speed_mps, pitch_rad, stance]
        for offset, row in enumerate(np.stack(columns, axis=1).tolist()):
            self.trace.append(track.t_ns(begin + offset), *row)
