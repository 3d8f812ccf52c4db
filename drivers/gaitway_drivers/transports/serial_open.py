"""Opening serial ports: never on the event loop's time, and failing with a text that helps."""

import asyncio
import contextlib
import errno
import fcntl
import grp
import os
import stat
import termios
import threading
from collections.abc import Callable
from pathlib import Path
from typing import Final, TypeVar

import serial

from gaitway.api import TransportOpenError
from gaitway_drivers.params import SerialParams

T = TypeVar("T")

CONNECT_TIMEOUT_S: Final = 6.0
"""Opening gives up after this; pyserial's own limit for a socket is 5 s."""
WRITE_TIMEOUT_S: Final = 1.0
BUSY: Final = (errno.EBUSY, errno.EAGAIN)
GONE: Final = (errno.EIO, errno.ENXIO, errno.ENODEV)


def open_tty(params: SerialParams) -> serial.Serial:
    """Return an open port that has a file descriptor, raw and non-blocking. May block.

    DTR and RTS are raised, by the kernel and again by pyserial, and stay so until it is closed.

    Raises:
        TransportOpenError: What is wrong and what to do about it.
    """
    try:
        _check_path(params.port)
        port = serial.Serial(
            params.port, params.baud, timeout=0, exclusive=True if params.exclusive else None
        )
    except (OSError, ValueError) as exc:
        raise TransportOpenError(explain(params.port, exc)) from exc
    try:
        _set_up(port.fileno(), exclusive=params.exclusive)
    except (OSError, termios.error) as exc:
        port.close()
        raise TransportOpenError(explain(params.port, exc)) from exc
    return port


def close_tty(port: serial.Serial) -> None:
    """Close a port at once, without waiting for bytes it has not sent."""
    if port.is_open:
        with contextlib.suppress(OSError, termios.error):  # it may be gone already
            fcntl.ioctl(port.fileno(), termios.TIOCNXCL)
            termios.tcflush(port.fileno(), termios.TCOFLUSH)
        port.close()


def open_url(params: SerialParams) -> serial.Serial:
    """Return an open port that pyserial reaches by URL. May block for seconds.

    Raises:
        TransportOpenError: What is wrong and what to do about it.
    """
    try:
        port = serial.serial_for_url(
            params.port,
            params.baud,
            timeout=0,
            write_timeout=WRITE_TIMEOUT_S,
        )
    except (OSError, ValueError) as exc:
        raise TransportOpenError(
            f"{params.port} can't be opened: {exc} (check name, network and the other end)"
        ) from exc
    return port


def close_url(port: serial.Serial) -> None:
    """Close a port; one that is gone already may raise anything, of which nobody can use any."""
    with contextlib.suppress(Exception):
        port.close()


async def open_in_thread(
    name: str, open_port: Callable[[], T], close_port: Callable[[T], None]
) -> T:
    """Return what a blocking call opened in a thread of its own, which is gone by then.

    Given up or cancelled, the thread closes what it still gets.

    Raises:
        TransportOpenError: It took too long, or ``open_port`` raised it.
    """
    loop = asyncio.get_running_loop()
    opened: asyncio.Future[T] = loop.create_future()

    def settle(port: T | None, failure: Exception | None) -> None:
        if opened.done():
            if port is not None:
                close_port(port)
        elif failure is not None:
            opened.set_exception(failure)
        elif port is not None:
            opened.set_result(port)

    def work() -> None:
        port, failure = None, None
        try:
            port = open_port()
        except Exception as exc:  # noqa: BLE001 - it is raised again where the call was made
            failure = exc
        try:
            loop.call_soon_threadsafe(settle, port, failure)
        except RuntimeError:  # the loop was closed meanwhile
            if port is not None:
                close_port(port)

    thread = threading.Thread(target=work, name=name, daemon=True)
    thread.start()
    try:
        async with asyncio.timeout(CONNECT_TIMEOUT_S):
            port = await opened
    except TimeoutError as exc:
        raise TransportOpenError(
            f"{name}: not open after {CONNECT_TIMEOUT_S:.0f} s; unplug it and plug it in again"
        ) from exc
    finally:
        if opened.done() and not opened.cancelled():
            thread.join()
    return port


def explain(port: str, exc: Exception) -> str:
    """Return what went wrong opening a port, and what to do about it."""
    code = _errno(exc)
    if code == errno.ENOENT:
        return (
            f"{port} does not exist: check cable and power; ls /dev/serial/by-id shows what is "
            "there, and names under /dev/gaitway come from a udev rule"
        )
    if code in (errno.EACCES, errno.EPERM):
        return f"{port}: permission denied: {_permission_remedy(port)}"
    if code in BUSY:
        return f"{port} is in use {_holder(port)}: stop that program, or name another port"
    if code == errno.ENOTTY:
        return f"{port} is no serial port: name one such as /dev/ttyUSB0 or /dev/gaitway/left-cane"
    if code in GONE:
        return f"{port} is there but does not answer ({exc}): unplug it and plug it in again"
    return f"{port} can't be opened: {exc}"


def _set_up(fd: int, *, exclusive: bool) -> None:
    attributes = termios.tcgetattr(fd)
    # Without a minimum of one byte, reading nothing could not be told from the end of the line.
    attributes[6][termios.VMIN] = 1
    termios.tcsetattr(fd, termios.TCSANOW, attributes)
    if exclusive:
        # The lock pyserial takes binds only programs that ask for one; this binds all but root's.
        fcntl.ioctl(fd, termios.TIOCEXCL)


def _check_path(port: str) -> None:
    """Raise the OSError that says it best, where pyserial's would say less."""
    if not stat.S_ISCHR(Path(port).stat().st_mode):
        raise OSError(errno.ENOTTY, "not a character device")


def _errno(exc: BaseException) -> int | None:
    """Return the error number of an exception, or of the one it was raised for."""
    code = getattr(exc, "errno", None)
    if code is None and isinstance(exc, termios.error):
        code = exc.args[0]
    if code is None and exc.__context__ is not None:
        return _errno(exc.__context__)
    return code if isinstance(code, int) else None


def _permission_remedy(port: str) -> str:
    try:
        group = grp.getgrgid(Path(port).stat().st_gid).gr_name
    except (OSError, KeyError):
        group = "dialout"
    if group == "root":
        return "let a udev rule give it to the group dialout, and add the gateway's user to that"
    return (
        f"add the user of the gateway to the group {group} (sudo usermod -aG {group} USER) and "
        "start it anew, or let a udev rule give access"
    )


def _holder(port: str) -> str:
    """Return who has the port open, as far as /proc lets us see."""
    target = os.path.realpath(port)
    holder = "by another program"
    for process in Path("/proc").glob("[0-9]*"):
        try:
            held = any(str(fd.readlink()) == target for fd in (process / "fd").iterdir())
            name = (process / "comm").read_text().strip()
        except OSError:  # not ours to look at, or gone meanwhile
            continue
        if held and process.name != str(os.getpid()):
            return f"by {name} (process {process.name})"
        if held:
            holder = "by this gateway itself (is the port configured twice?)"
    return holder
