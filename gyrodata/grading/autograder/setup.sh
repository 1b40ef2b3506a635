#!/usr/bin/env bash
# Makes the image once: what gyrodata needs, with a Python of its own. The byte code is compiled, because each
# submission starts anew.
set -euo pipefail
apt-get update
apt-get install -y --no-install-recommends ca-certificates python3-venv
python3 -m venv /autograder/uv
/autograder/uv/bin/pip install --quiet uv
/autograder/uv/bin/uv venv --python ">=3.11" /autograder/gyro
python=/autograder/gyro/bin/python
/autograder/uv/bin/uv pip install --python $python --compile-bytecode -r /autograder/source/requirements.txt
$python -m compileall -q /autograder/source/gyrodata
PYTHONPATH=/autograder/source $python -m gyrodata --version
