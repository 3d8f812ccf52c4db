"""Every state a device link can be in, and every way out of it. Nothing else decides."""

from enum import Enum, auto
from typing import Final


class LinkState(Enum):
    """How a link is; the values are the names on the bus."""

    CLOSED = "closed"
    OPENING = "opening"
    SYNCING = "syncing"
    STREAMING = "streaming"
    STALE = "stale"
    WAITING = "waiting"


class LinkSignal(Enum):
    """What can happen to a link."""

    START = auto()
    OPENED = auto()
    SAMPLES = auto()
    SILENCE = auto()
    LOST = auto()
    RETRY = auto()
    STOP = auto()


S, E = LinkState, LinkSignal

TRANSITIONS: Final[dict[LinkState, dict[LinkSignal, LinkState]]] = {
    S.CLOSED: {E.START: S.OPENING},
    S.OPENING: {E.OPENED: S.SYNCING, E.LOST: S.WAITING, E.STOP: S.CLOSED},
    S.SYNCING: {
        E.SAMPLES: S.STREAMING,
        E.SILENCE: S.STALE,
        E.LOST: S.WAITING,
        E.STOP: S.CLOSED,
    },
    S.STREAMING: {
        E.SAMPLES: S.STREAMING,
        E.SILENCE: S.STALE,
        E.LOST: S.WAITING,
        E.STOP: S.CLOSED,
    },
    S.STALE: {
        E.SAMPLES: S.STREAMING,
        E.SILENCE: S.STALE,
        E.LOST: S.WAITING,
        E.STOP: S.CLOSED,
    },
    S.WAITING: {E.RETRY: S.OPENING, E.STOP: S.CLOSED},
}


def step(state: LinkState, signal: LinkSignal) -> LinkState:
    """Return the next state; an illegal pair is a bug in the caller, so it raises ``KeyError``."""
    return TRANSITIONS[state][signal]
