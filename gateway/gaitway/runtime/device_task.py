"""One device's life: open, pump, notice silence, lose, wait, open again; for ever."""

import asyncio
import logging
from collections.abc import Callable
from typing import Final

from gaitway.config.load import ResolvedDevice
from gaitway.contracts import Transport
from gaitway.errors import TransportError, TransportLostError
from gaitway.runtime.backoff import Backoff
from gaitway.runtime.checkpoint import Checkpoint
from gaitway.runtime.health import Surroundings
from gaitway.runtime.link_state import LinkSignal, LinkState, step
from gaitway.runtime.outlet import Outlet
from gaitway.runtime.pipeline import Pipeline
from gaitway.samples import Chunk
from gaitway.timebase import NS_PER_S, Clock

logger = logging.getLogger(__name__)

TICK_S: Final = 0.05
"""How often the codec sees time pass while a handshake is going on."""
IDLE_TICK_S: Final = 0.5
"""The same while samples flow: silence is noticed in time, and it costs nothing."""
SILENCE_S: Final = 2.0
"""An open link without samples for this long is reported as stale."""
REOPEN_AFTER_S: Final = 10.0
"""An open link without samples for this long is closed and opened again."""
STATUS_EVERY_S: Final = 5.0
HOST_DELAY_S: Final = 0.5
"""A busy host may wake this much late."""


