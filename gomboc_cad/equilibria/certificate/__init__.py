"""Interval certificates: proofs in ball arithmetic that a body is mono-monostatic, or that it is not."""

from gomboc_cad.equilibria.certificate.checker import Verification, verify
from gomboc_cad.equilibria.certificate.document import dumps, load, loads
from gomboc_cad.equilibria.certificate.prover import certify
from gomboc_cad.equilibria.certificate.records import Certificate

__all__ = ["Certificate", "Verification", "certify", "dumps", "load", "loads", "verify"]
