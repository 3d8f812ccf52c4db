"""From device time to host time: where the ``SampleBatch`` of a live device is made."""

import itertools
from collections.abc import Mapping
from typing import Any, Final

import numpy as np

from gaitway.samples import DeviceBatch, EstimatorInput, Fault, Gap, GapReason, Ints, SampleBatch
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
        device_ns = batch.device_ns
        restarted = batch.restarted
        if self._link_was_down and not self._continues(batch):
            restarted = True
        if self._went_back(batch):
            restarted = True
        first = 0
        if self._last_device_ns is not None and not restarted:
            first = int(np.searchsorted(device_ns, self._last_device_ns, side="right"))
            if first:
                items.append(Fault(batch.arrival_ns, "time-reversed", first))
        period_ns = batch.period_s * NS_PER_S
        for start, stop in _runs(device_ns, first, period_ns):
            self._append_run(items, batch, start, stop, restarted=restarted and start == first)
        return items

    def _continues(self, batch: DeviceBatch) -> bool:
        """Tell whether the device's clock went on while the link was down."""
        if self._last_device_ns is None or len(batch) == 0:
            return True
        first_ns = int(batch.device_ns[0])
        return first_ns > self._last_device_ns and self._is_plausible(batch.arrival_ns, first_ns)

    def _went_back(self, batch: DeviceBatch) -> bool:
        """Tell whether the device's clock jumped back too far for a message out of order."""
        if self._last_device_ns is None or len(batch) == 0:
            return False
        return int(batch.device_ns[0]) < self._last_device_ns - OUT_OF_ORDER_NS

    def _is_plausible(self, arrival_ns: int, device_ns: int) -> bool:
        return EARLIEST_NS < arrival_ns - self._clock.to_host_ns(device_ns) < LATEST_NS

    def _append_run(
        self,
        items: list[EstimatorInput | Fault],
        batch: DeviceBatch,
        start: int,
        stop: int,
        *,
        restarted: bool,
    ) -> None:
        period_ns = batch.period_s * NS_PER_S
        first_ns, last_ns = int(batch.device_ns[start]), int(batch.device_ns[stop - 1])
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
        t_ns = self._stamp(batch.device_ns[start:stop])
        items.append(
            SampleBatch(
                t_ns=t_ns,
                period_s=batch.period_s,
                sequence=self._sequence,
                channels={name: rows[start:stop] for name, rows in batch.channels.items()},
            )
        )
        self._sequence += stop - start
        self._last_device_ns, self._last_t_ns = last_ns, int(t_ns[-1])
        self._link_was_down = False

    def _stamp(self, device_ns: Ints) -> Ints:
        floor_ns = -1 if self._last_t_ns is None else self._last_t_ns
        stamps: list[int] = []
        for at_ns in device_ns.tolist():
            floor_ns = max(self._clock.to_host_ns(at_ns), floor_ns + 1)
            stamps.append(floor_ns)
        t_ns = np.array(stamps, dtype=np.int64)
        t_ns.setflags(write=False)
        return t_ns


def _runs(device_ns: Ints, first: int, period_ns: float) -> list[tuple[int, int]]:
    """Return (start, stop) of each stretch without a hole, from row ``first`` on."""
    if first >= len(device_ns):
        return []
    holes = np.flatnonzero(np.diff(device_ns[first:]) > 1.5 * period_ns) + 1 + first
    edges = [first, *holes.tolist(), len(device_ns)]
    return list(itertools.pairwise(edges))
