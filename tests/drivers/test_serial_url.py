"""The serial transport where pyserial only gives a URL: a thread instead of a descriptor."""

import asyncio
import contextlib
import threading
from collections.abc import AsyncIterator

import pytest

from gaitway.api import TransportLostError, TransportOpenError
from gaitway.timebase import HostClock
from gaitway_drivers.params import SerialParams
from gaitway_drivers.transports.serial_url import INBOX_CHUNKS, READ_BYTES, SerialUrl

PROMPT_S = 5.0


class Server:
    """A TCP server that plays the device: the latest connection is ``reader`` and ``writer``."""

    def __init__(self) -> None:
        self.connected = asyncio.Event()
        self.writers: list[asyncio.StreamWriter] = []

    async def on_connect(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        self.reader, self.writer = reader, writer
        self.writers.append(writer)
        self.connected.set()

    @contextlib.asynccontextmanager
    async def listening(self) -> AsyncIterator["Server"]:
        server = await asyncio.start_server(self.on_connect, "127.0.0.1", 0)
        self.url = f"socket://127.0.0.1:{server.sockets[0].getsockname()[1]}"
        try:
            yield self
        finally:
            server.close()
            for writer in self.writers:
                writer.transport.abort()
                with contextlib.suppress(ConnectionError):
                    await writer.wait_closed()


def open_url(url: str, **more: object) -> SerialUrl:
    return SerialUrl(SerialParams(port=url, **more), HostClock())


async def receive_all(link: SerialUrl, count: int) -> bytes:
    data = b""
    async with asyncio.timeout(PROMPT_S):
        while len(data) < count:
            data += (await link.receive()).data
    return data


async def test_bytes_travel_both_ways_over_a_socket():
    async with Server().listening() as server, open_url(server.url) as link:
        await server.connected.wait()
        server.writer.write(bytes(range(256)))
        assert await receive_all(link, 256) == bytes(range(256))
        await link.send(bytes(range(256)))
        assert await server.reader.readexactly(256) == bytes(range(256))


async def test_the_other_end_closing_is_a_lost_link_after_its_last_bytes():
    async with Server().listening() as server, open_url(server.url) as link:
        await server.connected.wait()
        server.writer.write(b"last words")
        server.writer.close()
        assert await receive_all(link, 10) == b"last words"
        with pytest.raises(TransportLostError, match="socket://"):
            async with asyncio.timeout(PROMPT_S):
                await link.receive()
        with pytest.raises(TransportLostError):
            await link.send(b"hello?")


async def test_a_refused_connection_says_what_to_check():
    async with Server().listening() as server:
        url = server.url
    with pytest.raises(TransportOpenError, match=r"refused.*the other end"):
        async with open_url(url):
            pass


async def test_an_unknown_kind_of_url_is_an_opening_error():
    with pytest.raises(TransportOpenError, match="carrier-pigeon"):
        async with open_url("carrier-pigeon://left-cane"):
            pass


async def test_opening_blocks_nobody_else(monkeypatch):
    released = threading.Event()
    monkeypatch.setattr(
        "gaitway_drivers.transports.serial_open.serial.serial_for_url",
        lambda *_args, **_kwargs: released.wait(PROMPT_S) and None,
    )
    opening = asyncio.create_task(open_url("socket://slow:1").__aenter__())
    for _ in range(20):
        await asyncio.sleep(0)
    assert not opening.done()
    opening.cancel()
    with pytest.raises(asyncio.CancelledError):
        await opening
    released.set()
    await threads_end()


async def test_a_port_that_opens_after_all_is_closed(monkeypatch):
    released, closed = threading.Event(), threading.Event()

    class LatePort:
        def close(self) -> None:
            closed.set()

    def open_late(*_args: object, **_kwargs: object) -> LatePort:
        released.wait(PROMPT_S)
        return LatePort()

    monkeypatch.setattr("gaitway_drivers.transports.serial_open.serial.serial_for_url", open_late)
    monkeypatch.setattr("gaitway_drivers.transports.serial_open.CONNECT_TIMEOUT_S", 0.02)
    with pytest.raises(TransportOpenError, match="not open after"):
        async with open_url("socket://slow:1"):
            pass
    released.set()
    await threads_end()
    assert closed.is_set()


async def test_what_is_sent_to_a_loop_comes_back():
    async with open_url("loop://") as link:
        await link.send(b"echo")
        assert await receive_all(link, 4) == b"echo"


async def test_bytes_nobody_receives_are_held_in_bounded_memory_and_sending_goes_on():
    async with Server().listening() as server, open_url(server.url) as link:
        await server.connected.wait()
        total = 8 * INBOX_CHUNKS * READ_BYTES
        server.writer.write(bytes(total))
        for _ in range(20):
            await link.send(b"x")
        assert await server.reader.readexactly(20) == b"x" * 20
        assert link._inbox.qsize() <= INBOX_CHUNKS
        assert len(await receive_all(link, total)) == total


async def test_sending_to_a_stuck_end_is_given_up(monkeypatch):
    monkeypatch.setattr("gaitway_drivers.transports.serial_url.SEND_TIMEOUT_S", 0.1)
    async with Server().listening() as server, open_url(server.url) as link:
        await server.connected.wait()
        sending = asyncio.gather(*(link.send(bytes(1_000_000)) for _ in range(20)))
        with pytest.raises(TransportLostError):
            await sending


async def test_each_link_has_one_thread_named_after_it_that_ends_with_it():
    async with Server().listening() as server:
        before = set(threading.enumerate())
        for _ in range(3):
            async with open_url(server.url) as link:
                await server.connected.wait()
                (thread,) = set(threading.enumerate()) - before
                assert thread.name == server.url
                receiving = asyncio.create_task(link.receive())
                await asyncio.sleep(0)
            assert set(threading.enumerate()) == before
            with pytest.raises(TransportLostError):
                await receiving


async def threads_end() -> None:
    async with asyncio.timeout(PROMPT_S):
        for thread in threading.enumerate():
            if thread.name.startswith("open "):
                await asyncio.to_thread(thread.join)
