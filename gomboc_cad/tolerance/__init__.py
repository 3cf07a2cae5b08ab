"""The study before machining: variants of a product as made, how they rest, and what decides it."""
