"""The leg of a person and where its foot stands while walking."""

from dataclasses import dataclass
from typing import Self

import numpy as np

from gaitway.simulation.person import Person
from gaitway.simulation.sole import Sole


@dataclass(frozen=True, slots=True)
class Footfall:
    """One time the foot is on the floor.

    Attributes:
        contact_s: Heel strike; for the first footfall when the person begins to move.
        off_s: Toe-off; for the last footfall when the person stands again.
        x_m: Where in n the ankle is above the floor with the foot flat.
        y_m: The same.
        yaw_rad: Where the foot points.
        reach: The stride that ends here relative to a usual one.
        push: The stride that begins here, likewise.
        z_m: Height of the floor: stairs.
    """

    contact_s: float
    off_s: float
    x_m: float
    y_m: float
    yaw_rad: float
    reach: float
    push: float
    z_m: float = 0.0

    def at(self, share: float) -> float:
        """Return the time at a share of the stance."""
        return self.contact_s + share * (self.off_s - self.contact_s)


@dataclass(frozen=True, slots=True)
class Leg:
    """The leg of one person.

    Attributes:
        sole: Outline of the shod foot.
        side: 1 for the left leg, -1 for the right.
        range_factor: Range of the angles relative to the average person's.
        stand_rad: Forward lean of the shank when standing.
        bow_rad: Lean of the shank to the outside when loaded.
        flesh: How much the sensor wobbles on muscle and skin at contact; 1 is average.
        variation: Relative standard deviation of angles from step to step.
    """

    sole: Sole
    side: float
    range_factor: float
    stand_rad: float
    bow_rad: float
    flesh: float
    variation: float

    @classmethod
    def draw(cls, person: Person, rng: np.random.Generator) -> Self:
        """Return a leg of a person.

        Ankle height 0.039 and foot length 0.152 of body height (Winter 2009, after Drillis and
        Contini), on a shoe of 1.5 to 3 cm. The ankle is above a quarter of the foot's length; the
        foot leaves the floor over the toes, at 0.85 of it.
        """
        foot_m = 0.152 * person.height_m
        shoe_m = float(rng.uniform(0.015, 0.03))
        return cls(
            sole=Sole(
                ankle_m=0.039 * person.height_m + shoe_m,
                heel_m=0.17 * foot_m,
                ball_m=0.6 * foot_m,
                heel_radius_m=float(rng.uniform(0.02, 0.03)),
                ball_radius_m=float(rng.uniform(0.03, 0.06)),
                softness_m=float(rng.uniform(0.001, 0.003)),
            ),
            side=float(rng.choice([-1.0, 1.0])),
            range_factor=float(np.clip(rng.normal(1.0, 0.07), 0.85, 1.15)),
            stand_rad=float(rng.normal(0.05, 0.02)),
            bow_rad=float(rng.normal(0.03, 0.02)),
            flesh=float(rng.uniform(0.6, 1.4)),
            variation=0.5 * person.length_variation,
        )
