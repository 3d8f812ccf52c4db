"""The serial transport on real pseudo-terminals."""

import asyncio
import contextlib
import errno
import fcntl
import os
import subprocess
import sys
import termios
import textwrap
import threading
from pathlib import Path

import pytest
import serial

from gaitway.api import TransportLostError, TransportOpenError
from gaitway.timebase import HostClock
from gaitway_drivers import gaitway_transports
from gaitway_drivers.params import SerialParams
from gaitway_drivers.transports.serial_open import explain
from gaitway_drivers.transports.serial_port import SerialPort

PROMPT_S = 5.0


class CountingClock(HostClock):
    """Says 1, 2, 3, ... so that a test can tell which reading stamped what."""

    def __init__(self) -> None:
        self.readings = 0

    def now_ns(self) -> int:
        self.readings += 1
        return self.readings


class Pty:
    """A pseudo-terminal: the gateway opens ``path``, the device is ``device`` at the other end."""

    def __init__(self) -> None:
        self.device, self.slave = os.openpty()
        self.path = os.ttyname(self.slave)

    def close_device(self) -> None:
        if self.device >= 0:
            os.close(self.device)
            self.device = -1

    def close(self) -> None:
        self.close_device()
        os.close(self.slave)


@pytest.fixture
def pty():
    pair = Pty()
    yield pair
    pair.close()


def open_port(path: str, **more: object) -> SerialPort:
    return SerialPort(SerialParams(port=path, **more), CountingClock())


async def read_all(port: SerialPort, count: int) -> bytes:
    data = b""
    async with asyncio.timeout(PROMPT_S):
        while len(data) < count:
            data += (await port.receive()).data
    return data


def open_fds() -> list[str]:
    return sorted(path.name for path in Path("/proc/self/fd").iterdir())


async def test_bytes_arrive_unchanged_and_stamped_by_the_clock(pty):
    every_byte = bytes(range(256))
    async with open_port(pty.path, read_interval_s=0.0) as port:
        os.write(pty.device, every_byte)
        first = await port.receive()
        assert first.t_ns == 1
        assert first.data + await read_all(port, 256 - len(first.data)) == every_byte
        os.write(pty.device, b"more")
        assert (await port.receive()).data == b"more"


async def test_bytes_are_sent_unchanged(pty):
    every_byte = bytes(range(256))
    async with open_port(pty.path) as port:
        await port.send(every_byte)
        assert os.read(pty.device, 4096) == every_byte


async def test_bytes_that_come_close_together_are_one_chunk(pty):
    async with open_port(pty.path, read_interval_s=0.2) as port:
        os.write(pty.device, b"first")
        assert (await port.receive()).data == b"first"
        for piece in (b"a", b"b", b"c"):
            os.write(pty.device, piece)
        began_s = asyncio.get_running_loop().time()
        assert (await port.receive()).data == b"abc"
        assert asyncio.get_running_loop().time() - began_s > 0.15


async def test_a_receive_that_is_cancelled_loses_nothing(pty):
    async with open_port(pty.path, read_interval_s=0.05) as port:
        for _ in range(3):
            with pytest.raises(TimeoutError):
                async with asyncio.timeout(0.02):
                    await port.receive()
        os.write(pty.device, b"one")
        assert (await port.receive()).data == b"one"
        os.write(pty.device, b"two")
        with pytest.raises(TimeoutError):
            async with asyncio.timeout(0.02):
                await port.receive()
        assert (await port.receive()).data == b"two"


@pytest.mark.parametrize("read_interval_s", [0.0, 0.05])
async def test_the_other_end_closing_is_a_lost_link(pty, read_interval_s):
    async with open_port(pty.path, read_interval_s=read_interval_s) as port:
        os.write(pty.device, b"last words")
        assert (await port.receive()).data == b"last words"
        pty.close_device()
        with pytest.raises(TransportLostError, match=pty.path):
            async with asyncio.timeout(PROMPT_S):
                await port.receive()


async def test_the_other_end_closing_wakes_a_receive_that_waits(pty):
    async with open_port(pty.path) as port:
        receiving = asyncio.create_task(port.receive())
        await asyncio.sleep(0.05)
        pty.close_device()
        with pytest.raises(TransportLostError):
            async with asyncio.timeout(PROMPT_S):
                await receiving


