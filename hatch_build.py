"""Compiles the kernels of gaitway.estimation where there is a C compiler; goes on where none is.

A wheel then carries them and is tagged for this platform; without them it is a pure one, and the
estimators use the twin of the kernels in numpy (``gaitway check`` says so).
"""

import os
import shlex
import subprocess
import sysconfig
import tempfile
from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface

SOURCE = Path("gateway/gaitway/estimation/_kernels.c")
NAME = f"_kernels{sysconfig.get_config_var('EXT_SUFFIX')}"
# The same bits on every machine: no fused multiply-add, nothing that only this processor has.
FLAGS = (
    "-std=c11",
    "-O3",
    "-fno-tree-slp-vectorize",  # pairs are written out where they pay
    "-fno-math-errno",
    "-ffp-contract=off",
    "-fPIC",
    "-shared",
)


class KernelsBuildHook(BuildHookInterface):  # type: ignore[type-arg]
    """Adds the compiled kernels to a wheel, or puts them beside their source for an editable one.

    The compiler is Python's own, or ``CC`` of the environment.
    """

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Compile before the files of the wheel are gathered."""
        root = Path(self.root)
        beside = root / SOURCE.with_name(NAME)
        self._directory = tempfile.TemporaryDirectory(prefix="gaitway-kernels-")
        built = Path(self._directory.name) / NAME
        failure = self._compile(root / SOURCE, built)
        if failure:
            self.app.display_warning(
                f"gaitway: the kernels could not be compiled ({failure}); "
                "installing without them, estimators will be slower"
            )
        else:
            build_data["pure_python"] = False
            build_data["infer_tag"] = True
        if version == "editable":
            _put_beside(beside, built)
        elif not failure:
            build_data["force_include"][str(built)] = f"gaitway/estimation/{NAME}"

    def finalize(self, version: str, build_data: dict[str, Any], artifact_path: str) -> None:  # noqa: ARG002  # the hook's signature
        """Clean up."""
        self._directory.cleanup()

    def _compile(self, source: Path, built: Path) -> str:
        """Return why it failed, in a few words; nothing if it did not."""
        compiler = shlex.split(os.environ.get("CC") or sysconfig.get_config_var("CC") or "cc")
        include = f"-I{sysconfig.get_path('include')}"
        command = [*compiler, *FLAGS, include, str(source), "-lm", "-o", str(built)]
        try:
            done = subprocess.run(command, check=False, capture_output=True, text=True)
        except OSError as exc:
            return f"{compiler[0]}: {exc.strerror}"
        if done.returncode == 0 and built.exists():
            return ""
        first = next((line for line in done.stderr.splitlines() if "error" in line), "it failed")
        return f"{compiler[0]}: {first.strip()}"


def _put_beside(beside: Path, built: Path) -> None:
    """Replace the kernels at once: a process that runs keeps the file it has mapped."""
    if not built.exists():
        beside.unlink(missing_ok=True)
        return
    staged = beside.with_suffix(".new")
    staged.write_bytes(built.read_bytes())
    staged.replace(beside)
