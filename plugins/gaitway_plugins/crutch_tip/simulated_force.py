"""How a simulated person loads a crutch: a double hump a stance."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from gaitway.api import Floats
from gaitway_plugins.crutch_tip.simulated_gait import Stance

CONTACT_NEWTON: Final = 25.2
"""Where the paper takes a stance to begin and end."""
RISE_SHARE: Final = 0.25
"""Share of a stance over which the force rises, and again falls; a second at most counts."""
DIP: Final = 0.2
"""By this share the force falls between the two humps."""


@dataclass(frozen=True, slots=True)
class Loading:
    """The force of one stance.

    Attributes:
        start_s: When it begins to rise.
        end_s: When it is gone.
        peak_newton: At the humps.
    """

    start_s: float
    end_s: float
    peak_newton: float

    def __call__(self, t_s: Floats) -> Floats:
        """Return the axial force, newtons, shape (n,)."""
        length_s = self.end_s - self.start_s
        rise_s = RISE_SHARE * min(length_s, 1.0)
        rising = _smooth((t_s - self.start_s) / rise_s) * _smooth((self.end_s - t_s) / rise_s)
        middle = np.clip((t_s - self.start_s - rise_s) / (length_s - 2.0 * rise_s), 0.0, 1.0)
        force: Floats = self.peak_newton * rising * (1.0 - DIP * np.sin(np.pi * middle) ** 2)
        return force


def loads_of(stances: Sequence[Stance], duration_s: float) -> list[Loading]:
    """Return the load of each stance; the crutch is taken in hand and let go at rest."""
    ends_s = [*(stance.lift_s for stance in stances[:-1]), duration_s - 0.2]
    starts_s = [0.2, *(stance.contact_s for stance in stances[1:])]
    return [
        Loading(start_s, end_s, stance.peak_newton)
        for start_s, end_s, stance in zip(starts_s, ends_s, stances, strict=True)
    ]


def force_at(loads: Sequence[Loading], t_s: Floats) -> Floats:
    """Return the axial force at some times, newtons, shape (n,)."""
    force: Floats = np.max([load(t_s) for load in loads], axis=0, initial=0.0)
    return force


def passing_times_s(load: Loading) -> tuple[float, float]:
    """Return when the force rises above ``CONTACT_NEWTON`` and when it has fallen below."""
    fine_s = np.linspace(load.start_s, load.end_s, 4000)
    above = fine_s[load(fine_s) >= CONTACT_NEWTON]
    return float(above[0]), float(above[-1])


def _smooth(share: Floats) -> Floats:
    inside = np.clip(share, 0.0, 1.0)
    step: Floats = inside * inside * (3.0 - 2.0 * inside)
    return step
