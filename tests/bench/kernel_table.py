"""What the error-state filter costs through its public class, paired with a plain loop in C.

Both run in this process, in turns, over the same recording; what is printed is the median of the
ratios of neighbours, because a machine's speed drifts by more than what is to be measured. The loop
(``plain_loop.c``) has the arithmetic of the kernels and nothing else: the ratio is what reaching it
from Python costs. The two results are compared, to the bit.
"""

import ctypes
import os
import shlex
import statistics
import subprocess
import sysconfig
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

from gaitway import estimation
from gaitway.estimation import ATT, VEL, ErrorStateFilter, ImuNoise, _kernels_twin, kernels

HERE = Path(__file__).parent
FLAGS = (
    "-std=c11",
    "-O3",
    "-fno-tree-slp-vectorize",  # pairs are written out where they pay
    "-fno-math-errno",
    "-ffp-contract=off",
    "-fPIC",
    "-shared",
)
DT_S = 0.01
SAMPLES = 20_000
PAIRS = 51
SIGMA_MPS = 0.01
NOISE = ImuNoise(5e-3, 5e-4, 1e-4, 1e-5)
PEERS = {"gaitmap, forward pass only": (69.0, 50.0), "OpenShoe, C in real time": (12.0, 5.0)}
"""Times a plain C loop that others take with 9 states, and how many times faster we mean to be."""


class Recording:
    """A walk of swings and stances, 40 % of it still; random, for its cost is that of any."""

    def __init__(self) -> None:
        rng = np.random.default_rng(1)
        self.accel_d = rng.normal((0.0, 0.0, 9.8), 1.0, (SAMPLES, 3))
        self.gyro_d = rng.normal(0.0, 0.5, (SAMPLES, 3))
        self.still = np.arange(SAMPLES) % 100 >= 60


def kernel_table() -> None:
    """Print each way to run the filter, with 9 and 15 states."""
    if not estimation.COMPILED:
        print("\nerror-state filter: the kernels are not compiled, there is nothing to compare")
        return
    walk = Recording()
    print("\nerror-state filter, 40 % of samples with an update       us/sample   times the C loop")
    with tempfile.TemporaryDirectory() as directory:
        library = _library(Path(directory))
        whole = [_states(states, walk, getattr(library, f"loop_{states}")) for states in (9, 15)]
    print("against others, 9 states, whole recording; their ratios were measured elsewhere:")
    for name, (theirs, aim) in PEERS.items():
        print(
            f"  {name:28} {theirs:4.0f} x the C loop, so we are {theirs / whole[0]:5.1f} x faster"
            f" (aim: {aim:.0f} x)"
        )


def _states(states: int, walk: Recording, loop: Callable[..., None]) -> float:
    def plain() -> ErrorStateFilter:
        kf = _started(states)
        densities = np.array(
            (
                NOISE.accel_mps2_rthz,
                NOISE.gyro_radps_rthz,
                NOISE.accel_bias_walk_mps2_rts,
                NOISE.gyro_bias_walk_radps_rts,
            )
        )
        arrays = (kf.nominal, kf.covariance, walk.accel_d, walk.gyro_d, walk.still)
        pointers = [ctypes.c_void_p(array.ctypes.data) for array in arrays]
        loop(
            *pointers,
            ctypes.c_long(SAMPLES),
            ctypes.c_double(DT_S),
            ctypes.c_double(kf.gravity_mps2),
            ctypes.c_void_p(densities.ctypes.data),
            ctypes.c_double(SIGMA_MPS),
        )
        return kf

    assert np.array_equal(plain().covariance, _in_batches(states, walk, SAMPLES).covariance)
    loop_us, _ = _paired(plain, plain)
    print(f"  {states:2} states, plain C loop, whole recording             {loop_us:9.3f}")
    ratios = []
    for size, limit in ((SAMPLES, 2.0), (10, 3.0), (1, None)):
        us, ratio = _paired(lambda size=size: _in_batches(states, walk, size), plain)  # type: ignore[misc]
        name = "whole recording" if size == SAMPLES else f"run(), {size} a call"
        aim = "" if limit is None else f"   (aim: {limit:.0f})"
        print(f"     the class, {name:38} {us:9.3f} {ratio:14.2f}{aim}")
        ratios.append(ratio)
    us, ratio = _paired(lambda: _one_by_one(states, walk), plain)
    print(f"     the class, predict() and no update, a sample    {us:9.3f} {ratio:14.2f}   (1 us)")
    us = 1e6 * _seconds(lambda: _by_twin(states, walk)) / (SAMPLES // 20)
    print(f"     its twin in numpy                               {us:9.1f} {us / loop_us:14.0f}")
    return ratios[0]


def _paired(ours: Callable[[], object], theirs: Callable[[], object]) -> tuple[float, float]:
    """Return microseconds per sample of ours, and the median ratio to theirs."""
    pairs = [(_seconds(ours), _seconds(theirs)) for _ in range(PAIRS)]
    us = 1e6 * statistics.median(seconds for seconds, _ in pairs) / SAMPLES
    return us, statistics.median(mine / other for mine, other in pairs)


def _seconds(work: Callable[[], object]) -> float:
    began = time.perf_counter()
    work()
    return time.perf_counter() - began


def _started(states: int) -> ErrorStateFilter:
    kf = ErrorStateFilter(states=states)
    for block, variance in ((VEL, 1e-4), (ATT, 1e-3)):
        kf.set_block(block, variance)
    return kf


def _in_batches(states: int, walk: Recording, size: int) -> ErrorStateFilter:
    kf = _started(states)
    for start in range(0, SAMPLES, size):
        rows = slice(start, start + size)
        kf.run(
            walk.accel_d[rows],
            walk.gyro_d[rows],
            DT_S,
            NOISE,
            still=walk.still[rows],
            sigma_mps=SIGMA_MPS,
        )
    return kf


def _one_by_one(states: int, walk: Recording) -> ErrorStateFilter:
    kf = _started(states)
    for accel_d, gyro_d in zip(walk.accel_d.tolist(), walk.gyro_d.tolist(), strict=True):
        kf.predict(accel_d, gyro_d, DT_S, NOISE)
    return kf


def _by_twin(states: int, walk: Recording) -> None:
    kf, rows = _started(states), slice(0, SAMPLES // 20)
    compiled, kernels.run = kernels.run, _kernels_twin.run
    try:
        kf.run(walk.accel_d[rows], walk.gyro_d[rows], DT_S, NOISE, still=walk.still[rows])
    finally:
        kernels.run = compiled


def _library(directory: Path) -> ctypes.CDLL:
    compiler = shlex.split(os.environ.get("CC") or sysconfig.get_config_var("CC") or "cc")
    built = directory / "plain_loop.so"
    headers = f"-I{Path(estimation.__file__).parent}"
    source = str(HERE / "plain_loop.c")
    subprocess.run([*compiler, *FLAGS, headers, source, "-lm", "-o", str(built)], check=True)
    return ctypes.CDLL(str(built))
