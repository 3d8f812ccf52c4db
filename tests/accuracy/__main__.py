"""The papers' experiments, simulated, by the published methods and by ours: ``make accuracy``.

Each device's experiments are in ``experiments``. People, paces and sensors are drawn from seeds
that no parameter was chosen on. Walks of real people run in a second table, marked as such, where
the folder with them is given. Progress goes to stderr, the tables to stdout, and both with pictures
to a report.
"""

import argparse
import os
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))

from report import table, write_report
from run import load_experiments, load_people, run_all

ROOT = Path(__file__).parents[2]


def main() -> None:
    parser = argparse.ArgumentParser(
        prog="make accuracy", description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )  # fmt: skip
    parser.add_argument("--device", action="append", metavar="TYPE", help="only this device type")
    parser.add_argument(
        "--quick", action="store_true", help="a few walks of each, for a first look"
    )
    parser.add_argument(
        "--real", type=Path, metavar="FOLDER", help="walks of real people and their truth.json",
        default=Path(os.environ.get("GAITWAY_SHARED", ROOT.parent / "shared")) / "data",
    )  # fmt: skip
    parser.add_argument(
        "--report", type=Path, metavar="FOLDER", default=ROOT / "accuracy-report",
        help="where report.md and its pictures go",
    )  # fmt: skip
    parser.add_argument("--jobs", type=int, default=os.cpu_count() or 1, metavar="N")
    arguments = parser.parse_args()

    results = run_all(load_experiments(arguments.device), arguments.quick, arguments.jobs)
    print("\nsimulated (gaitway.simulation): not measured on people")
    print(table(results))
    people, why_not = load_people(arguments.device, arguments.real)
    measured = run_all(people, arguments.quick, arguments.jobs)
    print("\nmeasured on people")
    print(table(measured) if measured else f"  left out: {why_not}")
    write_report(arguments.report, results, measured, why_not)
    print(f"\nreport with pictures: {arguments.report / 'report.md'}")


if __name__ == "__main__":
    main()
