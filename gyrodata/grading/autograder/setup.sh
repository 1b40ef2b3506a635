#!/usr/bin/env bash
# Makes the image once: gyrodata with a Python of its own, its byte code compiled, for each submission starts anew.
set -euo pipefail
apt-get update
apt-get install -y --no-install-recommends ca-certificates python3-venv
python3 -m venv /autograder/uv
/autograder/uv/bin/pip install --quiet uv
/autograder/uv/bin/uv venv --python ">=3.11" /autograder/gyro
/autograder/uv/bin/uv pip install --python /autograder/gyro/bin/python --compile-bytecode /autograder/source/{wheel}
/autograder/gyro/bin/gyro --version
