"""Design of new bodies: searches that keep one stable and one unstable pose, and end with a proof."""

from gomboc_cad.search.design import Design, Figures, design_body, judge, search_method, write_body_file
from gomboc_cad.search.extended import Evolution
from gomboc_cad.search.harmonic import Programming
from gomboc_cad.search.objectives import OBJECTIVES, Goal

__all__ = [
    "OBJECTIVES",
    "Design",
    "Evolution",
    "Figures",
    "Goal",
    "Programming",
    "design_body",
    "judge",
    "search_method",
    "write_body_file",
]