async def test_an_unplugged_usb_adapter_is_a_lost_link(pty, monkeypatch):
    async with open_port(pty.path) as port:

        def unplugged(*_args: object) -> bytes:
            raise OSError(errno.EIO, "Input/output error")

        with monkeypatch.context() as patch:
            patch.setattr(os, "read", unplugged)
            with pytest.raises(TransportLostError, match="Input/output error"):
                async with asyncio.timeout(PROMPT_S):
                    await port.receive()


async def test_between_two_receives_nothing_watches_the_port(pty):
    async with open_port(pty.path) as port:
        receiving = asyncio.create_task(port.receive())
        await asyncio.sleep(0.01)
        os.write(pty.device, b"x")
        await receiving
        assert not asyncio.get_running_loop().remove_reader(port._fd())


async def test_sending_to_a_lost_device_is_a_lost_link(pty):
    async with open_port(pty.path) as port:
        pty.close_device()
        with pytest.raises(TransportLostError):
            await port.send(b"hello?")


async def test_sending_to_a_stuck_device_is_given_up(pty, monkeypatch):
    monkeypatch.setattr("gaitway_drivers.transports.serial_port.SEND_TIMEOUT_S", 0.1)
    async with open_port(pty.path) as port:
        with pytest.raises(TransportLostError, match="takes no bytes"):
            await port.send(bytes(1_000_000))


async def test_a_long_payload_is_sent_whole_to_a_slow_device(pty):
    payload = os.urandom(200_000)
    async with open_port(pty.path) as port:
        sending = asyncio.create_task(port.send(payload))
        received = b""
        while len(received) < len(payload):
            await asyncio.sleep(0)
            received += await asyncio.to_thread(os.read, pty.device, 4096)
        await sending
    assert received == payload


async def test_closing_ends_a_receive_that_waits(pty):
    port = open_port(pty.path)
    async with port:
        receiving = asyncio.create_task(port.receive())
        await asyncio.sleep(0.01)
    with pytest.raises(TransportLostError, match="closed"):
        await receiving
    with pytest.raises(TransportLostError, match="not open"):
        await port.receive()


async def test_a_link_can_be_opened_again_after_it_was_lost():
    for _ in range(3):
        pair = Pty()
        try:
            async with open_port(pair.path) as port:
                os.write(pair.device, b"here")
                assert (await port.receive()).data == b"here"
                pair.close_device()
                with pytest.raises(TransportLostError):
                    await read_all(port, 1)
        finally:
            pair.close()


async def test_a_baud_rate_without_a_constant_works(pty):
    async with open_port(pty.path, baud=921600) as port:
        os.write(pty.device, b"fast")
        assert (await port.receive()).data == b"fast"


async def test_a_hundred_openings_leave_no_descriptor_thread_or_task(pty):
    async def cycle() -> None:
        async with open_port(pty.path, read_interval_s=0.0) as port:
            os.write(pty.device, b"x")
            await port.receive()
            with contextlib.suppress(TimeoutError):
                async with asyncio.timeout(0.0):
                    await port.receive()

    await cycle()
    before = (open_fds(), threading.active_count(), len(asyncio.all_tasks()))
    for _ in range(100):
        await cycle()
    assert (open_fds(), threading.active_count(), len(asyncio.all_tasks())) == before


async def test_failed_openings_leave_no_descriptor_or_thread(tmp_path):
    before = (open_fds(), threading.active_count())
    for path in ("/dev/null", str(tmp_path), str(tmp_path / "none")):
        with pytest.raises(TransportOpenError):
            async with open_port(path):
                pass
    assert (open_fds(), threading.active_count()) == before


# Opening that fails says why and what to do


async def opening_error(path: str, **more: object) -> str:
    with pytest.raises(TransportOpenError) as caught:
        async with open_port(path, **more):
            pass
    return str(caught.value)


async def test_a_missing_path_names_cable_and_udev(tmp_path):
    text = await opening_error(str(tmp_path / "left-cane"))
    assert "does not exist" in text
    assert "cable" in text
    assert "udev" in text


@pytest.mark.parametrize("kind", ["file", "folder", "null"])
async def test_what_is_no_serial_port_is_called_so(tmp_path, kind):
    (tmp_path / "file").write_text("")
    path = {"file": tmp_path / "file", "folder": tmp_path, "null": Path("/dev/null")}[kind]
    assert "is no serial port" in await opening_error(str(path))


@pytest.mark.parametrize("code", [errno.EIO, errno.ENXIO, errno.ENODEV])
def test_a_port_that_is_there_but_dead_is_to_be_plugged_in_again(code):
    text = explain("/dev/ttyUSB0", serial.SerialException(code, "dead"))
    assert "does not answer" in text
    assert "plug it in again" in text


