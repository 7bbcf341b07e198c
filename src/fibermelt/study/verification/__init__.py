"""The ladder of checks as a part of a study."""
