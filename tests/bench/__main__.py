"""What things cost on this machine: ``make bench``."""

import argparse

from codec_table import codec_table
from daemon_table import daemon_table
from estimator_table import estimator_table
from kernel_table import kernel_table
from path_table import path_table
from start_up_table import start_up_table

if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seconds", type=float, default=30.0, help="how long to watch the daemon")
    arguments = parser.parse_args()
    codec_table()
    kernel_table()
    path_table()
    estimator_table()
    start_up_table()
    daemon_table(arguments.seconds)