async def test_a_port_opened_twice_by_the_gateway_says_so(pty):
    async with open_port(pty.path):
        text = await opening_error(pty.path)
    assert "in use" in text
    assert "configured twice" in text


async def test_a_port_held_by_another_process_names_it(pty):
    pipe = asyncio.subprocess.PIPE
    holder = await asyncio.create_subprocess_exec(
        sys.executable, "-c", HOLD_PORT, pty.path, stdin=pipe, stdout=pipe
    )
    try:
        assert holder.stdout is not None
        await holder.stdout.readline()
        text = await opening_error(pty.path)
    finally:
        await holder.communicate(b"\n")
    assert "in use" in text
    assert f"process {holder.pid}" in text
    async with open_port(pty.path):
        pass


HOLD_PORT = textwrap.dedent("""
    import fcntl, os, sys
    fd = os.open(sys.argv[1], os.O_RDWR | os.O_NOCTTY)
    fcntl.flock(fd, fcntl.LOCK_EX)
    print("held", flush=True)
    sys.stdin.readline()
""")


async def test_an_exclusive_port_locks_others_out_until_it_is_closed(pty):
    async with open_port(pty.path):
        with pytest.raises(BlockingIOError):
            fcntl.flock(pty.slave, fcntl.LOCK_EX | fcntl.LOCK_NB)
        assert is_exclusive(pty.slave)
    fcntl.flock(pty.slave, fcntl.LOCK_EX | fcntl.LOCK_NB)
    assert not is_exclusive(pty.slave)


async def test_a_port_that_is_not_exclusive_can_be_shared(pty):
    async with open_port(pty.path, exclusive=False), open_port(pty.path, exclusive=False):
        assert not is_exclusive(pty.slave)


def is_exclusive(fd: int) -> bool:
    """Tell whether a terminal refuses to be opened again (TIOCGEXCL, which termios lacks)."""
    answer = fcntl.ioctl(fd, 0x80045440, bytes(4))
    return int.from_bytes(answer, sys.byteorder) == 1


AS_NOBODY = textwrap.dedent("""
    import asyncio, os, sys
    from gaitway.api import TransportOpenError
    from gaitway.timebase import HostClock
    from gaitway_drivers.params import SerialParams
    from gaitway_drivers.transports.serial_port import SerialPort

    async def main():
        try:
            async with SerialPort(SerialParams(port=sys.argv[1]), HostClock()):
                print("opened")
        except TransportOpenError as exc:
            print(exc)

    os.setgroups([])
    os.setgid(65534)
    os.setuid(65534)
    asyncio.run(main())
""")

as_root = pytest.mark.skipif(os.geteuid() != 0, reason="only root can become somebody else")


def open_as_nobody(path: str) -> str:
    done = subprocess.run(
        [sys.executable, "-c", AS_NOBODY, path], capture_output=True, text=True, check=True
    )
    return done.stdout


@as_root
def test_without_permission_the_group_is_named(pty):
    os.fchmod(pty.slave, 0o660)
    os.fchown(pty.slave, 0, 20)
    text = open_as_nobody(pty.path)
    assert "permission denied" in text
    assert "group dialout" in text
    assert "usermod -aG dialout" in text


@as_root
def test_without_permission_for_any_group_udev_is_named(pty):
    os.fchmod(pty.slave, 0o600)
    os.fchown(pty.slave, 0, 0)
    text = open_as_nobody(pty.path)
    assert "udev" in text
    assert "usermod" not in text


@as_root
def test_a_port_that_is_exclusive_to_another_is_in_use(pty):
    os.fchmod(pty.slave, 0o666)
    fcntl.ioctl(pty.slave, termios.TIOCEXCL)
    assert "in use by another program" in open_as_nobody(pty.path)


def test_the_transport_type_makes_a_port_for_a_path_and_a_url():
    (kind,) = gaitway_transports()
    made = [
        type(kind.make(SerialParams(port=port), HostClock())).__name__
        for port in ("/dev/ttyUSB0", "socket://localhost:1")
    ]
    assert (kind.name, made) == ("serial", ["SerialPort", "SerialUrl"])


def test_listing_the_drivers_imports_no_third_party_library():
    code = """
import gaitway_drivers, sys
gaitway_drivers.gaitway_transports(), gaitway_drivers.gaitway_codecs()
assert "serial" not in sys.modules and not [m for m in sys.modules if "drivers.codecs" in m]
"""
    subprocess.run([sys.executable, "-c", code], check=True)
