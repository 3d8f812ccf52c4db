"""Recording a device for a calibration: the daemon's own device task, and a notebook behind it."""

import asyncio
from collections.abc import Callable
from contextlib import suppress
from types import TracebackType
from typing import Self

from gaitway.config.load import ResolvedDevice
from gaitway.errors import TransportError
from gaitway.events import Event, Status
from gaitway.recording.items import Resumed
from gaitway.runtime.device_task import DeviceTask
from gaitway.runtime.health import Surroundings
from gaitway.runtime.outlet import Direction
from gaitway.samples import Chunk, DeviceStatus, EstimatorInput, Fault, Gap, SampleBatch
from gaitway.timebase import NS_PER_S, Clock

POLL_S = 0.1
FIRST_SAMPLES_WITHIN_S = 15.0


class Capture:
    """Reads one device, and keeps its samples while a step of a calibration is done.

    Args:
        device: What is configured; nothing else may hold its port.
        clock: The host's clock.
    """

    def __init__(self, device: ResolvedDevice, clock: Clock) -> None:
        self._device, self._clock = device, clock
        self._notebook = _Notebook()
        self._task: asyncio.Task[None] | None = None

    async def __aenter__(self) -> Self:
        """Open the device.

        Raises:
            TransportError: No samples came in time; the text says why.
        """
        nothing_else = Surroundings({}, "off", "")
        task = DeviceTask(self._device, self._clock, self._notebook, lambda: nothing_else)
        self._task = asyncio.create_task(task.run())
        until_ns = self._clock.now_ns() + round(FIRST_SAMPLES_WITHIN_S * NS_PER_S)
        while not self._notebook.streaming:
            if self._clock.now_ns() > until_ns:
                await self._close()
                raise TransportError(f"no samples came: {self._notebook.reason}")
            await self._clock.sleep(POLL_S)
        return self

    async def __aexit__(
        self,
        exc_type: type[BaseException] | None,
        exc: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        """Close the device."""
        await self._close()

    async def record(
        self, done: Callable[[], bool], progress: Callable[[float], None]
    ) -> list[EstimatorInput]:
        """Return the samples and gaps from now until it is done.

        Args:
            done: Whether the step is over.
            progress: Is told every now and then for how many seconds samples have come.

        Raises:
            TransportError: The samples stopped.
        """
        items = self._notebook.begin()
        while not done():
            await self._clock.sleep(POLL_S)
            if not self._notebook.streaming:
                raise TransportError(f"the samples stopped: {self._notebook.reason}")
            progress(sum(len(i) * i.period_s for i in items if isinstance(i, SampleBatch)))
        self._notebook.end()
        return items

    async def _close(self) -> None:
        if self._task is not None:
            self._task.cancel()
            with suppress(asyncio.CancelledError):
                await self._task


class _Notebook:
    """The outlet of a capture: keeps samples while asked to, and the state of the link."""

    def __init__(self) -> None:
        self._items: list[EstimatorInput] | None = None
        self.streaming = False
        self.reason = "the device does not answer"

    def begin(self) -> list[EstimatorInput]:
        self._items = []
        return self._items

    def end(self) -> None:
        self._items = None

    def samples(self, _device: str, batch: SampleBatch) -> None:
        if self._items is not None:
            self._items.append(batch)

    def gap(self, _device: str, gap: Gap) -> None:
        if self._items:
            self._items.append(gap)

    def link(self, _device: str, _t_ns: int, state: str, reason: str) -> None:
        self.streaming, self.reason = state == "streaming", reason

    def event(self, _device: str, event: Event) -> None:
        if isinstance(event, Status):
            self.reason = event.reason

    def chunk(self, device: str, chunk: Chunk, direction: Direction) -> None:
        """Leave out."""

    def fault(self, device: str, fault: Fault) -> None:
        """Leave out."""

    def resumed(self, device: str, resumed: Resumed) -> None:
        """Leave out."""

    def device_status(self, device: str, status: DeviceStatus) -> None:
        """Leave out."""
