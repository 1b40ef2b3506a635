"""The version of the program, which the build of the package reads too."""

__version__ = "1.0.0"
