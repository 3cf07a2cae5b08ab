"""Solids: B-rep and mesh, hollow bodies, mass properties, files and their inspection."""
