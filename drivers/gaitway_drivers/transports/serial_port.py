"""A serial port read through its file descriptor, by the event loop."""

import asyncio
import os
from collections.abc import Callable
from types import TracebackType
from typing import TYPE_CHECKING, Any, Final, Self

from gaitway.api import Chunk, Clock, TransportLostError
from gaitway_drivers.params import SerialParams
from gaitway_drivers.transports.serial_open import close_tty, open_in_thread, open_tty

if TYPE_CHECKING:
    import serial

READ_BYTES: Final = 65536
"""More than the kernel holds for a tty, so one read takes all there is."""
SEND_TIMEOUT_S: Final = 1.0
"""A port that takes not a byte for this long is stuck."""


class SerialPort:
    """A serial port with a file descriptor: UART, USB, RFCOMM, pseudo-terminal.

    After each read it leaves the descriptor alone for ``read_interval_s``; bytes wait in the
    kernel, so that one wake-up takes many. Nothing is held here between two calls.

    Args:
        params: Which port, and how.
        clock: Stamps each chunk when it is read.
    """

    def __init__(self, params: SerialParams, clock: Clock) -> None:
        self._params = params
        self._clock = clock
        self._port: serial.Serial | None = None
        self._next_read_s = 0.0
        self._waiting: set[asyncio.Future[None]] = set()

    async def __aenter__(self) -> Self:
        """Open the port; raise ``TransportOpenError`` saying what to do if that fails."""
        self._port = await open_in_thread(
            f"open {self._params.port}", lambda: open_tty(self._params), close_tty
        )
        self._next_read_s = 0.0
        return self

    async def __aexit__(
        self,
        exc_type: type[BaseException] | None,
        exc: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        """Close the port; what still waits for it is told that the link is lost."""
        port, self._port = self._port, None
        if port is None:
            return
        loop = asyncio.get_running_loop()
        loop.remove_reader(port.fileno())
        loop.remove_writer(port.fileno())
        for waiting in self._waiting:
            if not waiting.done():
                waiting.set_exception(self._lost("closed"))
        close_tty(port)

    async def receive(self) -> Chunk:
        """Return the next bytes; raise ``TransportLostError`` when the port is gone."""
        loop = asyncio.get_running_loop()
        pause_s = self._next_read_s - loop.time()
        if pause_s > 0.0:
            await asyncio.sleep(pause_s)
        while (data := self._read()) is None:
            await self._ready(loop.add_reader, loop.remove_reader)
        self._next_read_s = loop.time() + self._params.read_interval_s
        return Chunk(self._clock.now_ns(), data)

    async def send(self, payload: bytes) -> None:
        """Send all bytes; raise ``TransportLostError`` when the port is gone or stuck."""
        loop = asyncio.get_running_loop()
        rest = payload[self._write(payload) :]
        while rest:
            try:
                async with asyncio.timeout(SEND_TIMEOUT_S):
                    await self._ready(loop.add_writer, loop.remove_writer)
            except TimeoutError:
                raise self._lost(f"takes no bytes for {SEND_TIMEOUT_S:.0f} s") from None
            rest = rest[self._write(rest) :]

    def _fd(self) -> int:
        if self._port is None:
            raise self._lost("not open")
        return self._port.fileno()

    def _read(self) -> bytes | None:
        """Return what is there, None if there is nothing yet."""
        try:
            data = os.read(self._fd(), READ_BYTES)
        except BlockingIOError:
            return None
        except OSError as exc:
            raise self._as_lost(exc) from exc
        if not data:
            raise self._lost("end of file, the other end is gone")
        return data

    def _write(self, payload: bytes) -> int:
        try:
            return os.write(self._fd(), payload)
        except BlockingIOError:
            return 0
        except OSError as exc:
            raise self._as_lost(exc) from exc

    async def _ready(
        self, add: Callable[[int, Callable[..., Any], Any], None], remove: Callable[[int], bool]
    ) -> None:
        """Wait until the descriptor can be read or written."""
        fd = self._fd()
        waiting: asyncio.Future[None] = asyncio.get_running_loop().create_future()
        self._waiting.add(waiting)
        add(fd, _set_done, waiting)
        try:
            await waiting
        finally:
            self._waiting.discard(waiting)
            if self._port is not None:  # else the number may be someone else's by now
                remove(fd)

    def _as_lost(self, exc: OSError) -> TransportLostError:
        return exc if isinstance(exc, TransportLostError) else self._lost(str(exc))

    def _lost(self, why: str) -> TransportLostError:
        return TransportLostError(f"{self._params.port}: {why} (check cable and power)")


def _set_done(waiting: asyncio.Future[None]) -> None:
    if not waiting.done():
        waiting.set_result(None)
