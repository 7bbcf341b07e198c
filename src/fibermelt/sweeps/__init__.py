"""Many cases: what varies, who computes it, where it is kept, and what comes out."""
