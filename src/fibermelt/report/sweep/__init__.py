"""The page of a sweep: what varied, what follows from it, which claims turn."""
