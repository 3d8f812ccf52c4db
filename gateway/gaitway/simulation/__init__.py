"""Parts to simulate a person walking with a sensor, with exact truth.

A device's motion is a position curve and an attitude curve; everything an IMU reports is derived
from these two. In the order in which a new device uses the parts:

1. ``Person.draw`` and ``stream``: who walks, and further random numbers of named purposes;
2. ``rest``, ``via``, ``Knot``, ``Spline``: motion of least jerk through knots; ``Shocks`` and
   ``Tremor`` on top; ``Sum``, ``Stacked``, ``Constant`` to put them together;
3. ``RigidMotion``: position of the device's origin, and its yaw, pitch and roll;
4. ``mounted``: where the IMU sits; ``record``: what it reports, and the truth.

For sensors on a leg ``leg_motion`` does step 2. ``non_walking`` is everything else a device goes
through.
"""

from gaitway.simulation.curves import Constant, Curve, Shocks, Stacked, Sum, Tremor
from gaitway.simulation.imu_model import SENSORS, ImuModel, Triad
from gaitway.simulation.leg import Footfall, Leg
from gaitway.simulation.leg_motion import leg_motion
from gaitway.simulation.motion import (
    GRAVITY_MPS2,
    ImuPlace,
    ImuRun,
    RigidMotion,
    ideal_imu,
    imu_attitude,
)
from gaitway.simulation.non_walking import NonWalking, non_walking
from gaitway.simulation.person import Person, stream
from gaitway.simulation.sole import Sole
from gaitway.simulation.spline import Knot, Spline, rest, via
from gaitway.simulation.walk import TrueStride, mounted, record

__all__ = [
    "GRAVITY_MPS2",
    "SENSORS",
    "Constant",
    "Curve",
    "Footfall",
    "ImuModel",
    "ImuPlace",
    "ImuRun",
    "Knot",
    "Leg",
    "NonWalking",
    "Person",
    "RigidMotion",
    "Shocks",
    "Sole",
    "Spline",
    "Stacked",
    "Sum",
    "Tremor",
    "Triad",
    "TrueStride",
    "ideal_imu",
    "imu_attitude",
    "leg_motion",
    "mounted",
    "non_walking",
    "record",
    "rest",
    "stream",
    "via",
]
