"""One fiber in simple shear, as in the paper's section 2.3."""
