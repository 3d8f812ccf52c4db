"""What gaitway says about a walk: the payloads of the bus and of the recording.

Names are those of the field (Mobilise-D: ``stride_length_m``, ``cadence_spm``,
``walking_speed_mps``), every number has its unit in its name and a standard deviation beside it.
A number that can't be known is ``null``, never 0. Each class is one ``kind``, the last chunk of
its key on the bus; the JSON Schemas of bus and recording are generated from these classes.
"""

from typing import ClassVar, Literal

from pydantic import BaseModel, ConfigDict


class Event(BaseModel):
    """Base of all events."""

    model_config = ConfigDict(
        frozen=True, extra="forbid", use_attribute_docstrings=True, allow_inf_nan=False
    )
    kind: ClassVar[str]

    t_ns: int
    """When it happened: nanoseconds of the gateway's monotonic clock; differences are exact."""


class Stride(Event):
    """One cycle of whatever carries the sensor; for a cane one placement."""

    kind: ClassVar[str] = "stride"

    start_t_ns: int
    """Where the cycle began, same clock as t_ns; t_ns is where it ended."""
    stride_length_m: float
    """Horizontal distance between the contact before and the contact after."""
    stride_length_sigma_m: float
    """Standard deviation of stride_length_m."""
    stride_duration_s: float
    """From start_t_ns to t_ns."""
    stride_duration_sigma_s: float
    """Standard deviation of stride_duration_s."""
    walking_speed_mps: float
    """Length over duration."""
    walking_speed_sigma_mps: float
    """Standard deviation of walking_speed_mps."""
    stance_duration_s: float | None = None
    """Time on the ground within the cycle."""
    stance_duration_sigma_s: float | None = None
    """Standard deviation of stance_duration_s."""
    swing_duration_s: float | None = None
    """Time in the air within the cycle."""
    swing_duration_sigma_s: float | None = None
    """Standard deviation of swing_duration_s."""
    lift_t_ns: int | None = None
    """When it left the ground within the cycle (terminal contact), same clock as t_ns; the contact
    before is start_t_ns, the contact after t_ns."""
    interpolated: bool = False
    """Not measured: samples were missing in mid-walk, and the strides beside tell its length."""
    height_change_m: float | None = None
    """How much higher it ended than it began; negative is down."""
    height_change_sigma_m: float | None = None
    """Standard deviation of height_change_m."""
    terrain: Literal["level", "stairs-up", "stairs-down"] | None = None
    """What was walked on, where the device can tell."""
    style: Literal["continuous", "step-by-step", "full-lift", "back-tips"] | None = None
    """How a walker was moved: wheels turn over several steps; wheels turn, then a full stop, each
    step; lifted as a whole; rolled on its wheels with the back tips lifted."""


class Distance(Event):
    """The running distance since the estimator began."""

    kind: ClassVar[str] = "distance"

    since_t_ns: int
    """When counting began, same clock as t_ns."""
    distance_m: float
    """Sum of all stride lengths while walking, interpolated ones included."""
    distance_sigma_m: float
    """Standard deviation of distance_m; grows with every metre and with all that went unseen."""
    strides: int
    """Strides counted into distance_m."""
    walking_s: float
    """Time spent walking."""
    unmeasured_s: float
    """Time that may have been walking but gave no usable measure (gaps, no contact, clipping)."""


class Bout(Event):
    """A walking bout began or ended."""

    kind: ClassVar[str] = "bout"

    phase: Literal["start", "end"]
    """Which of the two."""
    start_t_ns: int
    """When the bout began, same clock as t_ns."""
    duration_s: float | None = None
    """Length of the bout; null at its start."""
    duration_sigma_s: float | None = None
    """Standard deviation of duration_s."""
    strides: int | None = None
    """Strides in the bout; null at its start."""
    distance_m: float | None = None
    """Distance of the bout; null at its start."""
    distance_sigma_m: float | None = None
    """Standard deviation of distance_m."""
    walking_speed_mps: float | None = None
    """Distance over duration."""
    walking_speed_sigma_mps: float | None = None
    """Standard deviation of walking_speed_mps."""
    cadence_spm: float | None = None
    """Cycles of the sensor's carrier per minute (a step of a cane is one placement)."""
    cadence_sigma_spm: float | None = None
    """Standard deviation of cadence_spm."""


