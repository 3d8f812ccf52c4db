"""Publishing on zenoh. The only module that imports zenoh for the daemon; it owns its threads.

Events wait in a bounded queue for one thread of ours, which alone calls ``put``: a slow or frozen
subscriber can cost that thread milliseconds (``CongestionControl.DROP``), the device tasks nothing.
"""

import json
import logging
import threading
from collections import deque
from collections.abc import Callable, Iterable, Mapping
from typing import Final

import zenoh

from gaitway.bus.keys import ROOT, event_key, liveliness_key, schema_name
from gaitway.bus.payload import encode
from gaitway.config.schema import BusParams
from gaitway.errors import PublishError
from gaitway.events import EVENT_TYPES, Event
from gaitway.timebase import Clock, WallAnchor

logger = logging.getLogger(__name__)

LARGEST_CLOCK_STEP_S: Final = 0.5
"""A larger step of the wall clock makes a new anchor for what is published from then on."""

MAX_FAILURES_TOLD: Final = 100
"""Different failures that are told as warnings; all further ones are for debugging."""
NO_SUCH_ADDRESS: Final = "os error 99"

ENCODINGS: Final = {
    event_type.kind: zenoh.Encoding.APPLICATION_JSON.with_schema(schema_name(event_type.kind))
    for event_type in EVENT_TYPES
}


def session_config(bus: BusParams) -> zenoh.Config:
    """Return a zenoh configuration that says nothing to the network unless ``bus`` does."""
    config = zenoh.Config()
    settings = {
        "mode": "peer",
        "listen/endpoints": list(bus.listen),
        "connect/endpoints": list(bus.connect),
        "connect/exit_on_failure": False,
        "scouting/multicast/enabled": bus.multicast,
        "scouting/gossip/enabled": bus.multicast,
        # Its segments outlive a kill -9, and a few kilobytes a second gain nothing from it.
        "transport/shared_memory/enabled": False,
    }
    for key, value in settings.items():
        config.insert_json5(key, json.dumps(value))
    return config


