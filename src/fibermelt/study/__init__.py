"""A study: all its tables, and the chain that computes what it asks for."""
