"""A pseudo-terminal under a fixed path: the serial port of a simulated device."""

import contextlib
import os
import pty
import select
import tty
from pathlib import Path
from types import TracebackType
from typing import Final, Self

READ_BYTES: Final = 4096


class PtyPort:
    """The device's end of a serial line; the other end is the path ``link``.

    Like a UART nobody listens to, it loses what is written while its buffer is full, and counts it.

    Args:
        link: Where the port appears, as a symbolic link.

    Raises:
        FileExistsError: Something else is there; it is left alone.

    Attributes:
        bytes_lost: Bytes written while nobody read.
    """

    def __init__(self, link: Path) -> None:
        if link.exists() and not link.is_symlink():
            raise FileExistsError(f"{link} is there and is no link of a simulated port")
        self._link = link
        self.bytes_lost = 0
        self._master, self._slave = pty.openpty()
        tty.setraw(self._slave)
        os.set_blocking(self._master, False)
        link.parent.mkdir(parents=True, exist_ok=True)
        fresh = link.with_name(f".{link.name}.{os.getpid()}")
        fresh.unlink(missing_ok=True)
        fresh.symlink_to(os.ttyname(self._slave))
        fresh.replace(link)  # at once: nobody sees a missing port

    def __enter__(self) -> Self:
        """Return the port."""
        return self

    def __exit__(
        self,
        exc_type: type[BaseException] | None,
        exc: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        """Unplug."""
        self.unplug()

    def fileno(self) -> int:
        """Return the descriptor of the device's end."""
        return self._master

    def wait(self, timeout_s: float) -> bool:
        """Wait until the host sent something; return whether it did."""
        return bool(select.select([self._master], [], [], max(0.0, timeout_s))[0])

    def read(self) -> bytes:
        """Return what the host sent, empty when nothing."""
        try:
            return os.read(self._master, READ_BYTES)
        except BlockingIOError:
            return b""

    def write(self, data: bytes) -> None:
        """Send to the host."""
        try:
            written = os.write(self._master, data) if data else 0
        except BlockingIOError:
            written = 0
        self.bytes_lost += len(data) - written

    def unplug(self) -> None:
        """Pull the cable: the host's end hangs up and the path goes."""
        if self._master < 0:
            return
        with contextlib.suppress(FileNotFoundError):
            if str(self._link.readlink()) == os.ttyname(self._slave):
                self._link.unlink()
        os.close(self._slave)
        os.close(self._master)
        self._master = self._slave = -1
