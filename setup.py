"""Tells setuptools of the one step of the build that pyproject.toml has no words for."""

import sys
from pathlib import Path

from setuptools import setup

sys.path.insert(0, str(Path(__file__).resolve().parent))

from scripts.build_package import BuildPackage

setup(cmdclass={"build_py": BuildPackage})
