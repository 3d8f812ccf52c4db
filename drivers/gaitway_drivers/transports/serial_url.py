"""A serial port behind a pyserial URL, read by a thread of its own."""

import asyncio
import contextlib
import queue
import threading
from collections.abc import Callable
from types import TracebackType
from typing import Any, Final, Self

import serial

from gaitway.api import Chunk, Clock, TransportLostError
from gaitway_drivers.params import SerialParams
from gaitway_drivers.transports.serial_open import close_url, open_in_thread, open_url

READ_BYTES: Final = 65536
INBOX_CHUNKS: Final = 4
"""Chunks read but not yet received; when full, bytes wait on the other side."""
SHORTEST_INTERVAL_S: Final = 0.005
"""Between two reads the thread sleeps at least so long, or it would never sleep."""
SEND_TIMEOUT_S: Final = 2.0

_Waiting = asyncio.Future[None]


class SerialUrl:
    """A port that pyserial reaches by URL: ``socket://``, ``rfc2217://``, ``loop://``, ``spy://``.

    Such ports have no descriptor to wait for. One thread reads, writes and at last closes; it ends
    before the link counts as closed. Reads and writes take turns, ``read_interval_s`` apart.

    Args:
        params: Which URL, and how.
        clock: Stamps each chunk when it is read.
    """

    def __init__(self, params: SerialParams, clock: Clock) -> None:
        self._params = params
        self._clock = clock
        self._thread: threading.Thread | None = None
        self._lost: TransportLostError | None = None

    async def __aenter__(self) -> Self:
        """Open the port; raise ``TransportOpenError`` saying what to do if that fails."""
        port = await open_in_thread(
            f"open {self._params.port}", lambda: open_url(self._params), close_url
        )
        self._loop = asyncio.get_running_loop()
        self._stop = threading.Event()
        self._news = asyncio.Event()
        self._ended = asyncio.Event()
        self._inbox: queue.Queue[Chunk] = queue.Queue(INBOX_CHUNKS)
        self._outbox: queue.SimpleQueue[tuple[bytes, _Waiting]] = queue.SimpleQueue()
        self._lost = None
        self._thread = threading.Thread(
            target=self._run, args=(port,), name=self._params.port, daemon=True
        )
        self._thread.start()
        return self

    async def __aexit__(
        self,
        exc_type: type[BaseException] | None,
        exc: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        """Close the port and wait for its thread to end."""
        thread, self._thread = self._thread, None
        if thread is not None:
            self._stop.set()
            await self._ended.wait()
            thread.join()

    async def receive(self) -> Chunk:
        """Return the next bytes; raise ``TransportLostError`` when the link is gone."""
        while True:
            with contextlib.suppress(queue.Empty):
                return self._inbox.get_nowait()
            self._check()
            self._news.clear()
            await self._news.wait()

    async def send(self, payload: bytes) -> None:
        """Send all bytes; raise ``TransportLostError`` when the link is gone or stuck."""
        self._check()
        sent: _Waiting = self._loop.create_future()
        self._outbox.put((payload, sent))
        try:
            async with asyncio.timeout(SEND_TIMEOUT_S):
                await sent
        except TimeoutError:
            raise self._as_lost(f"takes no bytes for {SEND_TIMEOUT_S:.0f} s") from None

    def _check(self) -> None:
        if self._lost is not None:
            raise self._lost
        if self._thread is None:
            raise self._as_lost("not open")

    def _as_lost(self, why: object) -> TransportLostError:
        return TransportLostError(f"{self._params.port}: {why} (check the other end)")

    # What follows runs in the thread, except _end.

    def _run(self, port: serial.Serial) -> None:
        why: object = "closed"
        try:
            while not self._stop.wait(max(self._params.read_interval_s, SHORTEST_INTERVAL_S)):
                self._write_waiting(port)
                data = _read_all(port)
                if data:
                    self._hand_over(port, Chunk(self._clock.now_ns(), data))
        except OSError as exc:
            why = exc
        close_url(port)
        self._tell(self._end, why)

    def _write_waiting(self, port: serial.Serial) -> None:
        with contextlib.suppress(queue.Empty):
            while True:
                payload, sent = self._outbox.get_nowait()
                port.write(payload)
                self._tell(_set_done, sent)

    def _hand_over(self, port: serial.Serial, chunk: Chunk) -> None:
        """Put a chunk where ``receive`` finds it; while there is no room, go on writing."""
        while not self._stop.is_set():
            with contextlib.suppress(queue.Full):
                self._inbox.put(chunk, timeout=SHORTEST_INTERVAL_S)
                self._tell(self._news.set)
                return
            self._write_waiting(port)

    def _tell(self, callback: Callable[..., Any], *args: object) -> None:
        with contextlib.suppress(RuntimeError):  # the loop was closed meanwhile
            self._loop.call_soon_threadsafe(callback, *args)

    def _end(self, why: object) -> None:
        self._lost = self._as_lost(why)
        self._news.set()
        self._ended.set()
        with contextlib.suppress(queue.Empty):
            while True:
                _, sent = self._outbox.get_nowait()
                if not sent.done():
                    sent.set_exception(self._lost)


def _read_all(port: serial.Serial) -> bytes:
    """Return what is there; some ports give one byte a call, and some fail only after the last."""
    data = b""
    while len(data) < READ_BYTES:
        try:
            piece = port.read(READ_BYTES)
        except OSError:
            if data:
                break  # the next read fails again
            raise
        if not piece:
            break
        data += piece
    return data


def _set_done(waiting: _Waiting) -> None:
    if not waiting.done():
        waiting.set_result(None)
