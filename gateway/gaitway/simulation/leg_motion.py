"""Walking of one leg: heel strike, flat foot, push-off and swing, as motion of the shank.

In stance the foot rolls over the floor without slipping (``Sole``) and the shank turns over the
ankle; in swing the ankle flies with least jerk from where rolling left it to where rolling takes
it up again. Angles of a usual stride are those of healthy adults at their own speed (Winter 2009,
Perry and Burnfield 2010), rounded; longer and shorter strides scale them.
"""

from collections.abc import Sequence
from itertools import pairwise
from typing import Final

import numpy as np
from numpy.typing import NDArray

from gaitway.samples import Floats
from gaitway.simulation.curves import Shocks, Stacked, Sum
from gaitway.simulation.leg import Footfall, Leg
from gaitway.simulation.motion import RigidMotion
from gaitway.simulation.sole import Sole
from gaitway.simulation.spline import Knot, Spline, rest, via

LANDING_S: Final = 0.03
"""Heel and shoe take up the speed of landing within this time after contact."""

_UP: Final = np.array([0.0, 0.0, 1.0])

# Share of stance or of swing, and pitch of the shank in a usual stride: radians, forward positive.
_STANCE_PITCH: Final = ((0.145, -0.12), (0.40, 0.08), (0.68, 0.31), (0.90, 0.76))
_SWING_PITCH: Final = ((0.08, 1.02), (0.62, 0.25), (0.93, -0.32))
_CONTACT_PITCH: Final = -0.30
_CONTACT_RATE: Final = 1.5

# Pitch of the foot at contact and at toe-off, heel up positive; the foot is flat in between.
_FOOT_CONTACT: Final = -0.32
_FOOT_CONTACT_RATE: Final = 3.5
_FOOT_OFF: Final = 1.3
_FOOT_OFF_SPEEDUP: Final = 2.1
_FLAT_SHARES: Final = (0.16, 0.58)

# What flight adds to rolling at contact, along, across and up.
_LANDING_MPS: Final = np.array([0.3, 0.0, -0.25])
_LANDING_MPS2: Final = np.array([-8.0, 0.0, 0.0])
_OVER_EDGE: Final = 0.3
"""How far above half-way a foot passes the edge of a stair, as a share of the climb."""
_STRIKE_M: Final = np.array([0.7e-3, 0.5e-3, 1.2e-3])
_WOBBLE_RAD: Final = np.array([0.035, 0.01, 0.012])


def leg_motion(footfalls: Sequence[Footfall], leg: Leg, rng: np.random.Generator) -> RigidMotion:
    """Return the motion of a shank: origin of d the ankle joint, x forward, z up the shank.

    Args:
        footfalls: At least two: standing, steps in order, standing again.
        leg: Of the person.
        rng: Draws how steps differ.
    """
    jitter = 1.0 + leg.variation * rng.standard_normal((len(footfalls), 2))
    reach = jitter[:, 0] * np.array([_range_of(step.reach, leg) for step in footfalls])
    push = jitter[:, 1] * np.array([_range_of(step.push, leg) for step in footfalls])
    ankle = AnklePath(footfalls, Spline(_foot_knots(footfalls, reach, push, leg.sole)), leg.sole)
    angles = Stacked(
        Spline(_yaw_knots(footfalls)),
        Spline(_pitch_knots(footfalls, reach, push, leg)),
        Spline(_roll_knots(footfalls, leg, rng)),
    )
    return RigidMotion(
        position=Sum(ankle, _strike(footfalls, reach, rng)),
        angles=Sum(angles, _wobble(footfalls, reach * leg.flesh, rng)),
    )


