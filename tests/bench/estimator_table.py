"""What each device's estimator costs per sample, by batch size."""

import time

import numpy as np

from gaitway.contracts import WalkPlan
from gaitway.mounting import mount, rotation_from_mounting
from gaitway.registry import load_registry
from gaitway.samples import SampleBatch

RATE_HZ = 100.0


def estimator_table() -> None:
    """Print what each estimator costs per sample, by batch size."""
    print("\nestimator            batch   us/sample")
    for device in load_registry().devices.values():
        if device.simulate is None:
            continue
        walk = device.simulate(WalkPlan(distance_m=60.0, seed=1))
        n = len(walk.pos_n)
        C_db = rotation_from_mounting(device.default_mounting)
        t_ns = (np.arange(n) * round(1e9 / RATE_HZ)).astype(np.int64)
        whole = mount(SampleBatch(t_ns, 1 / RATE_HZ, 0, walk.channels), C_db)
        for size in (1, 2, 10, n):
            estimator = device.make_estimator(device.params(), C_db)
            batches = [whole[start : start + size] for start in range(0, n, size)]
            began = time.perf_counter()
            for batch in batches:
                estimator.update(batch)
            seconds = time.perf_counter() - began
            print(f"{device.name:20} {size:5} {1e6 * seconds / n:11.1f}")
