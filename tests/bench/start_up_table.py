"""What importing and starting costs."""

import subprocess
import sys
import time


def start_up_table() -> None:
    """Print what importing and starting costs."""
    print("\ncommand                        seconds")
    for arguments in (["--version"], ["plugins"], ["check", "configs/gateway.toml"]):
        began = time.perf_counter()
        subprocess.run(
            [sys.executable, "-m", "gaitway", *arguments], check=True, capture_output=True
        )
        print(f"gaitway {' '.join(arguments):22} {time.perf_counter() - began:7.2f}")
