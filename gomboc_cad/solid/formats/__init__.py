"""Parsers of part files from anywhere: nothing a file claims of itself is believed unchecked."""
