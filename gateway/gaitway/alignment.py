"""From device time to host time: where the ``SampleBatch`` of a live device is made."""

import itertools
from bisect import bisect_right
from collections.abc import Iterable, Mapping
from typing import Any, Final

import numpy as np

from gaitway.samples import DeviceBatch, EstimatorInput, Fault, Floats, Gap, GapReason, SampleBatch
from gaitway.timebase import NS_PER_S, DeviceClock

EARLIEST_NS: Final = -NS_PER_S // 2
LATEST_NS: Final = 10 * NS_PER_S
"""A sample after a hole arrives this much later than its stamp says, or the device's clock jumped.

Backlog in drivers and radios explains a few seconds of delay; nothing explains an early one."""

OUT_OF_ORDER_NS: Final = NS_PER_S
"""A sample older than this is no late message: the device's clock began anew unannounced."""


class Aligner:
    """Puts the samples of one device on the host's clock and says which are missing.

    Holes are counted on the device's own grid. Only when its clock began anew, or says what can't
    be, is the number of missing samples estimated from host time.
    """

    def __init__(self) -> None:
        self._clock = DeviceClock()
        self._last_device_ns: int | None = None
        self._last_t_ns: int | None = None
        self._sequence = 0
        self._link_was_down = False

    @property
    def begun(self) -> bool:
        """Whether there were samples yet."""
        return self._last_t_ns is not None

    def link_opened(self) -> None:
        """Note that a link opens, so that the next hole is put down to it."""
        self._link_was_down = self._last_t_ns is not None

    def save(self) -> dict[str, Any]:
        """Return where it is, ready for JSON."""
        return {
            "clock": self._clock.save(),
            "last_device_ns": self._last_device_ns,
            "last_t_ns": self._last_t_ns,
            "sequence": self._sequence,
        }

    def restore(self, saved: Mapping[str, Any]) -> None:
        """Go on from what was saved within the same boot of the host; ``link_opened`` is next.

        Raises:
            LookupError: Something is missing.
            TypeError: Something is of another type.
            ValueError: Something can't be.
        """
        last_device_ns, last_t_ns = int(saved["last_device_ns"]), int(saved["last_t_ns"])
        sequence = int(saved["sequence"])
        self._clock.restore(saved["clock"])
        self._last_device_ns, self._last_t_ns = last_device_ns, last_t_ns
        self._sequence = sequence

    def align(self, batch: DeviceBatch) -> list[EstimatorInput | Fault]:
        """Return the samples in host time, the gaps between them, and what had to be dropped."""
        items: list[EstimatorInput | Fault] = []
        device_ns = batch.device_ns.tolist()
        if not device_ns:
            return items
        restarted = batch.restarted or self._began_anew(batch.arrival_ns, device_ns[0])
        first = 0
        if self._last_device_ns is not None and not restarted:
            first = bisect_right(device_ns, self._last_device_ns)
            if first:
                items.append(Fault(batch.arrival_ns, "time-reversed", first))
        for start, stop in _runs(device_ns, first, batch.period_s * NS_PER_S):
            at_ns = device_ns[start:stop]
            channels = batch.channels
            if len(at_ns) < len(device_ns):
                channels = {name: rows[start:stop] for name, rows in channels.items()}
            self._append_run(items, batch, at_ns, channels, restarted=restarted and start == first)
        return items

    def _began_anew(self, arrival_ns: int, first_ns: int) -> bool:
        """Tell whether the device's clock began anew, though the batch doesn't say so."""
        if self._last_device_ns is None:
            return False
        if first_ns < self._last_device_ns - OUT_OF_ORDER_NS:
            return True
        return self._link_was_down and not (
            first_ns > self._last_device_ns and self._is_plausible(arrival_ns, first_ns)
        )

    def _is_plausible(self, arrival_ns: int, device_ns: int) -> bool:
        return EARLIEST_NS < arrival_ns - self._clock.to_host_ns(device_ns) < LATEST_NS

    def _append_run(
        self,
        items: list[EstimatorInput | Fault],
        batch: DeviceBatch,
        device_ns: list[int],
        channels: Mapping[str, Floats],
        *,
        restarted: bool,
    ) -> None:
        period_ns = batch.period_s * NS_PER_S
        first_ns, last_ns = device_ns[0], device_ns[-1]
        n_missing = 0
        reason: GapReason = "link-down" if self._link_was_down else "lost"
        if self._last_device_ns is not None and not restarted:
            n_missing = round((first_ns - self._last_device_ns) / period_ns) - 1
            restarted = n_missing > 0 and not self._is_plausible(batch.arrival_ns, first_ns)
        if restarted:
            self._clock.reset()
            self._clock.observe(batch.arrival_ns, last_ns)
            if self._last_t_ns is not None:
                away_ns = self._clock.to_host_ns(first_ns) - self._last_t_ns
                n_missing = max(1, round(away_ns / period_ns) - 1)
                reason = "device-restart"
        else:
            self._clock.observe(batch.arrival_ns, last_ns)
        if n_missing > 0:
            assert self._last_t_ns is not None
            items.append(Gap(self._last_t_ns + round(period_ns), n_missing, reason))
            self._sequence += n_missing
        stamps = self._stamp(device_ns)
        t_ns = np.array(stamps, np.int64)
        t_ns.setflags(write=False)
        items.append(SampleBatch(t_ns, batch.period_s, self._sequence, channels))
        self._sequence += len(device_ns)
        self._last_device_ns, self._last_t_ns = last_ns, stamps[-1]
        self._link_was_down = False

    def _stamp(self, device_ns: list[int]) -> list[int]:
        floor_ns = -1 if self._last_t_ns is None else self._last_t_ns
        stamps: list[int] = []
        for host_ns in self._clock.to_host_all_ns(device_ns):
            floor_ns = host_ns if host_ns > floor_ns else floor_ns + 1
            stamps.append(floor_ns)
        return stamps


def _runs(device_ns: list[int], first: int, period_ns: float) -> Iterable[tuple[int, int]]:
    """Return (start, stop) of each stretch without a hole, from row ``first`` on."""
    if first >= len(device_ns):
        return ()
    longest_ns = 1.5 * period_ns
    holes = [
        row
        for row, (before_ns, at_ns) in enumerate(itertools.pairwise(device_ns), start=1)
        if at_ns - before_ns > longest_ns and row > first
    ]
    return itertools.pairwise([first, *holes, len(device_ns)])
