"""Run the gateway: read every configured device, record, estimate and publish, until stopped.

It becomes ready without waiting for any device; a device that is away is tried for ever. SIGTERM
or Ctrl-C stops it within two seconds with everything on disk. Exit status 78: the configuration
is wrong; 69: the bus can't be opened (the port is taken).
"""

import argparse
import asyncio
import logging
from pathlib import Path

from gaitway.config.load import load_config
from gaitway.runtime.daemon import run_daemon
from gaitway.timebase import HostClock


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument("config", type=Path, metavar="CONFIG", help="gateway.toml")
    parser.add_argument(
        "--log-level",
        default="info",
        choices=["debug", "info", "warning", "error"],
        help="how much to tell on stderr (default: info)",
    )


def run(arguments: argparse.Namespace) -> int:
    """Run the daemon."""
    logging.basicConfig(
        level=arguments.log_level.upper(), format="%(asctime)s %(levelname)s %(message)s"
    )
    loaded = load_config(arguments.config)
    for note in loaded.notes:
        logging.getLogger("gaitway").warning("%s", note)
    asyncio.run(run_daemon(loaded, HostClock()))
    return 0
