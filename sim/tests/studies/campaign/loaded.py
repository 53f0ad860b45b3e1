"""Lists the files of the package that a fresh interpreter loads."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

from arctrue.studies.campaign.code_state import PACKAGE


def loaded_by(*modules: str) -> set[Path]:
    """Return the package's files that an import of these modules loads."""
    code = (
        f"import sys, {', '.join(modules)}\n"
        "print(*(name for name in sys.modules if name.split('.')[0] == 'arctrue'))\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, timeout=120, check=True
    )
    places = [PACKAGE.joinpath(*name.split(".")[1:]) for name in done.stdout.split()]
    return {
        place / "__init__.py" if place.is_dir() else place.with_suffix(".py") for place in places
    }
