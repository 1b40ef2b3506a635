"""Renew every stored file that a program writes; ``python tests/renew.py``, then read the
difference (``git diff``).

They are the report in sample_data/ with the gallery, the outputs and the reference on the
pages, the outputs of the notebook, and the fingerprints of the logs that come with gyro.
"""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

PROGRAMS = (
    "make_sample_report.py",
    "make_documents.py",
    "make_notebook.py",
    "make_examples.py",
)

if __name__ == "__main__":
    for program in PROGRAMS:
        print(program, flush=True)
        subprocess.run([sys.executable, Path(__file__).with_name(program)], check=True)
