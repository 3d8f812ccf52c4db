"""From measurements to samples on the device's own clock.

A sample is what the device says about one instant: it may come split over two messages, with the
same SampleTimeFine, and messages about something else (satellites) come between with an older one.
Everything here depends on the order of messages alone, never on how they were cut into chunks.
"""

import math
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass
from itertools import pairwise
from typing import Final

import numpy as np

from gaitway.api import (
    NS_PER_S,
    CodecItem,
    DeviceBatch,
    DeviceStatus,
    Fault,
    Floats,
    HandshakeFailed,
)
from gaitway_drivers.codecs.xbus.counter import PacketCounter
from gaitway_drivers.codecs.xbus.readings import (
    Readings,
    is_complete,
    is_inertial,
    to_channels,
)
from gaitway_drivers.codecs.xbus.ticks import FULL_TICKS, TICK_NS, TickClock

PERIOD_SAMPLES: Final = 10
"""Samples looked at to find the period; they are held back until then."""
UNSPLIT_INSTANTS: Final = 10
"""After so many instants that came whole, a sample no longer waits for a second message."""
TEMPERATURE_STEP_CELSIUS: Final = 0.5
TEMPERATURE_INTERVAL_NS: Final = 60 * NS_PER_S
"""Temperature is told again when it changed by a step, and not more often than this."""


@dataclass(slots=True)
class _Instant:
    """What is known so far about one moment of the device's clock."""

    tick: int
    arrival_ns: int
    values: dict[str, Floats]


@dataclass(slots=True)
class _Segment:
    """Samples with the same kinds of values, each of shape (n, k)."""

    arrival_ns: int
    device_ns: list[int]
    values: Mapping[str, Floats]
    restarted: bool = False


