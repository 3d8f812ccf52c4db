"""A device on a pseudo-terminal: a simulated walk, told by a simulated peripheral in real time."""

import select
from collections.abc import Callable, Mapping
from pathlib import Path
from types import TracebackType
from typing import Final, Self

from gaitway.contracts import Peripheral, SimulatedWalk
from gaitway.samples import Floats
from gaitway.testing.pty_port import PtyPort
from gaitway.timebase import NS_PER_S, Clock

LOOK_FOR_HOST_S: Final = 0.1


class SimulatedDevice:
    """Plays walks on a port, answering the host all along; the cable can be pulled and put back.

    The first walk begins when the host has started the measurement: the person waits for it. From
    then on device time runs whether anybody listens or not.

    Args:
        link: Path of the port.
        peripheral: What speaks.
        clock: Real time.

    Attributes:
        samples: Played so far.
    """

    def __init__(self, link: Path, peripheral: Peripheral, clock: Clock) -> None:
        self._link, self._peripheral, self._clock = link, peripheral, clock
        self._port: PtyPort | None = PtyPort(link)
        self._plugged = True
        self._started_ns: int | None = None
        self._rate_hz = 1.0
        self._stopped = False
        self.samples = 0
        self._write(peripheral.start())

    def __enter__(self) -> Self:
        """Return the device."""
        return self

    def __exit__(
        self,
        exc_type: type[BaseException] | None,
        exc: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        """Unplug."""
        self._plugged = False
        self._obey_cable()

    @property
    def elapsed_s(self) -> float:
        """Device time since the first sample."""
        return self.samples / self._rate_hz

    def plug(self) -> None:
        """Put the cable in, from any thread: the port appears at the next sample."""
        self._plugged = True

    def unplug(self) -> None:
        """Pull the cable, from any thread: at the next sample the port hangs up and goes.

        The device measures on.
        """
        self._plugged = False

    def stop(self) -> None:
        """End the present ``play`` at its next sample, from any thread."""
        self._stopped = True

    def play(self, walk: SimulatedWalk, on_stride: Callable[[int], None] | None = None) -> None:
        """Send every sample of a walk when it is due.

        Args:
            walk: What to play; its rate must be the peripheral's.
            on_stride: Called with the number of each true stride as it ends.
        """
        self._rate_hz = walk.rate_hz
        told = 0
        for row in range(len(walk.pos_n)):
            channels = {name: values[row] for name, values in walk.channels.items()}
            while not self._send(channels):
                if self._stopped:
                    return
                self._answer(LOOK_FOR_HOST_S)
            while told < len(walk.stride_end_s) and walk.stride_end_s[told] <= row / walk.rate_hz:
                if on_stride is not None:
                    on_stride(told)
                told += 1

    def _send(self, channels: Mapping[str, Floats]) -> bool:
        """Send one sample at its time; return False while the device was never started."""
        if self._started_ns is not None:
            due_ns = self._started_ns + round(self.samples * NS_PER_S / self._rate_hz)
            while (wait_ns := due_ns - self._clock.now_ns()) > 0:
                self._answer(wait_ns / NS_PER_S)
        if self._stopped:
            return False
        self._obey_cable()
        data = self._peripheral.encode(self.samples, channels)
        if self._started_ns is None:
            if not data:
                return False
            self._started_ns = self._clock.now_ns()
        self._write(data)
        self.samples += 1
        return True

    def _obey_cable(self) -> None:
        if self._plugged and self._port is None:
            self._port = PtyPort(self._link)
        elif not self._plugged and self._port is not None:
            self._port.unplug()
            self._port = None

    def _write(self, data: bytes) -> None:
        if self._port is not None:
            self._port.write(data)

    def _answer(self, timeout_s: float) -> None:
        port = self._port
        if port is None:
            select.select([], [], [], timeout_s)
        elif port.wait(timeout_s):
            port.write(self._peripheral.feed(port.read()))
