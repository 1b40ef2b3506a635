"""Update the reference and the outputs in the README and in the pages of `gyro
explain`; read the difference.
"""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path

sys.path.append(str(Path(__file__).parent / "support"))

from documents import DOCUMENTS, cropped, typed
from python_page import reference

if __name__ == "__main__":
    for path in DOCUMENTS:
        text = reference(path.read_text(encoding="utf-8"))
        with tempfile.TemporaryDirectory() as folder:
            for command, shown, came, wrong in typed(text, Path(folder)):
                if wrong:
                    print(f"{path.name}: {command}: {wrong}")
                before = (
                    f"{command}```\n\n```text\n"
                    if "\n" in command
                    else f"$ {command}\n"
                )
                text = text.replace(
                    before + shown, f"{before}{cropped(came, shown)}\n", 1
                )
        path.write_text(text, encoding="utf-8")
