#!/usr/bin/env bash
# Installs a copy of the last commit with pip into a new environment and deletes the copy; the
# installed program then diagnoses a simulated set. The script needs Python's venv, git and the package
# index.
# PYTHON=python3.12 scripts/try_install.sh uses another Python.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

folder=$PWD/build/try_install
rm -rf "$folder"
mkdir -p "$folder/tree"
# On a hosted runner the tree belongs to another user, which git refuses without this option.
git -c safe.directory="$PWD" archive HEAD | tar -x -C "$folder/tree"
cd "$folder"
"${PYTHON:-python3}" -m venv environment
environment/bin/pip install ./tree
rm -rf tree
environment/bin/arctrue simulate set --effect hysteresis --size 2 --seed 1 --experiment short
environment/bin/arctrue diagnose set --json diagnosis.json
if ! grep -q '"named": "hysteresis"' diagnosis.json; then
    echo "[install] the installed program does not name the hysteresis that the set holds" >&2
    exit 1
fi