class AnklePath:
    """Path of the ankle joint in n: rolling in stance, flying in swing.

    Args:
        footfalls: Standing, steps in order, standing again.
        foot: Pitch of the foot over time, one column.
        sole: What it rolls on.
    """

    def __init__(self, footfalls: Sequence[Footfall], foot: Spline, sole: Sole) -> None:
        self._foot = foot
        self._sole = sole
        self._off_s = np.array([step.off_s for step in footfalls[:-1]])
        self._rolls_s = np.array([step.contact_s + LANDING_S for step in footfalls[1:]])
        self._places = np.array([[step.x_m, step.y_m, step.z_m] for step in footfalls])
        yaws = np.array([step.yaw_rad for step in footfalls])
        self._ways = np.stack([np.cos(yaws), np.sin(yaws), np.zeros_like(yaws)], axis=1)
        self._flight = self._fly(footfalls)

    def __call__(self, t_s: Floats, order: int = 0) -> Floats:
        """Return where the ankle is, or its velocity, shape (n, 3)."""
        step = np.searchsorted(self._off_s, t_s)
        rolling = self._rolling(t_s, step, order)
        landed_s = np.concatenate([[-np.inf], self._rolls_s])
        flying = self._flight(t_s, order)
        # Past a toe-off ``step`` is already the footfall to come.
        return np.where((t_s >= landed_s[step])[:, None], rolling, flying)

    def _rolling(self, t_s: Floats, step: NDArray[np.intp], order: int) -> Floats:
        """Return the ankle as a footfall rolls it, also a little before and after it does."""
        pitch = self._foot(t_s)[:, 0]
        height = self._sole.height(pitch)[:, None]
        if order == 0:
            ahead = self._sole.advance(pitch)[:, None] * self._ways[step]
            path: Floats = self._places[step] + ahead + height * _UP
            return path
        rise = self._sole.slope(pitch)[:, None] * _UP
        velocity: Floats = self._foot(t_s, 1) * (height * self._ways[step] + rise)
        return velocity

    def _state(self, t_s: float, step: int) -> Floats:
        """Return position, velocity and acceleration of rolling, shape (3, 3)."""
        beside = np.array([-1e-4, 0.0, 1e-4]) + t_s
        steps = np.full(3, step)
        velocity = self._rolling(beside, steps, 1)
        acceleration = (velocity[2] - velocity[0]) / (beside[2] - beside[0])
        return np.stack([self._rolling(beside, steps, 0)[1], velocity[1], acceleration])

    def _fly(self, footfalls: Sequence[Footfall]) -> Stacked:
        """Return the path between footfalls; what it does during one is not used."""
        stand = self._state(footfalls[0].contact_s, 0)[0]
        ground = [rest(footfalls[0].contact_s, *stand[:2])]
        height = [rest(footfalls[0].contact_s, stand[2])]
        for number, (before, after) in enumerate(pairwise(footfalls), start=1):
            off = self._state(before.off_s, number - 1)
            landing = self._landing(after, number)
            rolling_s = after.contact_s + LANDING_S
            rolling = self._state(rolling_s, number)
            swing_s = after.contact_s - before.off_s
            middle = _least_effort(off[:2, :2], landing[:2, :2], swing_s)
            ground.append(_knot(before.off_s, off[:, :2]))
            ground.append(_knot(before.off_s + 0.5 * swing_s, middle))
            ground.append(_knot(after.contact_s, landing[:, :2]))
            ground.append(_knot(rolling_s, rolling[:, :2]))
            height.append(_knot(before.off_s, off[:, 2:]))
            climb_m = abs(after.z_m - before.z_m)
            carried_m = 0.5 * (off[0, 2] + landing[0, 2]) + _OVER_EDGE * climb_m
            height.append(via(before.off_s + 0.5 * swing_s, carried_m))
            height.append(_knot(after.contact_s, landing[:, 2:]))
            height.append(_knot(rolling_s, rolling[:, 2:]))
        last = footfalls[-1]
        stand = self._state(last.off_s, len(footfalls) - 1)[0]
        ground.append(rest(last.off_s, *stand[:2]))
        height.append(rest(last.off_s, stand[2]))
        return Stacked(Spline(ground), Spline(height))

    def _landing(self, step: Footfall, number: int) -> Floats:
        """Return the state at contact, which landing turns into rolling."""
        way = self._ways[number]
        across = np.array([-way[1], way[0], 0.0])
        axes = step.reach * np.stack([way, across, _UP])
        speed, braking = _LANDING_MPS @ axes, _LANDING_MPS2 @ axes
        extra = np.stack([-0.5 * LANDING_S * speed, speed, braking])
        state: Floats = self._state(step.contact_s, number) + extra
        return state


def _least_effort(start: Floats, stop: Floats, duration_s: float) -> Floats:
    """Return position and velocity half-way on the path of least squared acceleration.

    Args:
        start: Position and velocity at the start, shape (2, k).
        stop: The same at the end.
        duration_s: From start to stop.
    """
    (from_m, from_mps), (to_m, to_mps) = start, stop
    position = 0.5 * (from_m + to_m) + duration_s / 8.0 * (from_mps - to_mps)
    velocity = 1.5 * (to_m - from_m) / duration_s - 0.25 * (from_mps + to_mps)
    return np.stack([position, velocity])


def _range_of(stride: float, leg: Leg) -> float:
    """Return how far angles go in a stride relative to the usual."""
    return (0.4 + 0.6 * stride) * leg.range_factor


def _knot(t_s: float, state: Floats) -> Knot:
    return Knot(t_s, *(tuple(row) for row in state))


def _foot_knots(
    footfalls: Sequence[Footfall], reach: Floats, push: Floats, sole: Sole
) -> list[Knot]:
    """Return the foot's pitch: what it is in swing only leads from toe-off to contact."""
    first, *middle, last = footfalls
    flat = 0.8 * sole.flat_rad
    contact_rate = (_FOOT_CONTACT_RATE,)
    knots = [rest(first.contact_s, 0.0), rest(first.at(0.3), 0.0)]
    knots.append(_toe_off(first, first.at(0.3), _FOOT_OFF * push[0]))
    for number, step in enumerate(middle, start=1):
        down_s, up_s = (step.at(share) for share in _FLAT_SHARES)
        rock = flat * min(1.0, reach[number])
        rocking = (2.0 * rock / (up_s - down_s),)
        knots.append(Knot(step.contact_s, (_FOOT_CONTACT * reach[number],), contact_rate))
        knots.append(Knot(down_s, (-rock,), rocking, (0.0,)))
        knots.append(Knot(up_s, (rock,), rocking, (0.0,)))
        knots.append(_toe_off(step, up_s, _FOOT_OFF * push[number]))
    knots.append(Knot(last.contact_s, (_FOOT_CONTACT * reach[-1],), contact_rate))
    knots.append(rest(last.contact_s + 0.3 * (last.off_s - last.contact_s), 0.0))
    return knots


