"""What the plane ellipse costs against a spheroid."""
