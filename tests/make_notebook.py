"""Write sample_data/notebook.ipynb anew: its cells are run in a new kernel, and what they show is stored with them."""

from __future__ import annotations

import sys
from pathlib import Path

from notebooks import NOTEBOOK, executed, written

if __name__ == "__main__":
    NOTEBOOK.write_text(written(executed(NOTEBOOK)), encoding="utf-8")
