"""Bringing the centre of mass of an assembly to its target."""
