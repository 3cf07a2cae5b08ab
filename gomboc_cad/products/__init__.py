"""Products: a typed spec each, and the recipe that turns it into parts, an assembly and a verdict."""
