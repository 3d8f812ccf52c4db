"""What a person may set for each link and wire format of this package.

Apart from the code that uses them, so that listing the drivers imports no third-party library.
"""

from pydantic import Field

from gaitway.api import Params


class SerialParams(Params):
    """A serial port, or what pretends to be one."""

    port: str = Field(min_length=1)
    """Path such as /dev/gaitway/left-cane, or a pyserial URL: socket://host:port,
    rfc2217://host:port, loop://. Opening raises DTR and RTS and leaves them so: boards that reset
    on DTR (many with a USB bootloader) start anew at every opening."""
    baud: int = Field(default=115200, gt=0)
    """Bits per second, 8N1. Of no meaning for USB devices that are not UARTs, and for socket://."""
    exclusive: bool = True
    """Refuse to share the port: two readers would each get half of the bytes."""
    read_interval_s: float = Field(default=0.08, ge=0.0, le=1.0)
    """Shortest time between two reads; bytes wait in the kernel. Fewer wake-ups, more latency;
    at 115200 baud 0.08 s are 920 of the 4096 bytes a tty holds."""


class XbusParams(Params):
    """An Xsens MTi that speaks Xbus with MTData2."""

    listen_only: bool = False
    """Send nothing and decode what comes: for devices that were configured beforehand."""
    rate_hz: float | None = Field(default=None, ge=1.0, le=2000.0)
    """Sample rate asked of the device, 100 if not given; devices take whole numbers, and 115200
    baud carries up to 150. With listen_only: the rate the device has, found out from the
    stream if not given."""
