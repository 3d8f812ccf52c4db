"""gaitway: a walking aid as a trustworthy measure of how a person walks.

This page fixes what every other module takes for granted.

Frames
    One letter each, as a suffix of arrays: ``b`` body, the axes of the IMU as it reports;
    ``d`` device, the mechanical axes of the aid (x forward, y left, z up); ``n`` navigation
    (local, level, z up, heading arbitrary at the start). ``vec_a`` is expressed in frame ``a``;
    ``C_ab`` and ``q_ab`` take components from ``b`` to ``a``. A lever arm is named from-to-frame:
    ``imu_to_tip_d``. Quaternions are Hamilton, scalar first, ``q_w >= 0``.

Units
    SI, without exception, in the name of every scalar that has one: ``_s _hz _m _mps _mps2 _rad
    _radps _newton _spm`` (steps per minute), densities ``_radps_rthz _mps2_rthz``. Newtons are
    spelled out because ``_n`` is a frame.

Specific force
    What an accelerometer measures: at rest and level ``accel_d`` reads ``[0, 0, +9.80665]``.

Time
    ``t_ns`` is an ``int``: nanoseconds of the host's monotonic clock. Wall-clock time exists once
    per recording and once per published payload, by one anchor. Durations are float seconds.

Shapes
    A run of ``n`` samples is a C-contiguous float64 array of shape ``(n, k)``, one row a sample.
"""

from importlib.metadata import version

__version__: str = version("gaitway")
