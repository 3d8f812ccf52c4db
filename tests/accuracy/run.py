"""Running experiments: every walk by every method, a process a core."""

import importlib
import multiprocessing
import sys
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from experiment import Experiment, Outcome

FOLDER = Path(__file__).parent / "experiments"


@dataclass(frozen=True)
class Result:
    """What came of an experiment.

    Attributes:
        experiment: Which.
        outcomes: By method, a list a walk.
        figures: By method, name to value.
    """

    experiment: Experiment
    outcomes: dict[str, list[list[Outcome]]]
    figures: dict[str, dict[str, float]]

    def targets(self) -> list[tuple[str, bool]]:
        """Return each target of the default method as text, and whether it was met."""
        default = next(iter(self.figures.values()))
        return [
            (f"{t.figure} {'>=' if t.at_least else '<='} {t.limit:g}", t.met(default))
            for t in self.experiment.targets
        ]


def load_experiments(devices: Sequence[str] | None) -> list[Experiment]:
    """Return the simulated experiments of all devices, or of those named."""
    return [e for module in _modules(devices) for e in module.experiments()]


def load_people(devices: Sequence[str] | None, folder: Path) -> tuple[list[Experiment], str]:
    """Return the experiments on people, and why there are none."""
    modules = [module for module in _modules(devices) if hasattr(module, "people")]
    if not modules:
        return [], "no recordings of people exist for this device"
    if not (folder / "truth.json").is_file():
        return [], f"no recordings in {folder} (name their folder: --real FOLDER)"
    return [e for module in modules for e in module.people(folder)], "none fits"


def _modules(devices: Sequence[str] | None):
    names = sorted(path.stem for path in FOLDER.glob("*.py"))
    wanted = names if devices is None else [device.replace("-", "_") for device in devices]
    for name in wanted:
        if name not in names:
            known = ", ".join(known.replace("_", "-") for known in names)
            sys.exit(f"--device {name.replace('_', '-')}: no experiments (one of: {known})")
        yield importlib.import_module(f"experiments.{name}")


_JOBS: list[tuple[Experiment, str, object]] = []


def run_all(experiments: Sequence[Experiment], quick: bool, processes: int) -> list[Result]:
    """Return the results of all experiments, telling how far it is meanwhile."""
    _JOBS[:] = [
        (experiment, method, plan)
        for experiment in experiments
        for method in experiment.methods
        for plan in _plans(experiment, quick)
    ]
    if not _JOBS:
        return []
    began = time.monotonic()
    # Forked, so that a child knows the jobs by their number: methods can't be pickled.
    with multiprocessing.get_context("fork").Pool(processes) as pool:
        found = []
        for number, outcomes in enumerate(pool.imap(_run, range(len(_JOBS))), 1):
            found.append(outcomes)
            _tell(number, began)
    print(file=sys.stderr)
    told = iter(found)
    results = []
    for experiment in experiments:
        outcomes = {
            method: [next(told) for _ in _plans(experiment, quick)] for method in experiment.methods
        }
        figures = {method: experiment.figures(walks) for method, walks in outcomes.items()}
        results.append(Result(experiment, outcomes, figures))
    return results


def _run(number: int) -> list[Outcome]:
    experiment, method, plan = _JOBS[number]
    return experiment.methods[method](plan)


def _plans(experiment: Experiment, quick: bool):
    return experiment.plans[: experiment.quick] if quick else experiment.plans


def _tell(number: int, began: float) -> None:
    experiment, _, _ = _JOBS[number - 1]
    passed_s = time.monotonic() - began
    left_s = passed_s / number * (len(_JOBS) - number)
    line = (
        f"{number}/{len(_JOBS)} walks, {left_s:.0f} s left: {experiment.device} {experiment.name}"
    )
    if sys.stderr.isatty():
        print(f"\r{line[:98]:98}", end="", file=sys.stderr, flush=True)
    elif number % 100 == 0 or number == len(_JOBS):
        print(line, file=sys.stderr, flush=True)
