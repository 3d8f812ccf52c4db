"""Device-independent mathematics of gait: a toolkit for whoever writes an estimator.

The stages of an inertial estimator, in the order a sample meets them; each is a small object that
takes a sample at a time, costs the same for every sample, and says how much later it answers:

``BlockBridge``, ``GapBridge``
    make one stream out of batches and gaps, as blocks of samples or a sample at a time, and say
    where it is broken;
``RestDetector``, ``align_at_rest``, ``level_at_rest``
    find a window of stillness, and start a filter from it;
``StanceDetector``, built on ``CentredHold``; ``CentredMean``
    say of a sample, half a window later, whether the device stood on the ground, and any mean;
``ErrorStateFilter``
    navigates: ``predict`` at every sample, ``correct`` with what ``zero_velocity``,
    ``pivot_velocity``, ``zero_rate`` and ``gravity`` return, ``(z, H, R)`` each; its noise is an
    ``ImuNoise`` of densities, so settings hold at any sample rate. ``COMPILED`` says whether its
    arithmetic is machine code or its slow twin;
``Saveable``
    gives an estimator ``save`` and ``restore``;
``StrideInterpolation``
    tells what strides missing samples hid in mid-walk;
``WalkingTest``
    says whether a cane is walked with;
``WalkLedger``
    keeps the books: strides in; stride, distance and bout events out.

Conventions are those of ``gaitway``: SI, frames d (device) and n (level, z up, heading 0 where the
filter was started), ``C_ab`` and ``q_ab`` from b to a, quaternions scalar first. Quaternions and
single vectors are tuples of floats (``gaitway.estimation.rotation`` says why).
"""

from gaitway.estimation import rotation
from gaitway.estimation.clipping import ClipDetector
from gaitway.estimation.error_state import (
    STANDARD_GRAVITY_MPS2,
    ErrorStateFilter,
    Innovation,
    Measurement,
)
from gaitway.estimation.gaps import BlockBridge, Break, GapBridge, ImuBlock, ImuSample
from gaitway.estimation.interpolation import LostStrides, StrideInterpolation
from gaitway.estimation.kernels import COMPILED
from gaitway.estimation.ledger import WalkLedger
from gaitway.estimation.measurements import (
    gravity,
    isotropic,
    pivot_velocity,
    zero_rate,
    zero_velocity,
)
from gaitway.estimation.noise import ImuNoise
from gaitway.estimation.rest import Rest, RestDetector, align_at_rest, level_at_rest
from gaitway.estimation.saving import Saveable
from gaitway.estimation.stance import StanceDetector, norms
from gaitway.estimation.states import ACCEL_BIAS, ATT, GYRO_BIAS, POS, VEL
from gaitway.estimation.walking import (
    WalkingTest,
    tilt_from_gravity_rad,
    tilts_from_gravity_rad,
)
from gaitway.estimation.windows import CentredHold, CentredMean, half_window

__all__ = [
    "ACCEL_BIAS",
    "ATT",
    "COMPILED",
    "GYRO_BIAS",
    "POS",
    "STANDARD_GRAVITY_MPS2",
    "VEL",
    "BlockBridge",
    "Break",
    "CentredHold",
    "CentredMean",
    "ClipDetector",
    "ErrorStateFilter",
    "GapBridge",
    "ImuBlock",
    "ImuNoise",
    "ImuSample",
    "Innovation",
    "LostStrides",
    "Measurement",
    "Rest",
    "RestDetector",
    "Saveable",
    "StanceDetector",
    "StrideInterpolation",
    "WalkLedger",
    "WalkingTest",
    "align_at_rest",
    "gravity",
    "half_window",
    "isotropic",
    "level_at_rest",
    "norms",
    "pivot_velocity",
    "rotation",
    "tilt_from_gravity_rad",
    "tilts_from_gravity_rad",
    "zero_rate",
    "zero_velocity",
]
