"""Generates the Python modules of registers and number formats while setuptools builds the package.

pyproject.toml and setup.py name this step. Therefore ``pip install .`` from a fresh clone, ``pip
wheel``, an install from a git address, and an install from the source distribution all contain the
generated modules.
"""

from __future__ import annotations

import shutil
from pathlib import Path

from setuptools.command.build_py import build_py

from scripts.generate_python import write_python

ROOT = Path(__file__).resolve().parents[1]
GENERATED = Path("arctrue", "generated")


class BuildPackage(build_py):
    """Build step of setuptools that also generates Python modules."""

    def run(self) -> None:
        """Copy the package into the build folder and generate the modules there.

        An editable install has no such folder: its modules are generated in the source tree.
        """
        if self.editable_mode:
            super().run()
            write_python(ROOT, ROOT / "sim" / GENERATED)
            return
        # Remove old modules, because modules that have moved since an earlier build would get into
        # this wheel.
        shutil.rmtree(self.build_lib, ignore_errors=True)
        super().run()
        write_python(ROOT, Path(self.build_lib) / GENERATED)

    def get_outputs(self, include_bytecode: bool = True) -> list[str]:
        """Return the files of the build, including the generated modules."""
        folder = Path(self.build_lib) / GENERATED
        generated = [str(path) for path in sorted(folder.glob("*.py"))]
        return [*super().get_outputs(include_bytecode), *generated]
