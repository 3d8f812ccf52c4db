"""What plugins and drivers provide: protocols, and the records that offer them to the registry.

A record holds names, parameter models and factories; heavy imports happen in the factory. The core
calls the objects a factory returned directly: no data goes through hooks.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from types import TracebackType
from typing import Any, Protocol, Self

from gaitway.events import Event
from gaitway.params import Params
from gaitway.samples import Channel, Chunk, CodecItem, EstimatorInput, Floats
from gaitway.timebase import Clock


class Transport(Protocol):
    """A link that moves bytes, opened by entering it.

    Entering raises ``TransportOpenError`` whose text says what to do. Leaving closes the link and
    leaves no thread, task or file descriptor behind.
    """

    async def __aenter__(self) -> Self:
        """Open the link."""
        ...

    async def __aexit__(
        self,
        exc_type: type[BaseException] | None,
        exc: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        """Close the link."""
        ...

    async def receive(self) -> Chunk:
        """Return the next bytes, never empty; raise ``TransportLostError`` if the link is gone."""
        ...

    async def send(self, payload: bytes) -> None:
        """Send bytes; raise ``TransportLostError`` when the link is gone."""
        ...


class Codec(Protocol):
    """A wire format, sans-IO: bytes and time in, items out.

    Never blocks, never reads a clock, never raises on what a device sent. How a stream is cut into
    chunks changes nothing but ``arrival_ns``. What ``feed`` returns depends on what was fed and on
    ``start`` alone, never on ``on_time``, so that a replay of the chunks decodes the same.
    """

    def start(self, t_ns: int) -> list[CodecItem]:
        """Begin anew on a freshly opened link; return the first commands, if there are any."""
        ...

    def feed(self, chunk: Chunk) -> list[CodecItem]:
        """Return everything the bytes completed."""
        ...

    def on_time(self, t_ns: int) -> list[CodecItem]:
        """Return what is due now that nothing came: commands sent again, or giving up.

        Called every 50 ms or so while the link is open; returns no samples.
        """
        ...

    def finish(self) -> list[CodecItem]:
        """Return what the end of the bytes decides (a half message is a fault)."""
        ...


class Estimator(Protocol):
    """Samples in, events out: a pure state machine without clock, I/O or threads.

    How the samples are cut into batches changes nothing. ``accel`` and ``gyro`` arrive in the
    device frame d (x forward, y left, z up).
    """

    @property
    def look_ahead_s(self) -> float:
        """How long after its moment an event is told, because of centred windows."""
        ...

    def update(self, item: EstimatorInput) -> Sequence[Event]:
        """Take the next samples, or the news that some are missing; return what is now known."""
        ...

    def finish(self) -> Sequence[Event]:
        """Return what the look-ahead still held back, at the end of the input."""
        ...

    def start_trace(self) -> "Trace":
        """Keep per-sample estimates from now on, for files and plots; never called when live."""
        ...


class Trace:
    """Per-sample estimates of one estimator: a column a quantity, a row a sample.

    Attributes:
        columns: Names, units included.
    """

    def __init__(self, *columns: str) -> None:
        self.columns = columns
        self.t_ns: list[int] = []
        self.rows: list[tuple[float, ...]] = []

    def append(self, t_ns: int, *values: float) -> None:
        """Add a sample's estimates, in the order of ``columns``."""
        self.t_ns.append(t_ns)
        self.rows.append(values)


class Peripheral(Protocol):
    """The device's side of a wire format, sans-IO: what a simulated device says."""

    def start(self) -> bytes:
        """Return what the device sends on power-up."""
        ...

    def feed(self, data: bytes) -> bytes:
        """Return the answer to what the host sent."""
        ...

    def encode(self, index: int, channels: Mapping[str, Floats]) -> bytes:
        """Return one sample on the wire, or ``b""`` while the device is not measuring.

        Args:
            index: Number of the sample since power-up; device time is ``index / rate_hz``.
            channels: Channel name to one row of values, shape (k,).
        """
        ...


