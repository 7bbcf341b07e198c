"""The melt of a study: its card, its law, its temperature."""
