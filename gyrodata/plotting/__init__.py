"""The four figures of a log, the charts of the benchmark and the figure of the Earth's rotation, with matplotlib.

`figure_data` collects the arrays that are drawn from an `Analysis`; `figures` draws them on axes of matplotlib and
describes them in words.
"""

from gyrodata.plotting.figure_data import Look, list_looks
from gyrodata.plotting.figures import FIGURES, SIZES, Form, alt_text, plot_on, render