class Sampler:
    """Collects measurements and gives out batches of samples.

    Args:
        period_s: Sample period; None to take it from the first samples.
    """

    def __init__(self, period_s: float | None) -> None:
        self.period_s = period_s
        self._clock = TickClock()
        self._counter = PacketCounter()
        self._open: _Instant | None = None
        self._unsplit = 0
        self._segments: list[_Segment] = []
        self._items: list[CodecItem] = []
        self._lost = 0
        self._timed = False
        self._untimed = False
        self._steps = 0
        self._steps_restarted = False
        self._refused = False
        self._temperature: tuple[int, float] | None = None

    def device_restarted(self) -> None:
        """Note that the device said it starts anew."""
        self._close()
        self._counter.restart()
        self._clock.restart()
        self._steps = 0
        self._steps_restarted = True

    def add(self, t_ns: int, readings: Readings) -> None:
        """Take consecutive measurements of one layout.

        Args:
            t_ns: When their bytes were read.
            readings: What they say.
        """
        if readings.ticks is None:
            self._add_untimed(t_ns, readings)
            return
        if readings.temperatures is not None:
            at_ns = [tick * TICK_NS for tick in readings.ticks]
            self._note_temperature(t_ns, readings.temperatures, at_ns)
        if (
            self._unsplit >= UNSPLIT_INSTANTS
            and self._open is None
            and is_complete(readings.values)
        ):
            device_ns = self._clock.advance_all(readings.ticks)
            if device_ns is not None:
                self._lost += self._counter.advance(readings.counters)
                self._segments.append(_Segment(t_ns, device_ns, readings.values))
                return
        for index in range(readings.messages):
            self._add_one(t_ns, readings.row(index))

    def flush(self, t_ns: int) -> list[CodecItem]:
        """Return everything that is known by now, samples in as few batches as possible."""
        items, self._items = self._items, []
        if self._lost:
            detail = "the packet counter jumped: messages were lost on the way"
            items.append(Fault(t_ns, "lost-messages", self._lost, detail))
            self._lost = 0
        if (
            self.period_s is None
            and sum(len(s.device_ns) for s in self._segments) >= PERIOD_SAMPLES
        ):
            items += self._find_period(t_ns)
        if self.period_s is not None and self._segments:
            items += self._batches(self.period_s)
            self._segments = []
        return items

    def finish(self, t_ns: int) -> list[CodecItem]:
        """Return what was held back, at the end of the input."""
        self._close()
        items = self.flush(t_ns)
        if self._segments:
            items += self._find_period(t_ns)
            items += self.flush(t_ns)
        return items

    def _add_one(self, t_ns: int, one: Readings) -> None:
        assert one.ticks is not None
        (tick,) = one.ticks
        if self._open is not None and tick == self._open.tick:
            if one.values:
                self._open.values.update(one.values)
                self._open.arrival_ns = t_ns
                self._unsplit = 0
        elif self._clock.is_last(tick):
            if one.values:  # too late for its sample; from now on samples wait again
                self._unsplit = 0
        elif is_inertial(one.values) or (one.values and not self._is_behind(tick)):
            self._close()
            if is_inertial(one.values):
                self._begin_timed(tick)
            self._open = _Instant(tick, t_ns, dict(one.values))
            self._unsplit += 1
        self._lost += self._counter.advance(one.counters)
        whole = self._open is not None and is_complete(self._open.values)
        if whole and self._unsplit >= UNSPLIT_INSTANTS:
            self._close()

    def _begin_timed(self, tick: int) -> None:
        if self._untimed and not self._timed:
            self._clock.restart()
        self._timed = True
        if self._clock.would_restart(tick):
            self._counter.restart()

    def _is_behind(self, tick: int) -> bool:
        if self._open is not None:
            return (tick - self._open.tick) % FULL_TICKS > FULL_TICKS // 2
        return self._clock.is_behind(tick)

    def _close(self) -> None:
        """Make the open instant a sample if it is whole; forget it if not."""
        instant, self._open = self._open, None
        if instant is not None and is_complete(instant.values):
            at_ns, restarted = self._clock.advance(instant.tick)
            self._segments.append(_Segment(instant.arrival_ns, [at_ns], instant.values, restarted))

    def _add_untimed(self, t_ns: int, readings: Readings) -> None:
        """Take measurements without SampleTimeFine: counter times period is their time."""
        whole = is_complete(readings.values) and not self._timed
        steps: list[int] = []
        for index in range(readings.messages):
            counters = readings.counters
            missing = self._counter.advance(None if counters is None else [counters[index]])
            self._lost += missing
            self._steps += missing + whole
            steps.append(self._steps)
        if whole and self.period_s is None:
            self._refuse_untimed(t_ns)
        elif whole and self.period_s is not None:
            period_ns = self.period_s * NS_PER_S
            device_ns = [round(step * period_ns) for step in steps]
            self._segments.append(_Segment(t_ns, device_ns, readings.values, self._steps_restarted))
            self._steps_restarted = False
            self._untimed = True
            if readings.temperatures is not None:
                self._note_temperature(t_ns, readings.temperatures, device_ns)

    def _refuse_untimed(self, t_ns: int) -> None:
        if not self._refused:
            self._refused = True
            reason = (
                "measurements carry no SampleTimeFine, so their rate can't be known: "
                "give rate_hz, or let the device send SampleTimeFine (1060)"
            )
            self._items.append(HandshakeFailed(t_ns, reason))

    def _note_temperature(self, t_ns: int, temperatures: list[float], device_ns: list[int]) -> None:
        for celsius, at_ns in zip(temperatures, device_ns, strict=True):
            if not math.isfinite(celsius):
                continue
            if self._temperature is not None:
                told_ns, told_celsius = self._temperature
                if (
                    abs(celsius - told_celsius) < TEMPERATURE_STEP_CELSIUS
                    or abs(at_ns - told_ns) < TEMPERATURE_INTERVAL_NS
                ):
                    continue
            self._temperature = (at_ns, celsius)
            self._items.append(DeviceStatus(t_ns, {"temperature_celsius": round(celsius, 2)}))

    def _find_period(self, t_ns: int) -> list[CodecItem]:
        """Take the most common step of the first samples as the period."""
        device_ns = [at_ns for segment in self._segments for at_ns in segment.device_ns]
        device_ns = device_ns[:PERIOD_SAMPLES]
        steps_ns = [after - before for before, after in pairwise(device_ns)]
        counts = Counter(step_ns for step_ns in steps_ns if step_ns > 0)
        if not counts:
            self._segments = []
            return [Fault(t_ns, "no-period", len(device_ns), "too few samples to tell their rate")]
        period_ns = min(counts, key=lambda step_ns: (-counts[step_ns], step_ns))
        self.period_s = period_ns / NS_PER_S
        return [DeviceStatus(t_ns, {"sample_rate_hz": round(1.0 / self.period_s, 3)})]

    def _batches(self, period_s: float) -> list[CodecItem]:
        groups: list[list[_Segment]] = []
        for segment in self._segments:
            segment.values = to_channels(segment.values, period_s)
            alike = groups and groups[-1][0].values.keys() == segment.values.keys()
            if alike and not segment.restarted:
                groups[-1].append(segment)
            else:
                groups.append([segment])
        return [_batch(group, period_s) for group in groups]


def _batch(segments: list[_Segment], period_s: float) -> DeviceBatch:
    first, last = segments[0], segments[-1]
    device_ns, channels = first.device_ns, first.values
    if first is not last:
        device_ns = [at_ns for segment in segments for at_ns in segment.device_ns]
        channels = {
            name: np.concatenate([segment.values[name] for segment in segments])
            for name in channels
        }
    at_ns = np.array(device_ns, np.int64)
    for rows in (at_ns, *channels.values()):
        rows.setflags(write=False)
    return DeviceBatch(last.arrival_ns, at_ns, period_s, channels, first.restarted)
