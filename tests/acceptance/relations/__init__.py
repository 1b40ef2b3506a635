"""Relations between logs that mean the same; `RELATIONS` has all of them by name."""

from relations import containers, headers, layouts, values
from relations.log_tables import BASES, RELATIONS

__all__ = ["BASES", "RELATIONS", "containers", "headers", "layouts", "values"]
