"""Write what the README and the pages of `gyro explain` show of their examples anew; read the difference."""

from __future__ import annotations

import tempfile
from pathlib import Path

from documents import DOCUMENTS, typed

if __name__ == "__main__":
    for path in DOCUMENTS:
        text = path.read_text(encoding="utf-8")
        with tempfile.TemporaryDirectory() as folder:
            for command, shown, came, wrong in typed(text, Path(folder)):
                if wrong:
                    print(f"{path.name}: {command}: {wrong}")
                before = f"{command}```\n\n```text\n" if "\n" in command else f"$ {command}\n"
                text = text.replace(before + shown, f"{before}{came.rstrip()}\n", 1)
        path.write_text(text, encoding="utf-8")
