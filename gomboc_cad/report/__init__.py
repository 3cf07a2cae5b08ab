"""Figures and tables for people: drawn from records, written as files."""
