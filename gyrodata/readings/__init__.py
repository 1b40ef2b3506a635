"""The reader makes `Readings` in SI from a lab log.

A log goes in: CSV, standard input, a workbook or a DataFrame. `Readings` come out: each
cell in SI with its place, and every fault of the log, found in one pass, with its place
and what to type. The reader accepts many forms, but it never guesses what would change
the answer. Nothing here knows how a gyroscope moves.
"""

from gyrodata.quantities.units import Uncertainty
from gyrodata.readings.cells import rounded_turns
from gyrodata.readings.completeness import without_wrong_runs
from gyrodata.readings.conversion import value_text
from gyrodata.readings.lablog import (
    Column,
    Faults,
    Place,
    Reading,
    Readings,
    Reported,
    listing,
)
from gyrodata.readings.reported import read_reported
from gyrodata.readings.roles import (
    SHARED_UNCERTAINTIES,
    as_u_of,
    check_value,
    kind_of_role,
    to_display,
    u_keys,
)
from gyrodata.readings.source import MAX_BYTES, decode
from gyrodata.readings.table import read_log
from gyrodata.readings.workbook import MAX_ROWS
from gyrodata.readings.writing import fixed_log, write_log
