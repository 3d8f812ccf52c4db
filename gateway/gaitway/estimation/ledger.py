"""The running account of a walk: strides in; stride, distance and bout events out.

Every device keeps the same books, so that ``distance_m`` means the same for a cane and a shank.
"""

import math
from typing import Final

from gaitway.events import Anomaly, Bout, Distance, Event, Stride
from gaitway.timebase import NS_PER_S

SECONDS_PER_MINUTE: Final = 60.0
UNTRUSTED_M: Final = 2.0
UNTRUSTED_SHARE: Final = 0.5
"""A distance with a larger standard deviation, in metres and as a share, is of no use."""


class WalkLedger:
    """Sums strides into distance and bouts, with their standard deviations.

    The variance of a sum has three parts: that of each stride, independent of the others; what all
    strides share (scale of the sensor, alignment), which grows with the distance itself; and what
    went unseen. Walking faster than ``unseen_speed_mps`` unseen is not expected, so a time unseen
    adds that distance as one standard deviation.

    Args:
        max_pause_s: A longer pause between strides ends the bout.
        shared_sigma: Relative standard deviation common to all strides, unless a stride has its
            own.
        stride_time_sigma_s: Standard deviation of one contact time.
        unseen_speed_mps: Plausible speed during time that gave no measure.
    """

    def __init__(
        self,
        *,
        max_pause_s: float,
        shared_sigma: float,
        stride_time_sigma_s: float,
        unseen_speed_mps: float = 0.5,
    ) -> None:
        self._max_pause_ns = round(max_pause_s * NS_PER_S)
        self._shared_sigma = shared_sigma
        self._stride_time_sigma_s = stride_time_sigma_s
        self._unseen_speed_mps = unseen_speed_mps
        self._since_t_ns: int | None = None
        self._distance_m = 0.0
        self._shared_m = 0.0
        self._own_variance_m2 = 0.0
        self._unseen_variance_m2 = 0.0
        self._strides = 0
        self._walking_ns = 0
        self._unmeasured_s = 0.0
        self._stretch_s = 0.0
        self._untrusted = False
        self._bout_start_ns: int | None = None
        self._bout_end_ns = 0
        self._bout_strides = 0
        self._bout_distance_m = 0.0
        self._bout_variance_m2 = 0.0
        self._bout_shared_m = 0.0

    @property
    def in_bout(self) -> bool:
        """Whether a bout is going on."""
        return self._bout_start_ns is not None

    @property
    def bout_end_ns(self) -> int:
        """Return when the last stride of the present bout ended."""
        return self._bout_end_ns

    def begin(self, t_ns: int) -> None:
        """Set when counting began; the first call counts."""
        if self._since_t_ns is None:
            self._since_t_ns = t_ns

    def add_stride(
        self,
        start_t_ns: int,
        t_ns: int,
        stride_length_m: float,
        stride_length_sigma_m: float,
        *,
        stance_duration_s: float | None = None,
        swing_duration_s: float | None = None,
        shared_sigma: float | None = None,
        interpolated: bool = False,
    ) -> list[Event]:
        """Count a stride; return what it makes known, in the order of time.

        Args:
            start_t_ns: Where the cycle began.
            t_ns: Where it ended, later than start_t_ns.
            stride_length_m: Its length.
            stride_length_sigma_m: Standard deviation of its length, without what all strides share.
            stance_duration_s: Time on the ground within the cycle.
            swing_duration_s: Time in the air within the cycle.
            shared_sigma: Relative standard deviation that this length shares with all others.
            interpolated: It was not measured.
        """
        self.begin(start_t_ns)
        events = self.advance(start_t_ns)
        if self._bout_start_ns is None:
            self._open_bout(start_t_ns)
            events.append(Bout(t_ns=start_t_ns, phase="start", start_t_ns=start_t_ns))
        shared_m = stride_length_m * (self._shared_sigma if shared_sigma is None else shared_sigma)
        self._shared_m += shared_m
        self._bout_shared_m += shared_m
        variance_m2 = stride_length_sigma_m**2
        self._distance_m += stride_length_m
        self._own_variance_m2 += variance_m2
        self._strides += 1
        self._walking_ns += t_ns - self._bout_end_ns
        self._bout_end_ns = t_ns
        self._bout_strides += 1
        self._bout_distance_m += stride_length_m
        self._bout_variance_m2 += variance_m2
        duration_s = (t_ns - start_t_ns) / NS_PER_S
        duration_sigma_s = math.sqrt(2.0) * self._stride_time_sigma_s
        speed_mps = stride_length_m / duration_s
        length_sigma_m = math.hypot(stride_length_sigma_m, shared_m)
        events.append(
            Stride(
                t_ns=t_ns,
                start_t_ns=start_t_ns,
                stride_length_m=stride_length_m,
                stride_length_sigma_m=length_sigma_m,
                stride_duration_s=duration_s,
                stride_duration_sigma_s=duration_sigma_s,
                walking_speed_mps=speed_mps,
                walking_speed_sigma_mps=math.hypot(
                    length_sigma_m / duration_s, speed_mps * duration_sigma_s / duration_s
                ),
                stance_duration_s=stance_duration_s,
                stance_duration_sigma_s=None if stance_duration_s is None else duration_sigma_s,
                swing_duration_s=swing_duration_s,
                swing_duration_sigma_s=None if swing_duration_s is None else duration_sigma_s,
                lift_t_ns=None
                if stance_duration_s is None
                else start_t_ns + round(stance_duration_s * NS_PER_S),
                interpolated=interpolated,
            )
        )
        distance = self.distance(t_ns)
        return [*events, distance, *self._doubts(distance)]

    def add_unmeasured(
        self, duration_s: float, *, speed_sigma_mps: float | None = None, ongoing: bool = False
    ) -> None:
        """Count time that may have been walking but gave no measure; sigma grows, distance not.

        Args:
            duration_s: How long.
            speed_sigma_mps: How fast that may have been; ``unseen_speed_mps`` where None, 0 where
                strides with a sigma of their own are counted for it.
            ongoing: It goes on with the time of the call before, so that the two are one.
        """
        speed_mps = self._unseen_speed_mps if speed_sigma_mps is None else speed_sigma_mps
        self._unmeasured_s += duration_s
        before_s = self._stretch_s if ongoing else 0.0
        self._stretch_s = before_s + duration_s
        self._unseen_variance_m2 += (self._stretch_s**2 - before_s**2) * speed_mps**2

    def advance(self, t_ns: int) -> list[Event]:
        """Let time pass up to t_ns; return the end of the bout when the pause grew too long."""
        if self._bout_start_ns is None or t_ns - self._bout_end_ns <= self._max_pause_ns:
            return []
        return self.close_bout()

    def close_bout(self) -> list[Event]:
        """End the present bout at its last stride; nothing when there is none."""
        if self._bout_start_ns is None:
            return []
        start_t_ns, self._bout_start_ns = self._bout_start_ns, None
        duration_s = (self._bout_end_ns - start_t_ns) / NS_PER_S
        duration_sigma_s = math.sqrt(2.0) * self._stride_time_sigma_s
        distance_sigma_m = math.hypot(self._bout_shared_m, math.sqrt(self._bout_variance_m2))
        speed_mps = self._bout_distance_m / duration_s
        cadence_spm = SECONDS_PER_MINUTE * self._bout_strides / duration_s
        return [
            Bout(
                t_ns=self._bout_end_ns,
                phase="end",
                start_t_ns=start_t_ns,
                duration_s=duration_s,
                duration_sigma_s=duration_sigma_s,
                strides=self._bout_strides,
                distance_m=self._bout_distance_m,
                distance_sigma_m=distance_sigma_m,
                walking_speed_mps=speed_mps,
                walking_speed_sigma_mps=math.hypot(
                    distance_sigma_m / duration_s, speed_mps * duration_sigma_s / duration_s
                ),
                cadence_spm=cadence_spm,
                cadence_sigma_spm=cadence_spm * duration_sigma_s / duration_s,
            )
        ]

    def distance(self, t_ns: int) -> Distance:
        """Return the running distance as of t_ns."""
        self.begin(t_ns)
        assert self._since_t_ns is not None
        variance_m2 = self._own_variance_m2 + self._unseen_variance_m2
        return Distance(
            t_ns=t_ns,
            since_t_ns=self._since_t_ns,
            distance_m=self._distance_m,
            distance_sigma_m=math.hypot(self._shared_m, math.sqrt(variance_m2)),
            strides=self._strides,
            walking_s=self._walking_ns / NS_PER_S,
            unmeasured_s=self._unmeasured_s,
        )

    def _doubts(self, distance: Distance) -> list[Event]:
        """Say once when the distance is no longer known well enough to be of use."""
        limit_m = max(UNTRUSTED_M, UNTRUSTED_SHARE * distance.distance_m)
        before, self._untrusted = self._untrusted, distance.distance_sigma_m > limit_m
        if before or not self._untrusted:
            return []
        detail = (
            f"{distance.unmeasured_s:.0f} s of possible walking gave no measure: the distance is "
            f"{distance.distance_m:.1f} +- {distance.distance_sigma_m:.1f} m; strides and bouts "
            "are as good as ever"
        )
        return [Anomaly(t_ns=distance.t_ns, anomaly="distance-untrusted", detail=detail)]

    def _open_bout(self, start_t_ns: int) -> None:
        self._bout_start_ns = start_t_ns
        self._bout_end_ns = start_t_ns
        self._bout_strides = 0
        self._bout_distance_m = 0.0
        self._bout_variance_m2 = 0.0
        self._bout_shared_m = 0.0