@dataclass(frozen=True, slots=True)
class TransportType:
    """A kind of link.

    Attributes:
        name: kebab-case, as in ``driver = { transport = "serial" }``.
        summary: One line.
        params: Model of the keys it takes in the ``driver`` table.
        make: Parameters and the clock that stamps chunks to a transport, not yet open.
    """

    name: str
    summary: str
    params: type[Params]
    make: Callable[[Any, Clock], Transport]


@dataclass(frozen=True, slots=True)
class CodecType:
    """A wire format.

    Attributes:
        name: kebab-case, as in ``driver = { codec = "xbus" }``.
        summary: One line.
        params: Model of the keys it takes in the ``driver`` table.
        make: Parameters to a codec.
        make_peripheral: Sample rate (hertz) to the device's side, where it can be simulated.
    """

    name: str
    summary: str
    params: type[Params]
    make: Callable[[Any], Codec]
    make_peripheral: Callable[[float], Peripheral] | None = None


@dataclass(frozen=True, slots=True)
class WalkPlan:
    """What a simulated person is asked to do.

    Attributes:
        distance_m: How far to walk, roughly: the last stride is a whole one.
        seed: Same seed, same person and sensor.
        repetition: Which walk of that person: other steps and noise, same sensor.
        rate_hz: Sample rate.
        rest_s: Standing still before and after.
        speed_mps: Walking speed; the person's own where None.
        turn_back: Turn round half-way and walk back.
        ideal_sensor: No noise, bias, scale, quantisation or saturation.
    """

    distance_m: float
    seed: int = 0
    repetition: int = 0
    rate_hz: float = 100.0
    rest_s: float = 3.0
    speed_mps: float | None = None
    turn_back: bool = False
    ideal_sensor: bool = False


@dataclass(frozen=True, slots=True, eq=False)
class SimulatedWalk:
    """A walk with exact truth, beginning and ending at rest.

    Attributes:
        rate_hz: Sample rate; sample i is at ``i / rate_hz`` seconds.
        channels: Channel name to what the sensor reports, shape (n, k), axes of an IMU that sits
            as the device type's default mounting says.
        stride_start_s: Start of each true stride, shape (m,).
        stride_end_s: End of each true stride, shape (m,).
        stride_length_m: True horizontal length of each stride, shape (m,).
        pos_n: True position of the point whose path is measured, shape (n, 3).
        q_nb: True attitude of the IMU, shape (n, 4).
    """

    rate_hz: float
    channels: Mapping[str, Floats]
    stride_start_s: Floats
    stride_end_s: Floats
    stride_length_m: Floats
    pos_n: Floats
    q_nb: Floats

    @property
    def distance_m(self) -> float:
        """True distance walked."""
        return float(self.stride_length_m.sum())


@dataclass(frozen=True, slots=True)
class DeviceType:
    """A kind of walking aid or body segment that carries a sensor.

    Attributes:
        name: kebab-case, as in ``type = "quad-cane"``.
        summary: One line.
        requires: Channels its estimator can't do without.
        params: Model of its parameters.
        make_estimator: Parameters to an estimator.
        default_mounting: Where each IMU axis points when the config says nothing: a direction
            (up, down, forward, backward, left, right) for x, y and z.
        simulate: A plan to a walk with truth, where the device can be simulated.
        summarise: Events of a walk to what ``gaitway estimate`` adds for this device.
    """

    name: str
    summary: str
    requires: tuple[Channel, ...]
    params: type[Params]
    make_estimator: Callable[[Any], Estimator]
    default_mounting: Mapping[str, str] = field(
        default_factory=lambda: {"x": "forward", "y": "left", "z": "up"}
    )
    simulate: Callable[[WalkPlan], SimulatedWalk] | None = None
    summarise: Callable[[Sequence[Event]], Mapping[str, Any]] | None = None
