"""The Xbus codec: bytes in, samples, faults and commands out."""

from typing import Final

from gaitway.api import NS_PER_S, Chunk, CodecItem, Fault
from gaitway_drivers.codecs.xbus.framer import SHORTEST_STALL_NS, Framer, MessageRun
from gaitway_drivers.codecs.xbus.messages import Mid
from gaitway_drivers.codecs.xbus.mtdata2 import LayoutCache
from gaitway_drivers.codecs.xbus.readings import read
from gaitway_drivers.codecs.xbus.sampler import Sampler
from gaitway_drivers.codecs.xbus.session import Session, device_fault
from gaitway_drivers.params import XbusParams

STALL_PERIODS: Final = 3


class XbusCodec:
    """Decodes an Xsens MTi and, unless it only listens, sets it up first.

    Args:
        params: Rate asked for or expected, and whether to send anything at all.
    """

    def __init__(self, params: XbusParams) -> None:
        self._params = params
        self._begin(0)

    def start(self, t_ns: int) -> list[CodecItem]:
        """Begin anew on a freshly opened link; return the first commands."""
        self._begin(t_ns)
        return [] if self._session is None else self._session.start(t_ns)

    def feed(self, chunk: Chunk) -> list[CodecItem]:
        """Return everything the bytes completed."""
        self._t_ns = chunk.t_ns
        items = self._take(self._framer.feed(chunk.t_ns, chunk.data))
        items += self._framing_faults()
        items += self._sampler.flush(chunk.t_ns)
        if self._sampler.period_s != self._period_s:
            self._note_period(self._sampler.period_s)
        return items

    def on_time(self, t_ns: int) -> list[CodecItem]:
        """Return requests that are due again, or that the device stays silent."""
        if self._session is None:
            return []
        return self._session.on_time(t_ns, junk_bytes=self._framer.junk_bytes)

    def finish(self) -> list[CodecItem]:
        """Return what the end of the bytes decides, and the samples held back."""
        items = self._take(self._framer.finish())
        items += self._framing_faults()
        items += self._sampler.finish(self._t_ns)
        return items

    def _begin(self, t_ns: int) -> None:
        params = self._params
        self._t_ns = t_ns
        self._framer = Framer()
        self._layouts = LayoutCache()
        self._session = None if params.listen_only else Session(params.rate_hz)
        listening_hz = params.rate_hz if params.listen_only else None
        self._sampler = Sampler(None if listening_hz is None else 1.0 / listening_hz)
        self._period_s: float | None = None
        self._told = (0, 0, 0)

    def _note_period(self, period_s: float | None) -> None:
        self._period_s = period_s
        if period_s is not None:
            stall_ns = round(STALL_PERIODS * period_s * NS_PER_S)
            self._framer.stall_ns = max(SHORTEST_STALL_NS, stall_ns)

    def _take(self, runs: list[MessageRun]) -> list[CodecItem]:
        items: list[CodecItem] = []
        for run in runs:
            if run.mid == Mid.MTDATA2:
                items += self._measure(run)
            else:
                for payload in run.payloads:
                    items += self._answer(run.mid, payload.tobytes())
        return items

    def _answer(self, mid: int, data: bytes) -> list[CodecItem]:
        if mid == Mid.WAKE_UP:
            self._sampler.device_restarted()
        items = device_fault(self._t_ns, mid, data)
        if self._session is not None:
            items += self._session.on_message(self._t_ns, mid, data)
            if self._session.rate_hz is not None:
                self._sampler.period_s = 1.0 / self._session.rate_hz
        return items

    def _measure(self, run: MessageRun) -> list[CodecItem]:
        if self._session is not None and not self._session.streaming:
            self._session.on_measurement()
            if not self._session.streaming:
                return []  # sent before the device heard GoToConfig
        items: list[CodecItem] = []
        for layout, alike in self._layouts.split(run):
            if layout.fault:
                detail = f"a measurement can't be read: {layout.fault}"
                items.append(Fault(self._t_ns, "bad-payload", alike.messages, detail))
            self._sampler.add(self._t_ns, read(layout, alike))
        return items

    def _framing_faults(self) -> list[CodecItem]:
        framer, told = self._framer, self._told
        self._told = (framer.junk_bytes, framer.bad_checksums, framer.stalls)
        if self._told == told:
            return []
        kinds = (
            ("resync", "bytes that belong to no message were skipped"),
            ("bad-checksum", "messages did not add up"),
            ("stall", "a message began and its rest did not come"),
        )
        return [
            Fault(self._t_ns, kind, now - before, detail)
            for (kind, detail), now, before in zip(kinds, self._told, told, strict=True)
            if now > before
        ]
