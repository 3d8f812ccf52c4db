"""Telling systemd how the daemon is, over the socket it names in the environment."""

import os
import socket
from typing import Final

MICROSECONDS_PER_SECOND: Final = 1e6


def notify(state: str) -> bool:
    """Send a state such as ``READY=1``; return False where nobody asked for it.

    Args:
        state: Assignments as in ``sd_notify(3)``, one a line.
    """
    address = os.environ.get("NOTIFY_SOCKET")
    if not address:
        return False
    if address.startswith("@"):
        address = "\0" + address[1:]  # an abstract socket
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM | socket.SOCK_CLOEXEC) as sock:
        try:
            sock.sendto(state.encode(), address)
        except OSError:
            return False
    return True


def watchdog_interval_s() -> float | None:
    """Return how often to send ``WATCHDOG=1`` (half of what systemd allows), None for never."""
    allowed_us = os.environ.get("WATCHDOG_USEC")
    meant_for = os.environ.get("WATCHDOG_PID")
    if not allowed_us or (meant_for and meant_for != str(os.getpid())):
        return None
    return float(allowed_us) / MICROSECONDS_PER_SECOND / 2
