"""The four figures of a log, and the charts of the benchmark, with matplotlib.

`figure_data` collects the arrays that are drawn from an `Analysis`; `figures` draws
them on axes of matplotlib and describes them in words.
"""

from gyrodata.plotting.figure_data import Look, list_looks
from gyrodata.plotting.figures import (
    FIGURES,
    SIZES,
    Form,
    alt_text,
    omit_docstrings,
    plot_on,
    render,
)
