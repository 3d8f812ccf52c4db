"""From ways to strides: which of them count, and what is said of those that don't."""

import math

from gaitway.api import NS_PER_S, Anomaly, Event
from gaitway.estimation import WalkLedger
from gaitway_plugins.shank.footing import Footing
from gaitway_plugins.shank.params import ShankParams
from gaitway_plugins.shank.stride import Way

_LOST_BY_CLIPPING_MPS2 = 5.0
"""By how much a clipped reading may be short, as a standard deviation."""


class Accounts:
    """Keeps the books of a shank: a stride is one way from floor to floor that is believed.

    Args:
        params: Of the shank.
    """

    def __init__(self, params: ShankParams) -> None:
        self._params = params
        self._ledger = WalkLedger(
            max_pause_s=params.max_pause_s,
            shared_sigma=params.shared_sigma,
            stride_time_sigma_s=params.stride_time_sigma_s,
        )

    @property
    def in_bout(self) -> bool:
        """Whether a walk is going on."""
        return self._ledger.in_bout

    def begin(self, t_ns: int) -> None:
        """Take the first sample; later ones change nothing."""
        self._ledger.begin(t_ns)

    def stand(self, t_ns: int) -> list[Event]:
        """Let a sample pass in which nobody walks."""
        return self._ledger.advance(t_ns) if self._ledger.in_bout else []

    def believes(self, way: Way) -> bool:
        """Return whether a way is none that only an error can make."""
        p = self._params
        return (
            way.length_m <= p.max_stride_m
            and way.tilt_step_rad <= p.max_tilt_step_rad
            and abs(way.closing_mps2) <= p.max_closing_mps2
        )

    def stride(
        self, before: Footing, after: Footing, way: Way, swing_s: float, clipped_s: float
    ) -> list[Event]:
        """Count a way that is believed, unless it is stepping on the spot.

        Args:
            before: Where it began.
            after: Where it ended.
            way: Between them.
            swing_s: Time in the air.
            clipped_s: Time in which a reading was at the end of its range.
        """
        if way.length_m < self._params.min_stride_m:
            return []
        cycle_s = (after.t_ns - before.t_ns) / NS_PER_S
        events = self._ledger.add_stride(
            before.t_ns, after.t_ns, way.length_m,
            self._sigma_m(way, cycle_s, clipped_s),
            stance_duration_s=cycle_s - swing_s, swing_duration_s=swing_s,
        )  # fmt: skip
        if not clipped_s:
            return events
        detail = f"readings at the end of their range for {clipped_s:.2f} s of this stride"
        return [*events, Anomaly(t_ns=after.t_ns, anomaly="sensor-clipped", detail=detail)]

    def unseen(self, since_ns: int, t_ns: int, anomaly: str, detail: str) -> list[Event]:
        """Count time of walking that gave no measure."""
        self._ledger.add_unmeasured((t_ns - since_ns) / NS_PER_S)
        said = Anomaly(t_ns=t_ns, anomaly=anomaly, detail=detail)
        return [said, self._ledger.distance(t_ns)]

    def finish(self) -> list[Event]:
        """Take that no more will come."""
        return self._ledger.close_bout()

    def _sigma_m(self, way: Way, cycle_s: float, clipped_s: float) -> float:
        """Return the standard deviation of a length from what is uncertain in the stride alone.

        The velocities at both ends, mean of two independent ones; a tilt step whose moment is not
        known, at worst ``g a T^2 / 24`` when it was spread over the stride; clipped readings.
        """
        velocity_m = self._params.velocity_sigma_mps * cycle_s / math.sqrt(2.0)
        tilt_m = 9.8 * way.tilt_step_rad * cycle_s**2 / 24.0
        clipped_m = _LOST_BY_CLIPPING_MPS2 * clipped_s * cycle_s / 4.0
        return math.hypot(velocity_m, tilt_m, clipped_m)
