"""Distances against truth, published and default methods: ``make accuracy``.

Simulated walks first: people, paces and sensors drawn from seeds that no parameter was chosen on.
Then walks of real people, where the folder with them is given; they are marked as measured.
"""

import argparse
import json
import os
from collections import defaultdict
from pathlib import Path

import numpy as np

from gaitway.contracts import WalkPlan
from gaitway.events import Distance
from gaitway.mounting import mount, rotation_from_mounting
from gaitway.offline.csv_input import read_csv
from gaitway.offline.run import run_estimator
from gaitway.registry import load_registry
from gaitway.samples import SampleBatch

ROOT = Path(__file__).parents[2]
BATCH = 100
CANE_METHODS = {"default": {}, "published": {"method": "published"}}
PUBLISHED_SHANK = {name: {"method": name} for name in ("wsi", "s1", "s2", "s3")}
SHANK_METHODS = {
    "default": {},
    # The simulated sensor sits 0.10 m above the ankle; here somebody measured that.
    "measured": {"ankle_to_imu_m": 0.10, "ankle_to_imu_sigma_m": 0.01},
} | PUBLISHED_SHANK
SIMULATED = (
    # device, what, methods, walks as (distance_m, turn_back, speed_mps)
    ("quad-cane", "3.3 m", CANE_METHODS, [(3.3, False, None)] * 10),
    ("quad-cane", "170 m with a turn", CANE_METHODS, [(170.0, True, None)] * 5),
    ("shank", "20 m slow", SHANK_METHODS, [(20.0, False, 0.9)] * 8),
    ("shank", "20 m normal", SHANK_METHODS, [(20.0, False, 1.25)] * 8),
    ("shank", "20 m fast", SHANK_METHODS, [(20.0, False, 1.6)] * 8),
)
FIRST_SEED = 1000


def simulated_walk(device, seed, distance_m, turn_back, speed_mps):
    plan = WalkPlan(distance_m=distance_m, seed=seed, turn_back=turn_back, speed_mps=speed_mps)
    walk = device.simulate(plan)
    n = len(walk.pos_n)
    t_ns = np.arange(n, dtype=np.int64) * round(1e9 / walk.rate_hz)
    C_db = rotation_from_mounting(device.default_mounting)
    return walk.distance_m, mount(SampleBatch(t_ns, 1 / walk.rate_hz, 0, walk.channels), C_db)


def estimate(device, params, batch):
    """Return distance and its standard deviation."""
    estimator = device.make_estimator(device.params.model_validate(params))
    events = []
    for start in range(0, len(batch), BATCH):
        events += estimator.update(batch[start : start + BATCH])
    events += estimator.finish()
    return last_distance(events)


def last_distance(events):
    distances = [event for event in events if isinstance(event, Distance)]
    return (
        (distances[-1].distance_m, distances[-1].distance_sigma_m) if distances else (0.0, np.nan)
    )


def row(name, method, truth_m, found):
    found_m, sigma_m = np.array(found).T
    error_m = found_m - truth_m
    inside = np.mean(np.abs(error_m) <= 1.96 * sigma_m)
    print(
        f"{name:32} {method:10} {len(found):5} {np.mean(np.abs(error_m)):9.3f} "
        f"{np.abs(error_m / truth_m).max() * 100:9.2f} {np.mean(found_m / truth_m):8.3f} "
        f"{np.std(found_m / truth_m):8.3f} {100 * inside:8.0f}"
    )


def head(title):
    print(f"\n{title}")
    print(
        f"{'walks':32} {'method':10} {'count':>5} {'MAE m':>9} {'worst %':>9} {'ratio':>8} "
        f"{'sd':>8} {'in 95 %':>8}"
    )


def simulated_table():
    head("simulated (gaitway.simulation)")
    devices = load_registry().devices
    for name, what, methods, walks in SIMULATED:
        made = [
            simulated_walk(devices[name], FIRST_SEED + seed, *walk)
            for seed, walk in enumerate(walks)
        ]
        truth_m = np.array([truth for truth, _ in made])
        for method, params in methods.items():
            found = [estimate(devices[name], params, batch) for _, batch in made]
            row(f"{name} {what}", method, truth_m, found)


def real_table(folder):
    files = sorted(folder.glob("shank10m_*.csv"))
    if not files:
        print(f"\nreal walks: none in {folder} (--real FOLDER); that table is left out")
        return
    head("measured on people (healthy adults, nominal 10 m, sensor above the ankle)")
    truth = json.loads((folder / "truth.json").read_text())
    device = load_registry().devices["shank"]
    C_db = rotation_from_mounting(device.default_mounting)
    for method, params in ({"default": {}} | PUBLISHED_SHANK).items():
        people = defaultdict(list)
        for file in files:
            estimator = device.make_estimator(device.params.model_validate(params))
            events = run_estimator(estimator, read_csv(file, device.requires), C_db)
            person = file.stem.split("_")[1]
            people[person].append((truth[file.stem]["distance_m"], *last_distance(events)))
        people["all"] = [walk for walks in people.values() for walk in walks]
        for person, walks in sorted(people.items()):
            row(f"shank {person}", method, np.array(walks)[:, 0], np.array(walks)[:, 1:])


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument(
        "--real",
        type=Path,
        default=Path(os.environ.get("GAITWAY_SHARED", ROOT.parent / "shared")) / "data",
        help="folder with walks of real people and truth.json",
    )
    arguments = parser.parse_args()
    simulated_table()
    real_table(arguments.real)
