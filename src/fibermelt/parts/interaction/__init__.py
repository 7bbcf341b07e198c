"""From fiber content to the interaction of fibers and the size of the cell."""
