"""The ``gaitway`` command: one module a subcommand, imported only when it is used."""

import argparse
import importlib
import os
import sys
from collections.abc import Sequence
from typing import Final

from gaitway import __version__
from gaitway.errors import CalibrationError, ConfigError, GaitwayError, InputDataError, PublishError

COMMANDS: Final = {
    "run": "run the gateway",
    "check": "check a configuration without opening any port",
    "plugins": "list what is installed, and what is broken",
    "watch": "show what the gateway publishes, live",
    "simulate": "be a device: a simulated person walks with it",
    "replay": "run a recording through today's code and compare the events",
    "calibrate": "find a device's parameters: guided, with a picture, written to the config",
    "estimate": "estimate a walk from a recording or a CSV file",
    "demo": "two simulated devices, the gateway and a subscriber, all at once",
}

EXIT_STATUS: Final[tuple[tuple[type[GaitwayError], int], ...]] = (
    (ConfigError, 78),  # EX_CONFIG
    (InputDataError, 65),  # EX_DATAERR
    (CalibrationError, 65),
    (PublishError, 69),  # EX_UNAVAILABLE
    (GaitwayError, 1),
)


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command line; return the exit status (sysexits.h)."""
    arguments = list(sys.argv[1:] if argv is None else argv)
    parser = _parser()
    named = next((word for word in arguments if not word.startswith("-")), None)
    if named not in COMMANDS or "--version" in arguments[:1]:
        parser.parse_args(arguments)  # prints help, version or the error, and exits
        parser.print_help()
        return 64
    command = importlib.import_module(f"gaitway.cli.{named}")
    own = argparse.ArgumentParser(
        prog=f"gaitway {named}",
        description=command.__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    command.add_arguments(own)
    try:
        status: int = command.run(own.parse_args(arguments[arguments.index(named) + 1 :]))
    except GaitwayError as exc:
        print(f"gaitway {named}: {exc}", file=sys.stderr)
        return next(status for kind, status in EXIT_STATUS if isinstance(exc, kind))
    except BrokenPipeError:
        # The reader of our output went away, as in `gaitway plugins | head -1`.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0
    except OSError as exc:
        print(f"gaitway {named}: {exc}", file=sys.stderr)
        return 74  # EX_IOERR
    except KeyboardInterrupt:
        return 130
    return status


def _parser() -> argparse.ArgumentParser:
    lines = [f"  {name:10} {summary}" for name, summary in COMMANDS.items()]
    parser = argparse.ArgumentParser(
        prog="gaitway",
        description="Turns a walking aid into a trustworthy measure of how a person walks.",
        epilog="commands:\n"
        + "\n".join(lines)
        + "\n\ngaitway COMMAND --help tells more. Begin with: gaitway demo",
        formatter_class=argparse.RawDescriptionHelpFormatter,
        usage="gaitway COMMAND [ARGUMENTS]",
    )
    parser.add_argument("--version", action="version", version=f"gaitway {__version__}")
    parser.add_argument("command", nargs="?", choices=list(COMMANDS), metavar="COMMAND")
    return parser