def _toe_off(step: Footfall, up_s: float, pitch: float) -> Knot:
    push_s = step.off_s - up_s
    rate = _FOOT_OFF_SPEEDUP * pitch / push_s
    return Knot(step.off_s, (pitch,), (rate,), (0.8 * rate / push_s,))


def _pitch_knots(
    footfalls: Sequence[Footfall], reach: Floats, push: Floats, leg: Leg
) -> list[Knot]:
    first, last = footfalls[0], footfalls[-1]
    knots = [rest(first.contact_s, leg.stand_rad)]
    knots.append(via(first.at(0.90), _STANCE_PITCH[-1][1] * push[0]))
    for number, (before, step) in enumerate(pairwise(footfalls), start=1):
        swing_s = step.contact_s - before.off_s
        for share, pitch in _SWING_PITCH:
            scale = push[number - 1] if pitch > 0.0 else reach[number]
            knots.append(via(before.off_s + share * swing_s, scale * pitch))
        contact = (_CONTACT_PITCH * reach[number],)
        knots.append(Knot(step.contact_s, contact, (_CONTACT_RATE * reach[number],)))
        if step is not last:
            for share, pitch in _STANCE_PITCH:
                scale = push[number] if pitch > 0.0 else reach[number]
                knots.append(via(step.at(share), scale * pitch))
    knots.append(rest(last.off_s, leg.stand_rad))
    return knots


def _yaw_knots(footfalls: Sequence[Footfall]) -> list[Knot]:
    """Return the heading of the shank: it turns with the foot in swing."""
    knots = [rest(footfalls[0].contact_s, footfalls[0].yaw_rad)]
    for before, step in pairwise(footfalls):
        knots.append(rest(before.off_s, before.yaw_rad))
        knots.append(rest(step.contact_s, step.yaw_rad))
    knots.append(rest(footfalls[-1].off_s, footfalls[-1].yaw_rad))
    return knots


def _roll_knots(footfalls: Sequence[Footfall], leg: Leg, rng: np.random.Generator) -> list[Knot]:
    """Return the sideways lean: outward when loaded, inward in mid-swing."""
    knots = [rest(footfalls[0].contact_s, 0.0)]
    outward = -leg.side
    for before, step in pairwise(footfalls):
        middle_s = 0.5 * (before.off_s + step.contact_s)
        knots.append(via(middle_s, outward * (rng.normal(-0.05, 0.015) + leg.bow_rad)))
        if step is not footfalls[-1]:
            knots.append(via(step.at(0.3), outward * (rng.normal(0.02, 0.01) + leg.bow_rad)))
            knots.append(via(step.at(0.7), outward * (rng.normal(0.0, 0.01) + leg.bow_rad)))
    knots.append(rest(footfalls[-1].off_s, 0.0))
    return knots


def _strike(footfalls: Sequence[Footfall], hardness: Floats, rng: np.random.Generator) -> Shocks:
    """Return how heel strike shakes the ankle, in n."""
    contacts_s = np.array([step.contact_s for step in footfalls[1:]])
    yaws = np.array([step.yaw_rad for step in footfalls[1:]])
    along, across, up = (hardness[1:, None] * _STRIKE_M * rng.normal(1.0, 0.3, (len(yaws), 3))).T
    cosine, sine = np.cos(yaws), np.sin(yaws)
    peaks = np.stack([cosine * along - sine * across, sine * along + cosine * across, up], axis=1)
    return Shocks(contacts_s, peaks, float(rng.uniform(14.0, 20.0)), 0.007)


def _wobble(footfalls: Sequence[Footfall], amount: Floats, rng: np.random.Generator) -> Shocks:
    """Return how heel strike, and half as much toe-off, make a sensor swing on the flesh."""
    contacts_s = np.array([step.contact_s for step in footfalls[1:]])
    offs_s = np.array([step.off_s for step in footfalls[:-1]])
    times_s = np.stack([offs_s, contacts_s], axis=1).reshape(-1)
    share = np.stack([0.5 * amount[1:], amount[1:]], axis=1).reshape(-1, 1)
    peaks = share * _WOBBLE_RAD * rng.normal(1.0, 0.3, (len(times_s), 3))
    return Shocks(times_s, peaks, float(rng.uniform(7.0, 10.0)), 0.025)
