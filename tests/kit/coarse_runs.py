"""The command line as a process of its own, and the coarse study that it runs in seconds."""

import os
import subprocess
import sys
from pathlib import Path

from patience import PATIENCE

COARSE = Path(__file__).parent / "coarse.toml"
ONE_THREAD = {**os.environ, "OMP_NUM_THREADS": "1"}


def fibermelt(*arguments, folder):
    """Run a command in a folder, with one thread in the solvers."""
    return subprocess.run(
        [sys.executable, "-m", "fibermelt", *map(str, arguments)],
        cwd=folder,
        env=ONE_THREAD,
        capture_output=True,
        text=True,
        check=False,
        timeout=PATIENCE,
    )
