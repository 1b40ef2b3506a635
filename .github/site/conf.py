"""Settings of the site of the documentation, which Sphinx builds.

From the top of the repository: ``sphinx-build -W -c .github/site . build/site``.
"""

from importlib.metadata import version as version_of

project = "gyrodata"
version = version_of("gyrodata")
extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.napoleon"]
# The same pages as those of `gyro explain`, and three that only a site can have.
include_patterns = ["gyrodata/docs/*.md", ".github/site/*.md"]
root_doc = ".github/site/index"
myst_heading_anchors = 4
html_theme = "alabaster"
html_theme_options = {"description": "From a gyroscope log to a moment of inertia"}
autodoc_member_order = "bysource"
autodoc_typehints = "none"
# A link to a file that is no page, such as a sample log, is a download.
suppress_warnings = ["myst.xref_missing", "misc.highlighting_failure"]
