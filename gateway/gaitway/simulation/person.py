"""Who walks: what differs from person to person and from step to step, drawn from a seed."""

from dataclasses import dataclass
from typing import Self

import numpy as np

from gaitway.simulation.curves import Curve, Tremor


def stream(seed: int, name: str, repetition: int = 0) -> np.random.Generator:
    """Return the random numbers of one purpose: those of other purposes leave them as they are.

    Args:
        seed: Of the plan.
        name: Purpose, for example ``"sensor"``.
        repetition: Of the plan, for what differs from walk to walk of the same person.
    """
    again = [repetition] if repetition else []
    return np.random.default_rng([seed, *name.encode(), *again])


@dataclass(frozen=True, slots=True)
class Person:
    """A person's body and habits.

    Attributes:
        height_m: Standing height, 1.5 to 1.9 m.
        pace: Preferred speed relative to the average of their kind, 0.75 to 1.25.
        length_variation: Relative standard deviation from one stride length to the next; healthy
            adults 2 to 3 %, with a walking aid more.
        time_variation: The same of stride times.
        posture_pitch_rad: How a device is habitually held, forward positive.
        posture_roll_rad: The same to the right.
        tremor_hz: Of the hand; physiological tremor lies at 6 to 10 Hz.
        tremor_rad: Amplitude with which it turns a device held in the air.
    """

    height_m: float
    pace: float
    length_variation: float
    time_variation: float
    posture_pitch_rad: float
    posture_roll_rad: float
    tremor_hz: float
    tremor_rad: float

    @classmethod
    def draw(cls, seed: int) -> Self:
        """Return the person of a seed."""
        rng = stream(seed, "person")
        return cls(
            height_m=float(rng.uniform(1.5, 1.9)),
            pace=float(np.clip(rng.normal(1.0, 0.12), 0.75, 1.25)),
            length_variation=float(rng.uniform(0.02, 0.06)),
            time_variation=float(rng.uniform(0.02, 0.05)),
            posture_pitch_rad=float(rng.normal(0.0, 0.02)),
            posture_roll_rad=float(rng.normal(0.0, 0.02)),
            tremor_hz=float(rng.uniform(6.0, 10.0)),
            tremor_rad=float(rng.uniform(2e-4, 1.2e-3)),
        )

    def tremor(self, envelope: Curve, rng: np.random.Generator) -> Tremor:
        """Return the trembling of yaw, pitch and roll under an envelope between 0 and 1."""
        frequencies_hz = self.tremor_hz * np.array([0.83, 1.0, 1.31])
        weights = rng.uniform(0.2, 0.6, (3, 3)) * np.array([0.5, 1.0, 1.0])
        phases_rad = rng.uniform(0.0, 2.0 * np.pi, (3, 3))
        return Tremor(envelope, self.tremor_rad * weights, frequencies_hz.tolist(), phases_rad)