class Load(Event):
    """One stance of a crutch: from contact to lift of its tip."""

    kind: ClassVar[str] = "load"

    start_t_ns: int
    """Contact of the tip, same clock as t_ns; t_ns is its lift."""
    stance_duration_s: float
    """From start_t_ns to t_ns."""
    stance_duration_sigma_s: float
    """Standard deviation of stance_duration_s."""
    peak_force_newton: float
    """Greatest axial force."""
    peak_force_sigma_newton: float
    """Standard deviation of peak_force_newton."""
    mean_force_newton: float
    """Mean axial force over the stance."""
    mean_force_sigma_newton: float
    """Standard deviation of mean_force_newton."""
    peak_load_percent: float | None = None
    """peak_force_newton in percent of the body weight; null when the body mass was not told."""
    peak_load_sigma_percent: float | None = None
    """Standard deviation of peak_load_percent."""
    loading_rate_newtonps: float | None = None
    """Steepest rise of the force towards its peak, newtons a second."""
    loading_rate_sigma_newtonps: float | None = None
    """Standard deviation of loading_rate_newtonps."""
    contact_pitch_rad: float | None = None
    """Pitch at contact; negative: the tip is ahead of the user."""
    contact_pitch_sigma_rad: float | None = None
    """Standard deviation of contact_pitch_rad."""
    lift_pitch_rad: float | None = None
    """Pitch at lift."""
    lift_pitch_sigma_rad: float | None = None
    """Standard deviation of lift_pitch_rad."""


class Pose(Event):
    """Where the device is on its path, after each stride."""

    kind: ClassVar[str] = "pose"

    since_t_ns: int
    """When the path began: there is its origin, and its x axis points where the device first went;
    same clock as t_ns. After a loss of the path a new one begins."""
    pos_x_m: float
    """Forward of the origin."""
    pos_x_sigma_m: float
    """Standard deviation of pos_x_m."""
    pos_y_m: float
    """Left of the origin."""
    pos_y_sigma_m: float
    """Standard deviation of pos_y_m."""
    height_m: float | None = None
    """Above the origin; null where it can't be known."""
    height_sigma_m: float | None = None
    """Standard deviation of height_m."""
    heading_rad: float
    """Direction, counter-clockwise from the x axis, -pi to pi."""
    heading_sigma_rad: float
    """Standard deviation of heading_rad."""


class Turn(Event):
    """The direction changed for good: a turn ended."""

    kind: ClassVar[str] = "turn"

    start_t_ns: int
    """When it began, same clock as t_ns; t_ns is its end."""
    turn_duration_s: float
    """From start_t_ns to t_ns."""
    turn_duration_sigma_s: float
    """Standard deviation of turn_duration_s."""
    turn_angle_rad: float
    """How far, counter-clockwise positive."""
    turn_angle_sigma_rad: float
    """Standard deviation of turn_angle_rad."""


class Push(Event):
    """A walker was pushed: its wheels rolled, from standing to standing or from push to push."""

    kind: ClassVar[str] = "push"

    start_t_ns: int
    """When it began, same clock as t_ns; t_ns is its end."""
    push_length_m: float
    """How far the wheels rolled."""
    push_length_sigma_m: float
    """Standard deviation of push_length_m."""
    push_duration_s: float
    """From start_t_ns to t_ns."""
    push_duration_sigma_s: float
    """Standard deviation of push_duration_s."""
    peak_speed_mps: float
    """Fastest rolling in it."""
    peak_speed_sigma_mps: float
    """Standard deviation of peak_speed_mps."""


class Anomaly(Event):
    """Something that makes numbers untrustworthy, said while it happens."""

    kind: ClassVar[str] = "anomaly"

    anomaly: str
    """Short kebab-case name, for example sensor-clipped, no-contact, gap-in-stride."""
    detail: str
    """One line for a person."""


LinkStateName = Literal["closed", "opening", "syncing", "streaming", "stale", "waiting"]


class Status(Event):
    """How one device's link and estimator are, sent on every change and every few seconds."""

    kind: ClassVar[str] = "status"

    link: LinkStateName
    """streaming is the only state in which samples flow."""
    reason: str
    """Why it is so, and what to do about it where there is something to do."""
    since_t_ns: int
    """When the link came into this state, same clock as t_ns."""
    samples: int
    """Samples received since the gateway started."""
    samples_lost: int
    """Samples known to be missing since the gateway started."""
    sample_rate_hz: float | None
    """Rate over the last seconds; null when nothing came."""
    faults: dict[str, int]
    """Unusable bytes and messages by kind since the gateway started."""
    reconnects: int
    """How often the link was opened again since the gateway started."""
    bytes_received: int
    """Bytes read from the link since the gateway started."""
    estimator: Literal["running", "failed"]
    """failed: the estimator raises and is replaced; what it measured before stands."""
    latency_s: float
    """Look-ahead of the estimator: an event is published this long after what it speaks of."""
    dropped: dict[str, int]
    """Items dropped by each bounded queue since the gateway started (all devices together)."""
    recording: Literal["on", "off", "paused"]
    """paused: the disk refused; it is tried again."""
    recording_reason: str = ""
    """Why it is not on, and what to do about it; empty while it is."""
    device_info: dict[str, str | int | float]
    """What the device said about itself: ids, firmware, settings, battery."""


EVENT_TYPES: tuple[type[Event], ...] = (
    Stride, Distance, Bout, Load, Pose, Turn, Push, Anomaly, Status,
)  # fmt: skip
"""Every kind there is; keys, schemas and docs are made from this tuple."""
