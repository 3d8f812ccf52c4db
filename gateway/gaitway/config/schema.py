"""The configuration file as checked models; ``configs/gateway.toml`` lists every key."""

from pathlib import Path
from typing import Annotated, Any

from pydantic import Field, StringConstraints

from gaitway.params import Params
from gaitway.recording.params import RecordingParams

Name = Annotated[str, StringConstraints(pattern=r"^[a-z0-9]+(-[a-z0-9]+)*$", max_length=64)]
"""kebab-case, safe as a chunk of a key expression and of a file name."""


Endpoint = Annotated[str, StringConstraints(pattern=r"^[a-z0-9_-]+/[^/ ].*$")]
"""As zenoh writes it, for example tcp/127.0.0.1:7447."""


class BusParams(Params):
    """The zenoh session."""

    listen: tuple[Endpoint, ...] = ("tcp/127.0.0.1:7447",)
    """Endpoints to listen on. The default is reachable from this machine alone."""
    connect: tuple[Endpoint, ...] = ()
    """Endpoints of routers or peers to connect to; they may come and go."""
    multicast: bool = False
    """Look for peers on the network by multicast, and be found."""
    queue_events: int = Field(default=10_000, ge=1, le=1_000_000)
    """Events that may wait for the bus; then the oldest are dropped and counted."""
    history_events: int = Field(default=1_000, ge=0, le=1_000_000)
    """Events of each device and kind kept in memory to answer a ``get``."""


class RecordingConfig(RecordingParams):
    """The recording; the keys of ``RecordingParams`` and whether to record at all."""

    enabled: bool = True
    """Write MCAP files."""


class ResumeConfig(Params):
    """Going on after a restart where the gateway was."""

    within_s: float = Field(default=600.0, ge=0.0)
    """A device goes on from its last state if that is at most this old; 0: it always begins anew,
    and a stop ends what is going on."""
    directory: Path = Path("state")
    """Folder of the states, rewritten about once a second; worth nothing after a reboot."""


class PluginsConfig(Params):
    """Which plugins to load."""

    disabled: tuple[str, ...] = ()
    """Entry-point names to skip; ``gaitway plugins`` lists them."""


class DeviceConfig(Params):
    """One device."""

    id: Name
    """Unique name of this device, a chunk of its keys; never a port or an address."""
    type: str
    """Device type; ``gaitway plugins`` lists them."""
    driver: dict[str, Any]
    """``transport`` and ``codec`` by name, and the keys of both."""
    mounting: dict[str, Any] | None = None
    """Where each IMU axis points: x, y, z to up, down, forward, backward, left or right, or to a
    unit vector [forward, left, up]. The device type's own default when absent."""
    params: dict[str, Any] = Field(default_factory=dict)
    """Parameters of the device type's estimator."""
    enabled: bool = True
    """False leaves the device out without deleting its entry."""


class GatewayConfig(Params):
    """The whole file."""

    site: Name = "home"
    """Name of this place, a chunk of every key."""
    include: tuple[str, ...] = ()
    """Further files with ``[[devices]]``, relative to this one; ``*`` is allowed."""
    bus: BusParams = BusParams()
    """The zenoh session."""
    recording: RecordingConfig = RecordingConfig(directory=Path("recordings"))
    """The recording."""
    resume: ResumeConfig = ResumeConfig()
    """Going on after a restart."""
    plugins: PluginsConfig = PluginsConfig()
    """Which plugins to load."""
    devices: tuple[DeviceConfig, ...] = ()
    """The devices, also from included files."""
