"""Each code of the reader is raised by its own example."""

import re
import shlex

import pandas as pd
import pytest

from gyrodata.diagnostics import CODES
from gyrodata.errors import GyroError
from gyrodata.readings import blank_log, read_log

LOG = b"mass [g],position [cm],spin [rpm],time [s],turns\n20,15.0,406,13.06,1/3\n"
FILES = {
    "log.csv": LOG,
    "eleven-megabytes.csv": b"1" * 11_000_000,
    "table-of-pandas": pd.DataFrame({"mass [g]": [20.0], "spin [rpm]": 406, "time [s]": 39.06, "position [cm]": 15.0}),
    "hundred-thousand-rows.csv": LOG + b"20,15,400,7,1\n" * 100_001,
}
MINE = sorted(code for code in CODES if re.match("G[1235]", code))


def options(words):
    """Read what follows the name of the log: --set, --map, --config."""
    found = {"settings": {}, "mapping": {}}
    for option, value in zip(words[::2], words[1::2], strict=True):
        key, _, text = value.partition("=")
        if option == "--config":
            found["config"] = value
        else:
            found[{"--set": "settings", "--map": "mapping"}[option]][key] = text
    return found


@pytest.mark.parametrize("code", MINE)
def test_the_example_raises_the_code(code, monkeypatch):
    example = CODES[code].example
    if example.startswith("template "):
        with pytest.raises(GyroError) as caught:
            blank_log(("20",), "15 cm", ("fast",))
        diagnostics = caught.value.diagnostics
        assert [diagnostic.code for diagnostic in diagnostics] == [code]
        return
    if example.startswith("analyze "):
        name, *rest = shlex.split(example)[1:]
        if name == "log.xlsx":
            pytest.skip("needs a workbook; see test_workbook_is_read_with_its_times")
        source, given = FILES.get(name, name), options(rest)
    else:
        source, given = example.encode("latin-1" if code in ("G107", "G109") else "utf-8"), {}
    try:
        diagnostics = read_log(source, **given).diagnostics
    except GyroError as error:
        diagnostics = error.diagnostics
    assert code in [diagnostic.code for diagnostic in diagnostics]
    for diagnostic in diagnostics:
        assert diagnostic.severity == CODES[diagnostic.code].severity