class ZenohPublisher:
    """A session, one key per device and kind, a liveliness token per streaming device.

    It also answers ``get`` on those keys with the newest event of each (or the newest ``n`` with
    the parameter ``last=n``), so that an application has history after its own restart.

    Args:
        bus: Endpoints and bounds.
        site: First chunk of the keys.
        device_types: Id of each device to its type.
        run: Identity of this run.
        clock: For wall-clock times in payloads.

    Raises:
        PublishError: The session can't be opened; the text says why and what to change.
    """

    def __init__(
        self, bus: BusParams, site: str, device_types: Mapping[str, str], run: str, clock: Clock
    ) -> None:
        self._site, self._device_types, self._run, self._clock = site, device_types, run, clock
        self._anchor = WallAnchor.take(clock)
        self._queue: deque[tuple[str, Event]] = deque()
        self._wanted_alive: dict[str, bool] = {}
        self._capacity = bus.queue_events
        self._dropped = 0
        self._failures_told: set[str] = set()
        self._wake = threading.Condition()
        self._closing = False
        self._sequences: dict[str, int] = {}
        self._tokens: dict[str, zenoh.LivelinessToken] = {}
        self._history_events = bus.history_events
        self._history: dict[str, deque[tuple[bytes, zenoh.Encoding]]] = {}
        self._history_lock = threading.Lock()
        self._session = _open(bus)
        self._queryable = self._session.declare_queryable(
            f"{ROOT}/{site}/**", zenoh.handlers.Callback(self._answer, indirect=False)
        )
        self._thread = threading.Thread(
            target=self._run_thread, name="gaitway-publish", daemon=True
        )
        self._thread.start()

    @property
    def dropped(self) -> int:
        """How many events were dropped because the bus was slower than they came."""
        return self._dropped

    @property
    def healthy(self) -> bool:
        """Whether the publishing thread lives."""
        return self._thread.is_alive()

    def publish(self, device: str, event: Event) -> None:
        """Hand over an event; the oldest waiting one is dropped when the queue is full."""
        with self._wake:
            if len(self._queue) >= self._capacity:
                self._queue.popleft()
                self._dropped += 1
            self._queue.append((device, event))
            self._wake.notify()

    def set_alive(self, device: str, *, alive: bool) -> None:
        """Declare or withdraw the device's liveliness token; this is never dropped."""
        with self._wake:
            self._wanted_alive[device] = alive
            self._wake.notify()

    def close(self, timeout_s: float) -> None:
        """Publish what waits, within the time given, and leave the bus."""
        with self._wake:
            self._closing = True
            self._wake.notify()
        self._thread.join(timeout_s)
        self._session.close()  # type: ignore[no-untyped-call]  # zenoh's stub forgot -> None

    def _run_thread(self) -> None:
        while True:
            with self._wake:
                while not (self._queue or self._wanted_alive or self._closing):
                    self._wake.wait()
                wanted, self._wanted_alive = self._wanted_alive, {}
                event = self._queue.popleft() if self._queue else None
            for device, alive in wanted.items():
                self._try(self._set_token, device, alive)
            if event is not None:
                self._try(self._put, *event)
            elif not wanted:
                return

    def _try(self, do: Callable[..., None], *arguments: object) -> None:
        """Do something on the bus; what fails costs itself and not this thread."""
        try:
            do(*arguments)
        except Exception as exc:  # noqa: BLE001
            # Not zenoh alone: an event of a stranger's kind or time may have no payload.
            self._dropped += 1
            first = str(exc) not in self._failures_told
            logger.log(logging.WARNING if first else logging.DEBUG, "not published: %r", exc)
            if len(self._failures_told) < MAX_FAILURES_TOLD:
                self._failures_told.add(str(exc))

    def _put(self, device: str, event: Event) -> None:
        if abs(self._anchor.stepped_by_s(self._clock)) > LARGEST_CLOCK_STEP_S:
            self._anchor = WallAnchor.take(self._clock)
        key = event_key(self._site, device, event.kind)
        sequence = self._sequences.get(key, 0)
        self._sequences[key] = sequence + 1
        payload = encode(
            event,
            device=device,
            device_type=self._device_types[device],
            run=self._run,
            sequence=sequence,
            anchor=self._anchor,
        )
        encoding = ENCODINGS[event.kind]
        with self._history_lock:
            kept = self._history.setdefault(key, deque(maxlen=self._history_events))
            kept.append((payload, encoding))
        self._session.put(
            key, payload, encoding=encoding, congestion_control=zenoh.CongestionControl.DROP
        )

    def _set_token(self, device: str, alive: bool) -> None:
        token = self._tokens.pop(device, None)
        if alive:
            self._tokens[device] = token or self._session.liveliness().declare_token(
                liveliness_key(self._site, device)
            )
        elif token is not None:
            token.undeclare()  # type: ignore[no-untyped-call]  # zenoh's stub forgot -> None

    def _answer(self, query: zenoh.Query) -> None:
        """Reply with the newest events of every key the query matches, oldest first."""
        with query:
            try:
                last = max(0, int(query.parameters.get("last") or "1"))
            except ValueError:
                query.reply_err(f"last={query.parameters.get('last')!r} is not a number")
                return
            for key, payload, encoding in self._newest(query.key_expr, last):
                query.reply(key, payload, encoding=encoding)

    def _newest(
        self, key_expr: zenoh.KeyExpr, last: int
    ) -> Iterable[tuple[str, bytes, zenoh.Encoding]]:
        with self._history_lock:
            return [
                (key, payload, encoding)
                for key, kept in self._history.items()
                if key_expr.intersects(zenoh.KeyExpr(key))
                for payload, encoding in list(kept)[len(kept) - min(last, len(kept)) :]
            ]


def _open(bus: BusParams) -> zenoh.Session:
    """Open the session; an address that this machine does not have (yet) is left out."""
    config = session_config(bus)
    try:
        return zenoh.open(config)
    except zenoh.ZError as exc:
        if NO_SUCH_ADDRESS not in str(exc):
            raise PublishError(_why_not_open(bus, exc)) from exc
    logger.warning(
        "bus.listen: not every address of %s is this machine's now; serving the others "
        "(tcp/0.0.0.0:PORT holds whatever address it gets)",
        ", ".join(bus.listen),
    )
    config.insert_json5("listen/exit_on_failure", "false")
    config.insert_json5("listen/timeout_ms", "0")
    try:
        return zenoh.open(config)
    except zenoh.ZError as exc:
        raise PublishError(_why_not_open(bus, exc)) from exc


def _why_not_open(bus: BusParams, exc: zenoh.ZError) -> str:
    text = str(exc)
    if "Address already in use" in text or "os error 98" in text:
        return (
            f"bus.listen: {', '.join(bus.listen)} is taken, probably by another gaitway or zenohd "
            "(stop it, or set another port in [bus] listen)"
        )
    text = text.partition(" at /")[0]  # where in zenoh's sources
    return f"bus: the zenoh session can't be opened: {text} (check [bus] listen and connect)"
