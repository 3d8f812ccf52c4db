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
from gaitway.samples import Chunk, CodecItem, EstimatorInput, Floats, Required
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

    def save(self) -> bytes:
        """Return all that later answers depend on, so that another one can go on from here."""
        ...

    def restore(self, state: bytes) -> None:
        """Go on from what one of the same class and parameters saved.

        What came after, up to the next sample, is told as a ``Gap`` before it.

        Raises:
            ValueError: It was saved by something else, or is damaged; nothing has changed.
        """
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
        conditions: What else the device's simulation can vary, by name; it raises ``ValueError``
            for a name or value it does not know, and its docstring lists them.
    """

    distance_m: float
    seed: int = 0
    repetition: int = 0
    rate_hz: float = 100.0
    rest_s: float = 3.0
    speed_mps: float | None = None
    turn_back: bool = False
    ideal_sensor: bool = False
    conditions: Mapping[str, str | float] = field(default_factory=dict, hash=False)


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
        truth: Further true quantities, unit in the name: one value a sample, or one value a stride,
            or, as a string, one word a stride.
    """

    rate_hz: float
    channels: Mapping[str, Floats]
    stride_start_s: Floats
    stride_end_s: Floats
    stride_length_m: Floats
    pos_n: Floats
    q_nb: Floats
    truth: Mapping[str, Floats | tuple[str, ...]] = field(default_factory=dict)

    @property
    def distance_m(self) -> float:
        """True distance walked."""
        return float(self.stride_length_m.sum())


@dataclass(frozen=True, slots=True)
class CalibrationStep:
    """One thing a person does while the device is recorded.

    Attributes:
        prompt: What to do, one or two sentences.
        duration_s: How long it is recorded; until Enter is pressed where None.
        asks: What number the person types afterwards, a name with its unit (``force_newton``: what
            the scale shows); nothing where None.
        repeat: Done again and again, until the person says that it is enough.
    """

    prompt: str
    duration_s: float | None = None
    asks: str | None = None
    repeat: bool = False


@dataclass(frozen=True, slots=True, eq=False)
class CalibrationPart:
    """What was recorded during one step, once.

    Attributes:
        items: Samples and gaps, axes of the IMU (frame b).
        C_db: The mounting as configured, from IMU to device components, shape (3, 3).
        answer: The number the person typed, where the step asks for one.
    """

    items: Sequence[EstimatorInput]
    C_db: Floats
    answer: float | None = None


@dataclass(frozen=True, slots=True, eq=False)
class CalibrationResult:
    """What a calibration found.

    Attributes:
        params: Parameters of the device to write into the configuration.
        mounting: The mounting to write, where it was found: ``C_db``, shape (3, 3).
        findings: A line for each thing found: what, value with uncertainty and unit.
        warnings: What is doubtful although it was accepted, a line each.
        picture: Draws the fit: takes a ``matplotlib.figure.Figure``.
    """

    params: Mapping[str, Any]
    findings: Sequence[str]
    mounting: Floats | None = None
    warnings: Sequence[str] = ()
    picture: Callable[[Any], None] | None = None


@dataclass(frozen=True, slots=True)
class Calibration:
    """A calibration that a device type offers.

    Attributes:
        name: kebab-case, as in ``gaitway calibrate CONFIG DEVICE NAME``.
        summary: One line.
        steps: What the person does, in order; a file takes the place of all of them.
        options: Model of what has to be told besides (``distance_m`` that was walked).
        fit: The device's parameters, the options and one part for each time a step was done (of a
            file: one part for each answer, or the whole file as one) to the result.
            Raises ``CalibrationError``, whose text says why it is refused and what to do better.
        trains: ``gaitway estimate --train FILE`` runs this one with default options.
    """

    name: str
    summary: str
    steps: tuple[CalibrationStep, ...]
    options: type[Params]
    fit: Callable[[Any, Any, Sequence[CalibrationPart]], CalibrationResult]
    trains: bool = False


@dataclass(frozen=True, slots=True)
class DeviceType:
    """A kind of walking aid or body segment that carries a sensor.

    Attributes:
        name: kebab-case, as in ``type = "quad-cane"``.
        summary: One line.
        requires: Channels its estimator can't do without; of a tuple of channels any one will do.
        params: Model of its parameters.
        make_estimator: Parameters, and the mounting as ``C_db`` (from IMU to device components,
            shape (3, 3)), to an estimator: samples come in device axes, but a lever arm is told
            in those of the IMU.
        default_mounting: Where each IMU axis points when the config says nothing: a direction
            (up, down, forward, backward, left, right) for x, y and z.
        simulate: A plan to a walk with truth, where the device can be simulated.
        summarise: Events of a walk to what ``gaitway estimate`` adds for this device, or puts in
            the place of what it says of every device (``distance_m`` is null for a crutch).
        calibrations: What ``gaitway calibrate`` can find for it.
        measured: Parameters that are another for every device or person and so must be measured:
            ``gaitway check`` tells which are left at their defaults.
    """

    name: str
    summary: str
    requires: Required
    params: type[Params]
    make_estimator: Callable[[Any, Floats], Estimator]
    default_mounting: Mapping[str, str] = field(
        default_factory=lambda: {"x": "forward", "y": "left", "z": "up"}
    )
    simulate: Callable[[WalkPlan], SimulatedWalk] | None = None
    summarise: Callable[[Sequence[Event]], Mapping[str, Any]] | None = None
    calibrations: tuple[Calibration, ...] = ()
    measured: tuple[str, ...] = ()
