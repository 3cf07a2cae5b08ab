"""The source paper (arXiv 2604.17095 v1), reproduced and judged: each figure beside what is true."""

from gomboc_cad.paper.records import Row, Table, Verdict
from gomboc_cad.paper.registry import TABLES, reproduce
from gomboc_cad.paper.write import write_paper

__all__ = ["TABLES", "Row", "Table", "Verdict", "reproduce", "write_paper"]
