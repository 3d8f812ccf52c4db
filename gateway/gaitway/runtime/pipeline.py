"""One device's path from bytes to events, without I/O: the daemon and a replay run this same code.

::

    chunk -> record -> codec -> align -> record -> mount -> estimate -> keep the state -> events
"""

import logging
from collections.abc import Sequence
from collections.abc import Set as AbstractSet

from gaitway.alignment import Aligner
from gaitway.config.load import ResolvedDevice
from gaitway.contracts import Estimator
from gaitway.events import Anomaly, Event
from gaitway.mounting import mount
from gaitway.recording.items import Resumed
from gaitway.runtime.checkpoint import EVERY_S, Checkpoint
from gaitway.runtime.health import Health
from gaitway.runtime.outlet import Outlet
from gaitway.samples import (
    Chunk,
    CodecItem,
    Command,
    DeviceBatch,
    DeviceStatus,
    EstimatorInput,
    Fault,
    Gap,
    HandshakeFailed,
    SampleBatch,
    missing_channels,
)
from gaitway.timebase import NS_PER_S

logger = logging.getLogger(__name__)


class Pipeline:
    """Codec, clock alignment, mounting and estimator of one device.

    Args:
        device: What is configured.
        out: Where everything goes.
        checkpoint: Where the state is kept for the next run; nowhere where None.

    Attributes:
        health: Counters.
        failure: Why the handshake failed, until the link is opened again.
        sampled: Whether the last call brought samples.
    """

    def __init__(
        self, device: ResolvedDevice, out: Outlet, checkpoint: Checkpoint | None = None
    ) -> None:
        self._device, self._out, self._checkpoint = device, out, checkpoint
        self._id = device.config.id
        self._codec = device.codec_type.make(device.codec_params)
        self._aligner = Aligner()
        self._estimator = self._new_estimator()
        self.health = Health()
        self.failure: str | None = None
        self.sampled = False
        self._failing = False
        self._lacking = False
        self._held: AbstractSet[str] | None = None
        self._kept = False
        self._kept_ns = 0
        self._unkept_told = False

    @property
    def latency_s(self) -> float:
        """Look-ahead of the estimator."""
        return self._estimator.look_ahead_s

    def resume(self, state: Resumed) -> None:
        """Go on from where an earlier run was, or end what it began; say where neither can be."""
        self._out.resumed(self._id, state)
        estimator, aligner = self._new_estimator(), Aligner()
        try:
            estimator.restore(state.estimator)
            aligner.restore(state.aligner)
            last = list(estimator.finish()) if state.ended else []
        except Exception as exc:  # noqa: BLE001
            # A stranger's estimator may raise anything; it must cost only its own device.
            logger.warning("%s: begins anew, its state can't be restored: %r", self._id, exc)
            detail = f"{type(exc).__name__}: {exc}; counting starts anew"
            last = [Anomaly(t_ns=state.t_ns, anomaly="state-not-restored", detail=detail)]
        else:
            if not state.ended:
                self._estimator, self._aligner, self._kept = estimator, aligner, True
                return
        if self._checkpoint is not None:
            self._checkpoint.clear()  # before the events are told, so that they never come again
        self._emit(last)

    def link_opened(self, t_ns: int) -> list[bytes]:
        """Begin on a freshly opened link; return what to send."""
        self.failure = None
        self._aligner.link_opened()
        return self._take(t_ns, self._codec.start(t_ns))

    def feed(self, chunk: Chunk) -> list[bytes]:
        """Take bytes; return what to send."""
        self._out.chunk(self._id, chunk, "rx")
        self.health.bytes_received += len(chunk.data)
        return self._take(chunk.t_ns, self._codec.feed(chunk))

    def on_time(self, t_ns: int) -> list[bytes]:
        """Let the codec see time pass; return what to send."""
        return self._take(t_ns, self._codec.on_time(t_ns))

    def link_lost(self, t_ns: int) -> None:
        """Take the end of the bytes of this link."""
        self._take(t_ns, self._codec.finish())

    def stop(self, t_ns: int) -> None:
        """Keep the state for the next run, which goes on; without one, finish."""
        if not (self._kept or self._keep(t_ns)):
            self.finish()

    def finish(self) -> None:
        """Let the estimator say what its look-ahead still held back."""
        try:
            events = self._estimator.finish()
        except Exception:
            # A stranger's estimator may raise anything; the others' recordings must be finished.
            logger.exception("%s: the estimator failed at the end", self._id)
            return
        self._emit(events)

    def _new_estimator(self) -> Estimator:
        return self._device.device_type.make_estimator(self._device.params, self._device.C_db)

    def _take(self, t_ns: int, items: Sequence[CodecItem]) -> list[bytes]:
        commands: list[bytes] = []
        self.sampled = False
        for item in items:
            match item:
                case DeviceBatch():
                    self._take_batch(item)
                case Fault():
                    self._take_fault(item)
                case DeviceStatus():
                    self.health.note_device(item)
                    self._out.device_status(self._id, item)
                case Command():
                    self._out.chunk(self._id, Chunk(t_ns, item.payload), "tx")
                    commands.append(item.payload)
                case HandshakeFailed():
                    self.failure = item.reason
        return commands

    def _take_batch(self, batch: DeviceBatch) -> None:
        self.sampled = True
        self._kept = False
        events: list[Event] = []
        for item in self._aligner.align(batch):
            if isinstance(item, Fault):
                self._take_fault(item)
                continue
            if isinstance(item, Gap):
                self.health.count_gap(item)
                self._out.gap(self._id, item)
                events += self._estimate(item)
            else:
                self.health.samples += len(item)
                self._out.samples(self._id, item)
                events += self._note_missing(item)
                if self._lacking:
                    events += self._estimate(Gap(int(item.t_ns[0]), len(item), "lost"))
                else:
                    events += self._estimate(mount(item, self._device.C_db))
        if events or batch.arrival_ns - self._kept_ns >= EVERY_S * NS_PER_S:
            self._keep(batch.arrival_ns)
        self._emit(events)

    def _keep(self, t_ns: int) -> bool:
        """Put the state on file; return whether the next run can go on from it."""
        self._kept_ns = t_ns
        if self._checkpoint is None or not self._aligner.begun:
            return False
        try:
            self._checkpoint.write(t_ns, self._aligner.save(), self._estimator.save())
        except Exception as exc:  # noqa: BLE001
            # A stranger's save may raise anything, and so may the disk; the walk is measured on.
            level = logging.DEBUG if self._unkept_told else logging.WARNING
            logger.log(level, "%s: a restart would begin anew, no state: %r", self._id, exc)
            self._unkept_told = True
            self._checkpoint.clear()
            return False
        self._kept, self._unkept_told = True, False
        return True

    def _note_missing(self, batch: SampleBatch) -> Sequence[Event]:
        """Note whether the estimator can't work with these samples; say so once."""
        if batch.channels.keys() == self._held:
            return ()
        self._held = frozenset(batch.channels)
        missing = ", ".join(missing_channels(self._device.device_type.requires, batch.channels))
        news = bool(missing) and not self._lacking
        self._lacking = bool(missing)
        if not news:
            return ()
        detail = f"the device sends no {missing}, without which nothing can be estimated"
        return (Anomaly(t_ns=int(batch.t_ns[0]), anomaly="channel-missing", detail=detail),)

    def _take_fault(self, fault: Fault) -> None:
        self.health.count_fault(fault)
        self._out.fault(self._id, fault)

    def _estimate(self, item: EstimatorInput) -> Sequence[Event]:
        try:
            events = list(self._estimator.update(item))
        except Exception as exc:  # noqa: BLE001
            # A stranger's estimator may raise anything; it must cost only its own device.
            return self._begin_anew(exc, item)
        self._failing = False
        self.health.estimator = "running"
        return events

    def _begin_anew(self, exc: Exception, item: EstimatorInput) -> Sequence[Event]:
        """Replace an estimator that raised; say so once, however often it happens in a row."""
        self._estimator = self._new_estimator()
        self.health.estimator = "failed"
        if self._failing:
            logger.debug("%s: the estimator failed again: %r", self._id, exc)
            return ()
        self._failing = True
        logger.error("%s: the estimator failed and starts anew", self._id, exc_info=exc)
        return (
            Anomaly(
                t_ns=item.t_ns if isinstance(item, Gap) else int(item.t_ns[-1]),
                anomaly="estimator-failed",
                detail=f"{type(exc).__name__}: {exc}; counting starts anew",
            ),
        )

    def _emit(self, events: Sequence[Event]) -> None:
        for event in events:
            self._out.event(self._id, event)
