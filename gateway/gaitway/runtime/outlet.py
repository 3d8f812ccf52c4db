"""Where a device's items go: to recorder and publisher when live, to a list in a replay."""

from typing import Literal, Protocol

from gaitway.bus.publisher import Publisher
from gaitway.events import Event
from gaitway.recording.items import Resumed
from gaitway.recording.recorder import Recorder
from gaitway.samples import Chunk, DeviceStatus, Fault, Gap, SampleBatch

Direction = Literal["rx", "tx"]


class Outlet(Protocol):
    """Takes everything one pipeline makes; never blocks."""

    def chunk(self, device: str, chunk: Chunk, direction: Direction) -> None:
        """Take bytes as they were read or sent, before anything looks at them."""
        ...

    def samples(self, device: str, batch: SampleBatch) -> None:
        """Take decoded samples in IMU axes."""
        ...

    def gap(self, device: str, gap: Gap) -> None:
        """Take the news that samples are missing."""
        ...

    def fault(self, device: str, fault: Fault) -> None:
        """Take the news that bytes could not be used."""
        ...

    def device_status(self, device: str, status: DeviceStatus) -> None:
        """Take what the device said about itself."""
        ...

    def link(self, device: str, t_ns: int, state: str, reason: str) -> None:
        """Take the news that the link came into a state."""
        ...

    def resumed(self, device: str, resumed: Resumed) -> None:
        """Take the state of an earlier run from which the device goes on."""
        ...

    def event(self, device: str, event: Event) -> None:
        """Take what the estimator found."""
        ...


class LiveOutlet:
    """Hands everything to the recorder, and events to the publisher too."""

    def __init__(self, recorder: Recorder | None, publisher: Publisher) -> None:
        self._recorder, self._publisher = recorder, publisher

    def chunk(self, device: str, chunk: Chunk, direction: Direction) -> None:
        """Record bytes before they are decoded."""
        if self._recorder:
            self._recorder.record_chunk(device, chunk.t_ns, chunk.data, direction)

    def samples(self, device: str, batch: SampleBatch) -> None:
        """Record samples."""
        if self._recorder:
            self._recorder.record_samples(device, batch)

    def gap(self, device: str, gap: Gap) -> None:
        """Record a gap."""
        if self._recorder:
            self._recorder.record_gap(device, gap)

    def fault(self, device: str, fault: Fault) -> None:
        """Record a fault."""
        if self._recorder:
            self._recorder.record_fault(device, fault)

    def device_status(self, device: str, status: DeviceStatus) -> None:
        """Record what the device said about itself."""
        if self._recorder:
            self._recorder.record_device_status(device, status)

    def link(self, device: str, t_ns: int, state: str, reason: str) -> None:
        """Record a change of the link, and keep the liveliness token in step with it."""
        if self._recorder:
            self._recorder.record_link(device, t_ns, state, reason)
        self._publisher.set_alive(device, alive=state == "streaming")

    def resumed(self, device: str, resumed: Resumed) -> None:
        """Record where the device goes on from, so that a replay can."""
        if self._recorder:
            self._recorder.record_resumed(device, resumed)

    def event(self, device: str, event: Event) -> None:
        """Record and publish an event."""
        if self._recorder:
            self._recorder.record_event(device, event)
        self._publisher.publish(device, event)