class DeviceTask:
    """Runs one device until cancelled.

    Args:
        device: What is configured.
        clock: The host's clock.
        out: Where everything goes.
        surroundings: Returns what a status says about the rest of the gateway.
        checkpoint: Where its state is kept over a restart; nowhere where None.
    """

    def __init__(
        self,
        device: ResolvedDevice,
        clock: Clock,
        out: Outlet,
        surroundings: Callable[[], Surroundings],
        checkpoint: Checkpoint | None = None,
    ) -> None:
        self._device, self._clock, self._out = device, clock, out
        self._surroundings = surroundings
        self._id = device.config.id
        self._checkpoint = checkpoint
        self._pipeline = Pipeline(device, out, checkpoint)
        self._backoff = Backoff()
        self._state = LinkState.CLOSED
        self._told = (LinkState.CLOSED, "not started yet")
        self._since_ns = clock.now_ns()
        self._status_due_ns = 0
        self._quiet_since_ns = 0
        self._failures = 0
        self._streamed = False

    async def run(self) -> None:
        """Keep the device's samples flowing until cancelled; then keep its state, or finish."""
        now_ns = self._clock.now_ns()
        state = self._checkpoint.load(now_ns) if self._checkpoint else None
        if state is not None:
            self._pipeline.resume(state)
        self._signal(LinkSignal.START, "opening")
        try:
            while True:
                await self._attempt()
        finally:
            self._pipeline.stop(self._clock.now_ns())
            self._signal(LinkSignal.STOP, "the gateway stopped")

    async def _attempt(self) -> None:
        """Run the link until it is lost, then wait before the next attempt."""
        try:
            await self._session()
        except TransportError as exc:
            reason = str(exc)
        except asyncio.CancelledError:
            task = asyncio.current_task()
            if task is not None and task.cancelling():
                raise  # the gateway stops
            reason = "the driver cancelled itself (a bug in it; see the log)"
        except Exception as exc:
            # A stranger's codec or transport may raise anything; it must cost only its own device.
            if not self._failures:
                logger.exception("%s: driver failed", self._id)
            reason = f"the driver failed: {type(exc).__name__}: {exc} (a bug; see the log)"
        delay_s = self._backoff.next_delay_s()
        self._failures += 1
        news = self._failures == 1 or reason != self._told[1]
        level = logging.WARNING if news else logging.DEBUG
        logger.log(level, "%s: %s; trying again until it works", self._id, reason)
        self._signal(LinkSignal.LOST, reason)
        await self._clock.sleep(delay_s)
        self._signal(LinkSignal.RETRY, reason)

    async def _session(self) -> None:
        transport = self._device.transport_type.make(self._device.transport_params, self._clock)
        async with transport:
            now_ns = self._clock.now_ns()
            self._signal(LinkSignal.OPENED, "open, waiting for samples", now_ns)
            self._quiet_since_ns = now_ns
            try:
                await self._send(transport, self._pipeline.link_opened(now_ns))
                await self._pump(transport)
            finally:
                self._pipeline.link_lost(self._clock.now_ns())

    async def _pump(self, transport: Transport) -> None:
        ticked_ns = self._clock.now_ns()
        while True:
            timeout_s = IDLE_TICK_S if self._state is LinkState.STREAMING else TICK_S
            before_ns = self._clock.now_ns()
            chunk = await _receive(transport, timeout_s)
            now_ns = self._clock.now_ns()
            # A host that slept or was stopped can't blame the device for the silence meanwhile.
            asleep_ns = now_ns - before_ns - round((timeout_s + HOST_DELAY_S) * NS_PER_S)
            self._quiet_since_ns += max(0, asleep_ns)
            if chunk is not None:
                await self._send(transport, self._pipeline.feed(chunk))
                self._note_samples(now_ns)
            if now_ns - ticked_ns >= TICK_S * NS_PER_S:
                ticked_ns = now_ns
                await self._send(transport, self._pipeline.on_time(now_ns))
            if self._pipeline.failure is not None:
                raise TransportLostError(self._pipeline.failure)
            self._note_silence(now_ns)
            if now_ns >= self._status_due_ns:
                self._emit_status(now_ns)

    async def _send(self, transport: Transport, commands: list[bytes]) -> None:
        for command in commands:
            await transport.send(command)

    def _note_samples(self, now_ns: int) -> None:
        if not self._pipeline.sampled:
            return
        self._quiet_since_ns = now_ns
        if self._state is not LinkState.STREAMING:
            if self._failures:
                logger.info("%s: samples flow again", self._id)
                self._pipeline.health.reconnects += bool(self._streamed)
            self._streamed = True
            self._failures = 0
            self._backoff.succeeded()
            self._signal(LinkSignal.SAMPLES, "samples flow")

    def _note_silence(self, now_ns: int) -> None:
        quiet_s = (now_ns - self._quiet_since_ns) / NS_PER_S
        if quiet_s >= REOPEN_AFTER_S:
            raise TransportLostError(f"{self._why_silent()}; the link is opened again")
        if quiet_s >= SILENCE_S and self._state is not LinkState.STALE:
            self._signal(LinkSignal.SILENCE, self._why_silent())

    def _why_silent(self) -> str:
        if self._state is LinkState.STREAMING or self._pipeline.health.samples:
            return "the link is open but no samples come (is the device on, its battery charged?)"
        if self._pipeline.health.bytes_received:
            return "bytes come but no samples in them (wrong baud, codec or device settings?)"
        return "the link is open but nothing comes (is the device on, the right port named?)"

    def _signal(self, signal: LinkSignal, reason: str, now_ns: int | None = None) -> None:
        """Change the link's state; say so where it is news.

        While a device stays away, each new attempt is no news: its last reason is told again only
        as often as any status.
        """
        now_ns = self._clock.now_ns() if now_ns is None else now_ns
        state = step(self._state, signal)
        self._state = state
        if state is LinkState.OPENING and self._failures:
            return
        if (state, reason) != self._told:
            if state is not self._told[0]:
                self._since_ns = now_ns
            self._told = (state, reason)
            self._out.link(self._id, now_ns, state.value, reason)
            self._emit_status(now_ns)
        elif now_ns >= self._status_due_ns:
            self._emit_status(now_ns)

    def _emit_status(self, now_ns: int) -> None:
        self._pipeline.health.measure_rate(now_ns)
        self._status_due_ns = now_ns + round(STATUS_EVERY_S * NS_PER_S)
        status = self._pipeline.health.status(
            now_ns,
            link=self._told[0].value,
            reason=self._told[1],
            since_t_ns=self._since_ns,
            latency_s=self._pipeline.latency_s,
            surroundings=self._surroundings(),
        )
        self._out.event(self._id, status)


async def _receive(transport: Transport, timeout_s: float) -> Chunk | None:
    """Return the next bytes, or None when none came in time."""
    try:
        async with asyncio.timeout(timeout_s) as limit:
            return await transport.receive()
    except TimeoutError as exc:
        if not limit.expired():  # the transport's own, as OSError(ETIMEDOUT) is one
            raise TransportLostError(f"the link timed out: {exc}") from exc
        return None
