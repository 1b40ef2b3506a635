"""A log with something of everything, and its page, for the tests of the page."""

from __future__ import annotations

from collections.abc import Mapping

from gyrodata import plotting, reporting
from gyrodata.results import Analysis

HEAD = "run,mass [g],position [cm],spin [rpm],time [s],turns,note\n"
LOG = (
    """# g: 9.803 m/s^2
# ball_mass: 4.10 ± 0.01 kg
# ball_diameter: 10.16 ± 0.005 cm
# group: <img src=x onerror=alert(1)> 77
"""
    + HEAD
    + """1,20.00,15.0,206,20.4,1,
2,20.00,15.0,407,40.4,1,
<b>3,20.00,15.0,601,59.5,1,"<script>alert('x')</script> & more 55"
4,40.00,15.0,203,10.2,1,
5,40.00,15.0,405,20.1,1,
6,40.00,15.0,607,30.1,2,
7,60.00,15.0,201,6.8,1,
8,60.00,15.0,404,13.4,1,
9,60.00,15.0,603,20.0,1,
10,0,,401,160.2,1/12,
"""
)
PIXEL = dict.fromkeys(plotting.FIGURES, b"\x89PNG\r\n")
WORDS = {name: f"what {name} shows" for name in plotting.FIGURES}


def make_page(analysis: Analysis, figures: Mapping[str, bytes] = PIXEL, alt: Mapping[str, str] = WORDS) -> str:
    return reporting.report_page(analysis, figures, "png", alt, plotting.list_looks(analysis))
