"""Flows from elsewhere: another solver's fields as one value, and the paths through them.

`read_field` turns a file into a `Field` on triangles or tetrahedra, in SI; `describe_field` says
what is in a file. What a path needs of a field is `Field.locate` and `Field.evaluate`.
"""

from __future__ import annotations
