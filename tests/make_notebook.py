"""Run the cells of sample_data/notebook.ipynb in a new kernel, and store their outputs."""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import Any

ROOT = Path(__file__).parent.parent
NOTEBOOK = ROOT / "sample_data" / "notebook.ipynb"

KERNEL = [
    # The bytes of figures are the same in every run.
    "--InlineBackend.figure_formats=svg",
    "--InlineBackend.rc=svg.hashsalt=gyrodata",
    "--InlineBackend.rc=svg.fonttype=none",
]


def executed(path: Path) -> dict[str, Any]:
    """Run a notebook in its folder, and return it with its outputs."""
    import nbformat
    from nbclient import NotebookClient

    notebook = nbformat.read(path, as_version=4)
    client = NotebookClient(
        notebook,
        kernel_name="python3",
        resources={"metadata": {"path": str(path.parent)}},
        extra_arguments=KERNEL,
        startup_timeout=300,
        timeout=300,
        record_timing=False,
    )
    # Figures do not contain the date.
    client.execute(
        env={**os.environ, "PYTHONPATH": str(ROOT), "SOURCE_DATE_EPOCH": "0"}
    )
    notebook.metadata["language_info"] = {"name": "python"}
    for cell in notebook.cells:
        for output in cell.get("outputs", ()):
            # A notebook shows the HTML; the report as Markdown would be most of the
            # file.
            output.get("data", {}).pop("text/markdown", None)
    return json.loads(nbformat.writes(notebook))  # type: ignore[no-any-return]


if __name__ == "__main__":
    NOTEBOOK.write_text(
        json.dumps(executed(NOTEBOOK), indent=1, ensure_ascii=False) + "\n",
        encoding="utf-8",
    )
