"""The document objects: what a user sets, how it becomes a command line, what is shown of the answer."""
