"""The parts that a study is made of: a folder each, from its table to its figures."""
