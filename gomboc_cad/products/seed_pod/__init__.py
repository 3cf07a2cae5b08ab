"""The aerial seed pod."""
